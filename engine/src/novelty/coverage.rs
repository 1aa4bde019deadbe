//! How much of the reference a visit could judge (`docs/novelty.md section 9`).

use super::constants::{BEARING_BIN_DEG, COVERAGE_SAMPLES, NAMED_BEARINGS};
use super::{PreparedView, Visibility};
use crate::geometry::Pose;

/// How much of the reference a visit could judge.
#[derive(Debug, Clone, PartialEq)]
pub struct Coverage {
    /// Share of the reference's visible surface, 0 to 1.
    pub surface: f64,
    /// Share of the solid angle in which the reference saw something, 0 to 1.
    pub solid_angle: f64,
    /// What is missing and why, one line; empty where hardly anything is.
    pub missing: String,
}

impl Coverage {
    /// The coverage of `reference` by a visit that saw its points with these `visibilities` and could judge the share `surface` of
    /// its surface. Bearings are those of the visit.
    pub(super) fn new(
        reference: &PreparedView,
        visibilities: &[Visibility],
        surface: f64,
        current_from_reference: &Pose,
    ) -> Self {
        // Also where views do not match; the density of beams may be costly in a view that is none.
        if visibilities.iter().all(|v| *v == Visibility::OutOfView) {
            return Self {
                surface,
                solid_angle: 0.0,
                missing: "everything".to_owned(),
            };
        }
        let points = &reference.view.points;
        let step = points.len().div_ceil(COVERAGE_SAMPLES).max(1);
        let mut sums = SolidAngles::default();
        for (p, visibility) in points.iter().zip(visibilities).step_by(step) {
            let Some(d) = (p - reference.view.origin).try_normalize(1e-9) else {
                continue;
            };
            // A beam stands for the solid angle that the beams around it leave to it.
            let angle_sr = 1.0 / reference.rays.density_per_sr(&d).max(1.0);
            let seen_from = current_from_reference * d;
            sums.add(angle_sr, seen_from.y.atan2(seen_from.x), *visibility);
        }
        Self {
            surface,
            solid_angle: sums.judged_share(),
            missing: sums.missing(),
        }
    }
}

/// Solid angles in which the reference saw something, by how the visit saw it.
struct SolidAngles {
    judged_sr: f64,
    hidden_sr: f64,
    /// Not looked at, and all, by the visit's bearing.
    bearings_sr: Vec<[f64; 2]>,
}

impl Default for SolidAngles {
    fn default() -> Self {
        Self {
            judged_sr: 0.0,
            hidden_sr: 0.0,
            bearings_sr: vec![[0.0; 2]; (360.0 / BEARING_BIN_DEG) as usize],
        }
    }
}

impl SolidAngles {
    fn add(&mut self, angle_sr: f64, bearing_rad: f64, visibility: Visibility) {
        let turn = bearing_rad / std::f64::consts::TAU + 0.5;
        let bins = self.bearings_sr.len();
        let bin = &mut self.bearings_sr[((turn * bins as f64) as usize).min(bins - 1)];
        match visibility {
            // Nobody asks about it.
            Visibility::OutOfRange => return,
            Visibility::OnSurface | Visibility::FreeSpace => self.judged_sr += angle_sr,
            Visibility::Occluded => self.hidden_sr += angle_sr,
            Visibility::OutOfView => bin[0] += angle_sr,
        }
        bin[1] += angle_sr;
    }

    fn all_sr(&self) -> f64 {
        self.bearings_sr.iter().map(|[_, all]| all).sum()
    }

    /// Zero where there is nothing to judge.
    fn judged_share(&self) -> f64 {
        let all_sr = self.all_sr();
        if all_sr > 0.0 {
            self.judged_sr / all_sr
        } else {
            0.0
        }
    }

    fn missing(&self) -> String {
        let all_sr = self.all_sr();
        if all_sr <= 0.0 {
            return "everything".to_owned();
        }
        let percent = |sr: f64| (100.0 * sr / all_sr).round();
        let unseen_sr: f64 = self.bearings_sr.iter().map(|[unseen, _]| unseen).sum();
        let mut parts = Vec::new();
        if percent(unseen_sr) >= 1.0 {
            let at = self.unseen_bearings();
            parts.push(format!("{:.0} % not looked at{at}", percent(unseen_sr)));
        }
        if percent(self.hidden_sr) >= 1.0 {
            parts.push(format!("{:.0} % hidden", percent(self.hidden_sr)));
        }
        parts.join(", ")
    }

