//! The documents of the package: those of the repository, with links that lead somewhere once they are installed.

use std::fs;
use std::io;
use std::path::{Component, Path, PathBuf};

/// Folders whose documents are packaged, in the repository and below [`INSTALLED`].
const FOLDERS: [&str; 3] = ["", "docs", "docs/protocols"];
/// Documents of the first of them; of the others all are.
const IN_FIRST: [&str; 1] = ["README.md"];
/// Where documents are installed.
#[cfg(test)]
pub(crate) const INSTALLED: &str = "usr/share/doc/patrold";
/// Packaged beside the documents as they are.
const PICTURES: &str = "docs/pictures";
/// What is installed elsewhere: path in the repository, and there.
const ELSEWHERE: [(&str, &str); 3] = [
    ("config/patrold.toml", "/etc/patrold/patrold.toml"),
    ("docs/schema", "/usr/share/patrold/schema"),
    ("CHANGELOG.md", "/usr/share/doc/patrold/changelog.gz"),
];

/// Writes the documents of `repository` into `folder`, in the same tree.
pub(crate) fn write_all(repository: &Path, folder: &Path) -> io::Result<()> {
    for (number, of) in FOLDERS.iter().enumerate() {
        fs::create_dir_all(folder.join(of))?;
        for name in documents(&repository.join(of), number == 0)? {
            let path = Path::new(of).join(name);
            let text = fs::read_to_string(repository.join(&path))?;
            let text = with_links_of_package(repository, &path, &text);
            fs::write(folder.join(&path), text)?;
        }
    }
    Ok(())
}

fn documents(folder: &Path, is_first: bool) -> io::Result<Vec<String>> {
    let mut names = Vec::new();
    for entry in fs::read_dir(folder)? {
        let name = entry?.file_name().to_string_lossy().into_owned();
        if name.ends_with(".md") && (!is_first || IN_FIRST.contains(&name.as_str())) {
            names.push(name);
        }
    }
    names.sort();
    Ok(names)
}

/// A link to what is not packaged becomes its text.
fn with_links_of_package(repository: &Path, document: &Path, text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    let mut rest = text;
    while let Some((before, after)) = rest.split_once("](") {
        let Some((target, after)) = after.split_once(')') else {
            break;
        };
        match link_of_package(repository, document, target) {
            Some(link) => out.push_str(&format!("{before}]({link})")),
            None => {
                out.push_str(before);
                if let Some(open) = out.rfind('[') {
                    out.remove(open);
                }
            }
        }
        rest = after;
    }
    out + rest
}

/// The target as a document of the package has it; `None`: it is not there.
fn link_of_package(repository: &Path, document: &Path, target: &str) -> Option<String> {
    if target.starts_with('#') || target.contains("://") {
        return Some(target.to_owned());
    }
    let (file, anchor) = target.split_once('#').unwrap_or((target, ""));
    let path = normalized(&document.parent()?.join(file));
    for (of, installed) in ELSEWHERE {
        if let Ok(below) = path.strip_prefix(of) {
            let found = Path::new(installed).join(below);
            return Some(found.to_string_lossy().trim_end_matches('/').to_owned());
        }
    }
    let folder = path.parent()?.to_str()?;
    let name = path.file_name()?.to_str()?;
    let is_document = match folder {
        "" => IN_FIRST.contains(&name),
        _ => FOLDERS.contains(&folder) && name.ends_with(".md"),
    };
    let is_folder = !path.as_os_str().is_empty() && FOLDERS.iter().any(|of| path == Path::new(of));
    let is_packaged = is_document || is_folder || folder == PICTURES;
    let there = is_packaged && repository.join(&path).exists();
    there.then(|| match anchor {
        "" => file.to_owned(),
        anchor => format!("{file}#{anchor}"),
    })
}

/// Without `..`.
fn normalized(path: &Path) -> PathBuf {
    let mut found = PathBuf::new();
    for part in path.components() {
        match part {
            Component::ParentDir => drop(found.pop()),
            part => found.push(part),
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::with_links_of_package;
    use patrold_test_support::workspace_root;
    use std::path::Path;

    #[test]
    fn links_lead_to_what_is_installed_or_are_text() {
        let at = |document: &str, text: &str| {
            with_links_of_package(&workspace_root(), Path::new(document), text)
        };
        assert_eq!(
            at(
                "README.md",
                "A [b](docs/faults.md), a [`c`](engine), [d](docs/protocols) and ![e](docs/pictures/person.svg)."
            ),
            "A [b](docs/faults.md), a `c`, [d](docs/protocols) and ![e](docs/pictures/person.svg)."
        );
        assert_eq!(
            at(
                "README.md",
                "[a](config/patrold.toml), [b](CONTRIBUTING.md#package) [c](https://a.invalid/x)"
            ),
            "[a](/etc/patrold/patrold.toml), b [c](https://a.invalid/x)"
        );
        assert_eq!(
            at(
                "docs/contract.md",
                "[a](schema/fit.json) [b](schema) [c](../README.md) [d](novelty.md#x) [e](#y) [f](gone.md)"
            ),
            "[a](/usr/share/patrold/schema/fit.json) [b](/usr/share/patrold/schema) [c](../README.md) [d](novelty.md#x) [e](#y) f"
        );
    }
}
