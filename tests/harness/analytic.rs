//! Small analytic scenes: rays against boxes and balls, with known noise and changes.
#![allow(dead_code, reason = "each test program uses a part")]

use nalgebra::{Point3, Unit, Vector3};
use patrold_engine::geometry::{NoiseLaw, Pose, RollPitchYaw, View};
use patrold_engine::novelty::{Detection, NoveltySettings, Reference, detect};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

#[derive(Clone, Copy)]
pub(crate) enum AnalyticSolid {
    /// Centre, radius.
    Ball([f64; 3], f64),
    /// Lowest and highest corner.
    Block([f64; 3], [f64; 3]),
}

/// Directions in which a sensor measures.
#[derive(Clone, Copy, Debug)]
pub(crate) enum ScanPattern {
    /// URG-04LX on a tilt unit: 683 beams over 240 deg, lines this many degrees apart.
    Tilted(f64),
    /// 16 rings 2 deg apart, 0.4 deg along.
    Rings,
    /// A grid of 57 x 43 deg, as of a depth camera.
    Camera,
    /// 400 directions all around.
    Sparse,
}

/// A closed room with solids in it.
pub(crate) struct AnalyticScene {
    /// Lowest and highest corner of the inside.
    pub room: ([f64; 3], [f64; 3]),
    pub solids: Vec<AnalyticSolid>,
}

/// 6 m x 4.4 m x 2.6 m, sensor at the origin half a metre above the floor, some furniture.
pub(crate) fn furnished_room() -> AnalyticScene {
    AnalyticScene {
        room: ([-2.5, -2.0, -0.5], [3.5, 2.4, 2.1]),
        solids: vec![
            AnalyticSolid::Block([1.5, 1.6, -0.5], [2.7, 2.4, 1.4]),
            AnalyticSolid::Block([2.6, -2.0, -0.5], [3.5, -1.1, 0.3]),
            AnalyticSolid::Ball([-1.5, -1.3, -0.1], 0.4),
        ],
    }
}

impl AnalyticScene {
    /// Adds a solid.
    pub(crate) fn with(mut self, solid: AnalyticSolid) -> Self {
        self.solids.push(solid);
        self
    }

    /// Distance to the first surface from `o` along the unit vector `d`.
    pub(crate) fn range(&self, o: &Point3<f64>, d: &Vector3<f64>) -> f64 {
        let slab = |low: &[f64; 3], high: &[f64; 3]| {
            let (mut near, mut far) = (f64::NEG_INFINITY, f64::INFINITY);
            for axis in 0..3 {
                let (a, b) = (
                    (low[axis] - o[axis]) / d[axis],
                    (high[axis] - o[axis]) / d[axis],
                );
                near = near.max(a.min(b));
                far = far.min(a.max(b));
            }
            (near, far)
        };
        let mut range = slab(&self.room.0, &self.room.1).1;
        for solid in &self.solids {
            match solid {
                AnalyticSolid::Block(low, high) => {
                    let (near, far) = slab(low, high);
                    if near < far && near > 0.0 {
                        range = range.min(near);
                    }
                }
                AnalyticSolid::Ball(centre, radius) => {
                    let to = Point3::from(*centre) - o;
                    let along = to.dot(d);
                    let off2 = to.norm_squared() - along * along;
                    if off2 < radius * radius && along > 0.0 {
                        range = range.min(along - (radius * radius - off2).sqrt());
                    }
                }
            }
        }
        range
    }

    /// View of a sensor at `pose`, in its own frame; `reach_m` is its longest range.
    pub(crate) fn scan(
        &self,
        pattern: ScanPattern,
        pose: &Pose,
        noise: NoiseLaw,
        reach_m: f64,
        seed: u64,
    ) -> View {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut view = View::from_points(Vec::new(), Point3::origin());
        for d in directions(pattern, &mut rng) {
            let r = self.range(&(pose * Point3::origin()), &(pose * d));
            let gauss: f64 = StandardNormal.sample(&mut rng);
            let flicker = rng.random_range(0.0..1.0) < 0.03;
            if r > reach_m || flicker {
                if reach_m.is_finite() {
                    view.no_return.push(Unit::new_normalize(d));
                }
                continue;
            }
            view.points
                .push(Point3::from(d * (r + gauss * noise.sigma_m(r))));
        }
        if reach_m.is_finite() {
            view.free_range_m = 0.9 * reach_m;
        }
        view
    }
}

