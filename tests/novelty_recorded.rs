//! The engine against recorded pairs: what changed is found, what did not stays quiet.

use nalgebra::Point3;
use patrold::geometry::{Pose, RollPitchYaw, View};
use patrold::novelty::{Detection, Kind, Reference, Settings, Verdict, detect};
use std::path::{Path, PathBuf};
use std::time::Instant;

fn data() -> Option<PathBuf> {
    let root = std::env::var_os("PATROLD_DATA").map_or_else(
        || Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/data"),
        PathBuf::from,
    );
    if root.join("semisynthetic").is_dir() {
        return Some(root);
    }
    assert!(
        std::env::var_os("PATROLD_REQUIRE_DATA").is_none_or(|v| v != "1"),
        "no recorded data at {}",
        root.display()
    );
    eprintln!("skipped: no recorded data at {}", root.display());
    None
}

fn ply(path: &Path) -> Vec<Point3<f64>> {
    let bytes = std::fs::read(path).expect("a readable file");
    let end = b"end_header\n";
    let at = bytes
        .windows(end.len())
        .position(|w| w == end)
        .expect("a header")
        + end.len();
    bytes[at..]
        .chunks_exact(12)
        .map(|c| {
            let f = |i: usize| {
                f64::from(f32::from_le_bytes(
                    c[i..i + 4].try_into().expect("four bytes"),
                ))
            };
            Point3::new(f(0), f(4), f(8))
        })
        .collect()
}

fn labels(path: &Path) -> Vec<u8> {
    std::fs::read_to_string(path)
        .expect("a readable file")
        .lines()
        .map(|l| l.trim().parse().expect("a label"))
        .collect()
}

fn moved(x: f64, y: f64, yaw_deg: f64) -> Pose {
    RollPitchYaw {
        roll_rad: 0.0,
        pitch_rad: 0.0,
        yaw_rad: yaw_deg.to_radians(),
    }
    .with_translation([x, y, 0.0])
}

fn run(
    name: &str,
    reference: &View,
    current: &View,
    novel: impl Fn(usize) -> Option<bool>,
) -> Detection {
    let settings = Settings::default();
    let t = Instant::now();
    let r = Reference::prepare(reference, &settings, 1).expect("a reference");
    let t1 = t.elapsed().as_millis();
    let mut stages = Vec::new();
    let f = detect(&r, current, &settings, 1, &mut |s| {
        stages.push((s, t.elapsed().as_millis()))
    })
    .expect("a detection");
    let end = t.elapsed().as_millis();
    let times: Vec<String> = stages
        .iter()
        .enumerate()
        .map(|(i, (s, at))| format!("{s:?} {}", stages.get(i + 1).map_or(end, |n| n.1) - at))
        .collect();
    let (mut tp, mut fp, mut fnn) = (0, 0, 0);
    for (i, h) in f.labels.iter().enumerate() {
        match (novel(i), h) {
            (Some(true), true) => tp += 1,
            (Some(false), true) => fp += 1,
            (Some(true), false) => fnn += 1,
            _ => {}
        }
    }
    let tr = f.registration.current_from_reference;
    let count = |k: Kind| f.novelties.iter().filter(|n| n.kind == k).count();
    println!(
        "{name:22} {:?} d {:.5} rest {:.5} work {:.4} app {:2} dis {:2} prec {:.3} rec {:.3} | t {:.4} rot {:.3}deg share {:.2} {:?} | comps {:?} overlap {:.2} {:.2} | {} | ref {t1} {}",
        f.verdict,
        f.d_gmm,
        f.unexplained,
        f.work_m3,
        count(Kind::Appeared),
        count(Kind::Disappeared),
        f64::from(tp) / f64::from((tp + fp).max(1)),
        f64::from(tp) / f64::from((tp + fnn).max(1)),
        tr.translation.vector.norm(),
        tr.rotation.angle().to_degrees(),
        f.registration.share,
        f.registration.unobservable,
        f.components,
        f.overlap[0],
        f.overlap[1],
        f.reason,
        times.join(" "),
    );
    if std::env::var_os("SHOW").is_some() {
        for n in &f.novelties {
            println!(
                "    {:?} n {} support {:.0} mass {:.5} contribution {:.5} moved {:?} at {:.2?} extent {:.2?} comps {}",
                n.kind,
                n.points.len(),
                n.support,
                n.mass,
                n.contribution,
                n.moved_from,
                n.moments.mean.coords.as_slice(),
                n.extent_m,
                n.mixture.len()
            );
        }
    }
    f
}

