//! The histogram as SVG: quiet visits grey, changed ones red, the threshold in force as a line.

use super::report::bins;
use crate::alarm::ThresholdStudy;
use std::fmt::Write as _;

const WIDTH: f64 = 720.0;
const HEIGHT: f64 = 320.0;
const MARGIN: f64 = 50.0;

/// Bins of equal width on a logarithmic axis; the first may begin at zero.
pub(super) fn histogram_svg(waypoint: &str, study: &ThresholdStudy, u_th: f64) -> String {
    let bins = bins(study);
    let most = bins
        .iter()
        .map(|(bin, changed)| bin.count + changed)
        .max()
        .unwrap_or(1)
        .max(1);
    let step = (WIDTH - 2.0 * MARGIN) / bins.len().max(1) as f64;
    let base = HEIGHT - MARGIN;
    let tall = |count: u64| (base - MARGIN) * count as f64 / most as f64;
    let mut text = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH} {HEIGHT}\" font-family=\"sans-serif\" font-size=\"11\">\n\
         <rect width=\"{WIDTH}\" height=\"{HEIGHT}\" fill=\"white\"/>\n\
         <text x=\"{MARGIN}\" y=\"20\">{}: d_GMM of its visits; grey quiet, red changed; line: U_th {u_th}</text>\n",
        escaped(waypoint)
    );
    let mut rect = |x: f64, y: f64, height: f64, colour: &str| {
        // Writing to a string does not fail.
        let _ = writeln!(
            text,
            "<rect x=\"{x:.1}\" y=\"{y:.1}\" width=\"{:.1}\" height=\"{height:.1}\" fill=\"{colour}\"/>",
            0.9 * step
        );
    };
    let mut labels = String::new();
    for (i, (bin, changed)) in bins.iter().enumerate() {
        let x = MARGIN + step * i as f64;
        let (quiet, changed) = (tall(bin.count), tall(*changed));
        rect(x, base - quiet, quiet, "#969696");
        rect(x, base - quiet - changed, changed, "#d00000");
        let _ = writeln!(
            labels,
            "<text x=\"{x:.1}\" y=\"{:.1}\" transform=\"rotate(45 {x:.1} {:.1})\">{:.1e}</text>",
            base + 12.0,
            base + 12.0,
            bin.from
        );
    }
    text.push_str(&labels);
    let reached = bins
        .iter()
        .position(|(bin, _)| (bin.from..bin.to).contains(&u_th));
    if let Some(i) = reached {
        let (bin, _) = bins[i];
        let share = if bin.from > 0.0 {
            (u_th / bin.from).ln() / (bin.to / bin.from).ln()
        } else {
            0.5
        };
        let x = MARGIN + step * (i as f64 + share.clamp(0.0, 1.0));
        let _ = writeln!(
            text,
            "<line x1=\"{x:.1}\" y1=\"{MARGIN}\" x2=\"{x:.1}\" y2=\"{base}\" stroke=\"black\" stroke-dasharray=\"4 3\"/>"
        );
    }
    text.push_str("</svg>\n");
    text
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
}

#[cfg(test)]
mod tests {
    use super::histogram_svg;
    use crate::alarm::{PastCase, PastDistance, ThresholdStudy};

    #[test]
    fn every_bin_has_its_bar_and_the_threshold_its_line() {
        let mut study = ThresholdStudy::new([]);
        for (id, d_gmm, case) in [
            (1, 1e-4, PastCase::Quiet { listed: false }),
            (2, 1e-4, PastCase::Quiet { listed: true }),
            (3, 1e-2, PastCase::Changed),
        ] {
            study.add(&PastDistance { id, d_gmm, case });
        }
        let picture = histogram_svg("a<b", &study, 1e-3);
        assert!(picture.contains("a&lt;b: d_GMM"), "{picture}");
        assert_eq!(
            picture.matches("fill=\"#969696\"").count(),
            9,
            "two decades of four"
        );
        // Two visits are as tall as the picture, one is half as tall.
        assert!(
            picture.contains("y=\"50.0\" width=\"62.0\" height=\"220.0\" fill=\"#969696\""),
            "{picture}"
        );
        assert!(
            picture.contains("height=\"110.0\" fill=\"#d00000\""),
            "{picture}"
        );
        assert_eq!(picture.matches("<line").count(), 1);
        let empty = histogram_svg("hall", &ThresholdStudy::new([]), 1e-3);
        assert!(empty.ends_with("</svg>\n") && !empty.contains("<line"));
    }
}
