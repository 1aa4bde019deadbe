//! `--mixtures-out DIR`: Gamma and Theta as they entered Eq. 6, for `patrold distance` and other programs.

use super::failure::Failure;
use super::files;
use patrold_engine::mixture::MixtureRecord;
use patrold_engine::novelty::ComparedMixtures;
use std::fs;
use std::path::{Component, Path, PathBuf};

/// Of the reference and of the visit, as `ComparedMixtures` numbers them.
const FILES: [&str; 2] = ["gamma.json", "theta.json"];

/// Writes both mixtures into `dir`, which is created where it is missing.
pub(super) fn write(dir: &Path, compared: &ComparedMixtures) -> Result<(), Failure> {
    fs::create_dir_all(dir).map_err(|error| files::file_error(dir, error))?;
    for (side, name) in FILES.into_iter().enumerate() {
        let mixture = compared.mixture(side).map_err(Failure::failed)?;
        let text =
            serde_json::to_string(&MixtureRecord::from(&mixture)).map_err(Failure::failed)?;
        files::write(&dir.join(name), (text + "\n").as_bytes())?;
    }
    Ok(())
}

/// The folder of a pair of a manifest. Its name may be anything in the manifest, here it must be that of a folder.
pub(super) fn pair_folder(dir: &Path, name: &str) -> Result<PathBuf, Failure> {
    let mut parts = Path::new(name).components();
    match (parts.next(), parts.next()) {
        (Some(Component::Normal(folder)), None) if folder == name => Ok(dir.join(folder)),
        _ => Err(Failure::Failed(format!(
            "--mixtures-out: no folder can have the name of the pair {name:?}; rename the pair"
        ))),
    }
}

#[cfg(test)]
mod tests {
    use super::pair_folder;
    use std::path::Path;

    #[test]
    fn a_pair_writes_below_the_folder_alone() {
        let folder = |name| pair_folder(Path::new("out"), name).ok();
        assert_eq!(folder("quiet-1").as_deref(), Some(Path::new("out/quiet-1")));
        for name in ["", ".", "..", "/tmp", "a/b", "a/", "../a"] {
            assert_eq!(folder(name), None, "{name}");
        }
    }
}