fn json(path: &Path) -> serde_json::Value {
    serde_json::from_str(&std::fs::read_to_string(path).expect("a manifest")).expect("json")
}

#[test]
fn semisynthetic() {
    let Some(root) = data() else { return };
    let root = root.join("semisynthetic");
    let manifest = json(&root.join("manifest_dev.json"));
    for pair in manifest["pairs"].as_array().expect("pairs") {
        let file = |key: &str| root.join(pair[key].as_str().expect("a path"));
        let reference = View::bare(ply(&file("reference")), Point3::origin());
        let current = View::bare(ply(&file("current")), Point3::origin());
        let truth = labels(&file("labels"));
        let name = pair["name"].as_str().expect("a name");
        for (x, y, yaw) in [(0.0, 0.0, 0.0), (0.02, -0.022, 1.0), (-0.08, 0.06, -5.0)] {
            if yaw != 0.0 && std::env::var_os("POSE").is_none() {
                continue;
            }
            let origin = if std::env::var_os("ORIGIN0").is_some() {
                Point3::origin()
            } else {
                moved(x, y, yaw) * Point3::origin()
            };
            run(
                name,
                &reference,
                &View::bare(moved(x, y, yaw).transform_all(&current.points), origin),
                |i| Some(truth[i] > 0),
            );
        }
    }
}

trait All {
    fn transform_all(&self, p: &[Point3<f64>]) -> Vec<Point3<f64>>;
}
impl All for Pose {
    fn transform_all(&self, p: &[Point3<f64>]) -> Vec<Point3<f64>> {
        p.iter().map(|p| self * p).collect()
    }
}

#[test]
fn spherecalib() {
    let Some(root) = data() else { return };
    let root = root.join("spherecalib/dev");
    let meta = json(&root.join("meta.json"));
    for pair in meta["pairs"].as_array().expect("pairs") {
        let file = |key: &str| root.join(pair[key].as_str().expect("a path"));
        let reference = View::bare(ply(&file("reference")), Point3::origin());
        let current = View::bare(ply(&file("current")), Point3::origin());
        let name = pair["current"].as_str().expect("a name").to_owned()
            + pair["reference"].as_str().expect("n");
        let truth = if pair["labels"].is_string() {
            labels(&file("labels"))
        } else {
            vec![0; current.points.len()]
        };
        run(&name, &reference, &current, |i| match truth[i] {
            0 => Some(false),
            1 => Some(true),
            _ => None,
        });
    }
    for k in 0..2 {
        let reference = View::bare(
            ply(&root.join(format!("nochange{k}_ref.ply"))),
            Point3::origin(),
        );
        let current = View::bare(
            ply(&root.join(format!("nochange{k}_cur.ply"))),
            Point3::origin(),
        );
        run("nochange", &reference, &current, |_| Some(false));
    }
}

#[test]
fn viewpoint() {
    let Some(root) = data() else { return };
    let root = root.join("viewpoint_nochange");
    let manifest = json(&root.join("manifest_dev.json"));
    for pair in manifest["pairs"].as_array().expect("pairs") {
        let file = |key: &str| root.join(pair[key].as_str().expect("a path"));
        let o = |key: &str| {
            let a = pair[key].as_array().expect("origin");
            Point3::new(
                a[0].as_f64().expect("n"),
                a[1].as_f64().expect("n"),
                a[2].as_f64().expect("n"),
            )
        };
        let reference = View::bare(ply(&file("reference")), o("ref_sensor"));
        let current = View::bare(ply(&file("current")), o("cur_sensor"));
        run(
            pair["name"].as_str().expect("n"),
            &reference,
            &current,
            |_| Some(false),
        );
    }
}