/// Unit vectors in the sensor's frame.
pub(crate) fn directions(pattern: ScanPattern, rng: &mut ChaCha8Rng) -> Vec<Vector3<f64>> {
    let mut all = Vec::new();
    // Each sweep starts at a slightly different angle.
    let (a, b): (f64, f64) = (rng.random_range(0.0..1.0), rng.random_range(0.0..1.0));
    let from = |az: f64, el: f64| {
        let (az, el) = (az.to_radians(), el.to_radians());
        Vector3::new(el.cos() * az.cos(), el.cos() * az.sin(), el.sin())
    };
    match pattern {
        ScanPattern::Tilted(pitch) => {
            let lines = (70.0 / pitch) as i32;
            for line in 0..lines {
                let tilt = (-35.0 + (f64::from(line) + a) * pitch).to_radians();
                for beam in 0..683 {
                    let d = from(-120.0 + f64::from(beam) * 0.3515, 0.0);
                    all.push(Vector3::new(d.x * tilt.cos(), d.y, d.x * tilt.sin()));
                }
            }
        }
        ScanPattern::Rings => {
            for ring in -8..8 {
                for step in 0..900 {
                    all.push(from(
                        (f64::from(step) + a) * 0.4,
                        f64::from(ring) * 2.0 + 1.0,
                    ));
                }
            }
        }
        ScanPattern::Camera => {
            for u in 0..160 {
                for v in 0..120 {
                    all.push(
                        Vector3::new(
                            1.0,
                            (f64::from(u) + a - 80.0) / 80.0 * 0.543,
                            (f64::from(v) + b - 60.0) / 60.0 * 0.394,
                        )
                        .normalize(),
                    );
                }
            }
        }
        ScanPattern::Sparse => {
            for i in 0..400 {
                let z = 1.0 - 2.0 * (f64::from(i) + a) / 400.0;
                let az = f64::from(i) * 2.399_963 + b;
                let r = (1.0 - z * z).max(0.0).sqrt();
                all.push(Vector3::new(r * az.cos(), r * az.sin(), z));
            }
        }
    }
    all
}

/// Noise of the recorded URG-04LX data.
pub(crate) const URG_NOISE: NoiseLaw = NoiseLaw {
    at_zero_m: 0.005,
    per_m: 0.003,
};
pub(crate) const COARSE_NOISE: NoiseLaw = NoiseLaw {
    at_zero_m: 0.03,
    per_m: 0.0,
};

pub(crate) fn at_origin() -> Pose {
    Pose::identity()
}

/// Metres and degrees.
pub(crate) fn planar_pose(x: f64, y: f64, yaw_deg: f64) -> Pose {
    RollPitchYaw {
        roll_rad: 0.0,
        pitch_rad: 0.0,
        yaw_rad: yaw_deg.to_radians(),
    }
    .with_translation([x, y, 0.0])
}

/// Compares with the default settings and prints the numbers to stderr.
pub(crate) fn compare(reference: &View, current: &View) -> Detection {
    compare_with(reference, current, &NoveltySettings::default())
}

pub(crate) fn compare_with(
    reference: &View,
    current: &View,
    settings: &NoveltySettings,
) -> Detection {
    let reference = Reference::prepare(reference, settings, 1).expect("a reference");
    let detection = detect(&reference, current, settings, 1, &mut |_| {}).expect("a detection");
    eprintln!(
        "    {:?} {} | t {:.3} rot {:.2} share {:.2} {:?} overlap {:.2?} noise {:?}",
        detection.verdict,
        detection.reason,
        detection
            .registration
            .current_from_reference
            .translation
            .vector
            .norm(),
        detection
            .registration
            .current_from_reference
            .rotation
            .angle()
            .to_degrees(),
        detection.registration.agreement,
        detection.registration.unobservable,
        detection.overlap,
        detection.noise[1]
    );
    for n in &detection.novelties {
        eprintln!(
            "        {:?} n {} support {:.0} mass {:.5} contribution {:.5} moved {:?} at {:.2?} extent {:.2?}",
            n.kind,
            n.point_indices.len(),
            n.support,
            n.mass,
            n.contribution,
            n.moved_from,
            n.moments.mean.coords.as_slice(),
            n.extent_m
        );
    }
    let parts: f64 = detection.novelties.iter().map(|n| n.contribution).sum();
    assert!((parts + detection.unexplained - detection.d_gmm).abs() < 1e-9);
    detection
}
