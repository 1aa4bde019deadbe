//! The command line in, manual pages (`man/`) and completions (`completions/`) out, and the documents (`doc/`) of the package.

use crate::documents;
use crate::synopsis::with_synopses;
use clap::{Command, CommandFactory as _};
use clap_complete::Shell;
use patrold::cli::Cli;
use std::fs;
use std::io;
use std::path::Path;

/// Foot of each page.
const SOURCE: &str = concat!("patrold ", env!("CARGO_PKG_VERSION"));
/// Begins each page: lines are not stretched to the margin, which would put two spaces into the name.
const LEFT_ALIGNED: &[u8] = b".ad l\n";
/// Shells whose completions are packaged.
pub(crate) const SHELLS: [Shell; 3] = [Shell::Bash, Shell::Zsh, Shell::Fish];

/// Writes one page for each command, one file for each shell, and the documents. Old ones are deleted: a command may be gone.
pub(crate) fn write_all(repository: &Path, folder: &Path) -> io::Result<()> {
    let [pages, documents] = ["man", "doc"].map(|name| folder.join(name));
    for old in [&pages, &documents] {
        if old.is_dir() {
            fs::remove_dir_all(old)?;
        }
        fs::create_dir_all(old)?;
    }
    write_pages(
        with_synopses(Cli::command().disable_help_subcommand(true)),
        &pages,
    )?;
    documents::write_all(repository, &documents)?;
    let completions = folder.join("completions");
    fs::create_dir_all(&completions)?;
    for shell in SHELLS {
        clap_complete::generate_to(shell, &mut Cli::command(), "patrold", &completions)?;
    }
    Ok(())
}

fn write_pages(command: Command, folder: &Path) -> io::Result<()> {
    let inner = command
        .get_subcommands()
        .filter(|inner| !inner.is_hide_set());
    for inner in inner.cloned() {
        write_pages(inner, folder)?;
    }
    let page = clap_mangen::Man::new(command).source(SOURCE);
    let mut text = Vec::new();
    page.render(&mut text)?;
    let text = LEFT_ALIGNED
        .iter()
        .chain(&text)
        .copied()
        .collect::<Vec<u8>>();
    fs::write(folder.join(page.get_filename()), text)?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::write_all;
    use clap::{Command, CommandFactory as _};
    use patrold::cli::Cli;
    use patrold_test_support::workspace_root;
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
        write_all(&workspace_root(), folder.path()).expect("written");

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
        let section = |title: &str| {
            let after = visit.split_once(&format!(".SH {title}\n")).expect(title).1;
            after
                .split(".SH")
                .next()
                .unwrap_or_default()
                .trim()
                .to_owned()
        };
        let title = visit.lines().find(|line| line.starts_with(".TH"));
        let foot = format!("\"patrold {}\"", env!("CARGO_PKG_VERSION"));
        assert!(title.is_some_and(|line| line.contains(&foot)), "{title:?}");
        assert!(visit.starts_with(".ad l\n"), "not stretched");
        assert!(!section("NAME").contains("  "), "{:?}", section("NAME"));
        let synopsis = section("SYNOPSIS").replace('\\', "");
        assert!(
            synopsis.contains("[--config FILE]") && synopsis.contains(" NAME"),
            "{synopsis:?}"
        );
    }
}
