//! Changes the stored mixture of a reference behind the program's back, as `docs/contract.md` describes its form.
#![allow(dead_code, reason = "each test program uses a part")]

use nalgebra::Point3;
use patrold_engine::blob::{decode_mixture, encode_mixture};
use patrold_engine::novelty::ReferenceMixture;
use rusqlite::{Connection, params};
use sha2::{Digest, Sha256};
use std::path::Path;

fn open(store: &Path) -> Connection {
    Connection::open(store.join("patrold.db")).expect("the database opens")
}

/// Runs a statement.
pub(crate) fn execute(store: &Path, sql: &str) {
    let changed = open(store).execute(sql, []).expect("changed");
    assert!(changed > 0, "{sql}");
}

/// The mixture and the checksum of the newest reference.
pub(crate) fn read(store: &Path) -> (ReferenceMixture, Option<String>) {
    let sql = "SELECT mixture, mixture_sha256 FROM reference ORDER BY id DESC LIMIT 1";
    let row: (Vec<u8>, Option<String>) = open(store)
        .query_row(sql, [], |row| Ok((row.get(0)?, row.get(1)?)))
        .expect("a reference");
    (decode_mixture(&row.0).expect("a mixture"), row.1)
}

/// Puts a mixture in the place of that of the newest reference, with the checksum of its bytes or beside that of the old.
pub(crate) fn write(store: &Path, gamma: &ReferenceMixture, with_checksum: bool) {
    let bytes = encode_mixture(gamma);
    let digest = Sha256::digest(&bytes);
    let checksum: String = digest.iter().map(|byte| format!("{byte:02x}")).collect();
    let newest = "id = (SELECT max(id) FROM reference)";
    let sql = if with_checksum {
        format!("UPDATE reference SET mixture = ?1, mixture_sha256 = ?2 WHERE {newest}")
    } else {
        format!("UPDATE reference SET mixture = ?1 WHERE {newest} AND ?2 <> mixture_sha256")
    };
    let changed = open(store)
        .execute(&sql, params![bytes, checksum])
        .expect("changed");
    assert_eq!(changed, 1);
}

/// Takes out the components whose means are in the box; how many there were.
pub(crate) fn take_out(gamma: &mut ReferenceMixture, centre: [f64; 3], size: [f64; 3]) -> usize {
    let is_in = |p: &Point3<f64>| (0..3).all(|a| (p[a] - centre[a]).abs() <= 0.5 * size[a]);
    let kept: Vec<usize> = (0..gamma.mixture.len())
        .filter(|k| !is_in(&gamma.mixture.components[*k].mean))
        .collect();
    let taken = gamma.mixture.len() - kept.len();
    gamma.beams = kept.iter().map(|k| gamma.beams[*k]).collect();
    let mixture = &mut gamma.mixture;
    mixture.components = kept.iter().map(|k| mixture.components[*k]).collect();
    mixture.weights = kept.iter().map(|k| mixture.weights[*k]).collect();
    taken
}

/// Moves the whole mixture by `metres` along x.
pub(crate) fn shift(gamma: &mut ReferenceMixture, metres: f64) {
    for component in &mut gamma.mixture.components {
        component.mean.x += metres;
    }
}
