//! The command line in, manual pages (`man/`) and completions (`completions/`) out.

use clap::CommandFactory as _;
use clap_complete::Shell;
use patrold::cli::Cli;
use std::fs;
use std::io;
use std::path::Path;

/// Shells whose completions are packaged.
pub(crate) const SHELLS: [Shell; 3] = [Shell::Bash, Shell::Zsh, Shell::Fish];

/// Writes one page for each command and one file for each shell. Old pages are deleted: a command may be gone.
pub(crate) fn write_all(folder: &Path) -> io::Result<()> {
    let pages = folder.join("man");
    if pages.is_dir() {
        fs::remove_dir_all(&pages)?;
    }
    fs::create_dir_all(&pages)?;
    clap_mangen::generate_to(Cli::command(), &pages)?;
    let completions = folder.join("completions");
    fs::create_dir_all(&completions)?;
    for shell in SHELLS {
        clap_complete::generate_to(shell, &mut Cli::command(), "patrold", &completions)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::write_all;
    use clap::{Command, CommandFactory as _};
    use patrold::cli::Cli;
    use std::collections::BTreeSet;
    use std::fs;

    /// Each command with its commands, as `patrold alarms list`; hidden ones and `help` have no page.
    fn commands(command: &Command, parent: &str, found: &mut Vec<String>) {
        let name = format!("{parent}{}", command.get_name());
        for inner in command.get_subcommands() {
            if !inner.is_hide_set() && inner.get_name() != "help" {
                commands(inner, &format!("{name} "), found);
            }
        }
        found.push(name);
    }

    #[test]
    fn every_command_has_its_page_and_its_completions() {
        let folder = tempfile::tempdir().expect("a folder");
        let stale = folder.path().join("man/patrold-gone.1");
        fs::create_dir_all(folder.path().join("man")).expect("a folder");
        fs::write(&stale, "").expect("written");
        write_all(folder.path()).expect("written");

        let mut all = Vec::new();
        commands(&Cli::command(), "", &mut all);
        assert!(all.iter().any(|name| name == "patrold alarms list"));
        let expected: BTreeSet<String> = all
            .iter()
            .map(|name| format!("{}.1", name.replace(' ', "-")))
            .collect();
        let pages: BTreeSet<String> = fs::read_dir(folder.path().join("man"))
            .expect("pages")
            .flatten()
            .map(|entry| entry.file_name().to_string_lossy().into_owned())
            .collect();
        assert_eq!(pages, expected);

        let completions = folder.path().join("completions");
        for file in ["patrold.bash", "_patrold", "patrold.fish"] {
            let text = fs::read_to_string(completions.join(file)).expect(file);
            for name in &all {
                let last = name.rsplit(' ').next().expect("a name");
                assert!(text.contains(last), "{file}: {name}");
            }
        }
        let visit = fs::read_to_string(folder.path().join("man/patrold-visit.1")).expect("a page");
        assert!(visit.contains("Inspect waypoint NAME") && visit.contains("\\-\\-json"));
    }
}
