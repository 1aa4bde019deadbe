//! Files that are not what they should be, and outputs that cannot be written.

use crate::bad_input::check_failures;

#[test]
fn clouds_that_cannot_be_read() {
    check_failures(&[
        (
            &["compare", "missing.ply", "good.ply"],
            1,
            &["missing.ply", "check the path"],
        ),
        (
            &["compare", "good.ply", "missing.ply"],
            1,
            &["missing.ply", "check the path"],
        ),
        (
            &["compare", "good.ply", "empty.ply"],
            1,
            &["empty.ply", "empty file", "expected a PLY"],
        ),
        (
            &["compare", "good.ply", "none.ply"],
            1,
            &["none.ply", "no finite point", "again"],
        ),
        (
            &["compare", "none.ply", "good.ply"],
            1,
            &["none.ply", "no finite point"],
        ),
        (
            &["compare", "prose.txt", "good.ply"],
            1,
            &["prose.txt", "line 1", "expected"],
        ),
        (
            &["compare", "prose.ply", "good.ply"],
            1,
            &["prose.ply", "line 1", "expected"],
        ),
        (
            &["compare", "good.ply", "nan.ply"],
            1,
            &["nan.ply", "no finite point among 5"],
        ),
        (
            &["compare", "good.ply", "cut.ply"],
            1,
            &["cut.ply", "expected"],
        ),
        (
            &["compare", "good.ply", "folder"],
            1,
            &["folder", "is a folder"],
        ),
        (&["fit", "missing.ply"], 1, &["missing.ply"]),
        (&["fit", "nan.ply"], 1, &["nan.ply", "no finite point"]),
        (
            &["fit", "three.ply", "--components", "9"],
            1,
            &["three.ply"],
        ),
        (&["shapes", "prose.ply"], 1, &["prose.ply"]),
        (&["shapes", "three.ply"], 1, &["three.ply"]),
    ]);
}

#[test]
fn outputs_that_cannot_be_written() {
    check_failures(&[
        (
            &[
                "compare",
                "good.ply",
                "good.ply",
                "--labels-out",
                "no/such/l.txt",
            ],
            1,
            &["no/such/l.txt", "create it"],
        ),
        (
            &["compare", "good.ply", "good.ply", "--labels-out", "folder"],
            1,
            &["folder"],
        ),
        (
            &[
                "compare",
                "good.ply",
                "good.ply",
                "--novelty-out",
                "no/n.ply",
            ],
            1,
            &["no/n.ply"],
        ),
        (
            &[
                "compare",
                "good.ply",
                "good.ply",
                "--json",
                "--labels-out",
                "/proc/l.txt",
            ],
            1,
            &["/proc/l.txt"],
        ),
        (
            &[
                "alarms",
                "export",
                "--config",
                "ours.toml",
                "--out",
                "no/a.jsonl",
            ],
            1,
            &["no/a.jsonl"],
        ),
    ]);
}

#[test]
fn mixtures_that_cannot_be_read() {
    check_failures(&[
        (
            &["distance", "missing.json", "missing.json"],
            1,
            &["missing.json"],
        ),
        (&["distance", "list.json", "list.json"], 1, &["list.json"]),
        (&["fuse", "flat.json", "missing.json"], 1, &["missing.json"]),
        (&["fuse", "list.json", "flat.json"], 1, &["list.json"]),
        (
            &["fuse", "flat.json", "beamless.json"],
            1,
            &["beamless.json", "beams of component 0"],
        ),
        (&["distance", "cut.json", "cut.json"], 1, &["cut.json"]),
        (
            &["distance", "short.json", "short.json"],
            1,
            &["short.json"],
        ),
        (
            &["fit", "good.ply", "--init", "prose.txt"],
            1,
            &["prose.txt"],
        ),
        (
            &["fit", "good.ply", "--init", "negative.json"],
            1,
            &["negative.json"],
        ),
        (
            &["fit", "good.ply", "--tolerance", "nan"],
            2,
            &["--tolerance"],
        ),
        (&["shapes", "good.ply", "--epsilon", "0"], 2, &["--epsilon"]),
        (
            &["shapes", "good.ply", "--points", "--method", "covariance"],
            2,
            &["--points", "--method covariance"],
        ),
    ]);
}

#[test]
fn manifests_that_cannot_be_read() {
    check_failures(&[
        (
            &["compare", "--manifest", "missing.json"],
            1,
            &["missing.json"],
        ),
        (&["compare", "--manifest", "prose.txt"], 1, &["prose.txt"]),
        (&["compare", "--manifest", "list.json"], 1, &["list.json"]),
        (
            &["compare", "--manifest", "flat.json"],
            1,
            &["flat.json", "pairs"],
        ),
        (&["compare", "--manifest", "folder"], 1, &["folder"]),
    ]);
}