    /// The bearings of which most was not looked at, the widest first; empty where there are none.
    fn unseen_bearings(&self) -> String {
        let unseen: Vec<bool> = self
            .bearings_sr
            .iter()
            .map(|[unseen, all]| 2.0 * unseen > *all)
            .collect();
        let mut runs = circular_runs(&unseen);
        if runs == [(0, unseen.len())] {
            return " all around".to_owned();
        }
        runs.sort_by_key(|(from, count)| (std::cmp::Reverse(*count), *from));
        let names: Vec<String> = runs
            .iter()
            .take(NAMED_BEARINGS)
            .map(|(from, count)| {
                let from_deg = *from as f64 * BEARING_BIN_DEG - 180.0;
                let to_deg = from_deg + *count as f64 * BEARING_BIN_DEG;
                let to_deg = if to_deg > 180.0 {
                    to_deg - 360.0
                } else {
                    to_deg
                };
                format!("{from_deg:.0} to {to_deg:.0} deg")
            })
            .collect();
        if names.is_empty() {
            return String::new();
        }
        format!(" (bearings {})", names.join(", "))
    }
}

/// Runs of `true`, each with its beginning and length; the last may go on at the beginning.
fn circular_runs(flags: &[bool]) -> Vec<(usize, usize)> {
    let n = flags.len();
    let Some(start) = flags.iter().position(|flag| !flag) else {
        return vec![(0, n)];
    };
    let mut runs: Vec<(usize, usize)> = Vec::new();
    for k in 1..=n {
        let at = (start + k) % n;
        if !flags[at] {
            continue;
        }
        match runs.last_mut() {
            Some((from, count)) if (*from + *count) % n == at => *count += 1,
            _ => runs.push((at, 1)),
        }
    }
    runs
}

#[cfg(test)]
mod tests {
    use super::{SolidAngles, circular_runs};
    use crate::novelty::Visibility;

    /// One steradian at each of these bearings.
    fn sums(parts: &[(f64, Visibility)]) -> SolidAngles {
        let mut sums = SolidAngles::default();
        for (bearing_deg, visibility) in parts {
            sums.add(1.0, bearing_deg.to_radians(), *visibility);
        }
        sums
    }

    #[test]
    fn shares_are_of_what_was_asked_about() {
        use Visibility::{FreeSpace, Occluded, OnSurface, OutOfRange, OutOfView};
        let sums = sums(&[
            (1.0, OnSurface),
            (11.0, FreeSpace),
            (21.0, Occluded),
            (41.0, OutOfView),
            (51.0, OutOfRange),
        ]);
        assert_eq!(sums.judged_share(), 0.5);
        assert_eq!(
            sums.missing(),
            "25 % not looked at (bearings 40 to 45 deg), 25 % hidden"
        );
    }

    #[test]
    fn nothing_asked_about_is_nothing_judged() {
        let none = sums(&[(0.0, Visibility::OutOfRange)]);
        assert_eq!(
            (none.judged_share(), none.missing().as_str()),
            (0.0, "everything")
        );
        let all = sums(&[(0.0, Visibility::OnSurface)]);
        assert_eq!((all.judged_share(), all.missing().as_str()), (1.0, ""));
    }

    #[test]
    fn bearings_behind_the_robot_are_one_run() {
        let behind = [176.0, -176.0, -171.0, 90.0].map(|deg| (deg, Visibility::OutOfView));
        let ahead = [0.0, 10.0, 20.0, 30.0].map(|deg| (deg, Visibility::OnSurface));
        let text = sums(&[behind, ahead].concat()).missing();
        assert_eq!(
            text,
            "50 % not looked at (bearings 175 to -170 deg, 90 to 95 deg)"
        );
    }

    #[test]
    fn a_whole_turn_is_one_run() {
        assert_eq!(circular_runs(&[true; 4]), [(0, 4)]);
        assert_eq!(circular_runs(&[true, false, true, true]), [(2, 3)]);
        assert_eq!(circular_runs(&[false; 3]), []);
    }
}
