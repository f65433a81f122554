//! Table of the strongest features, as text.

use crate::detector::Detection;
use std::fmt::Write;

/// Lists the `count` strongest features, one on each line, under a header with units.
pub(super) fn feature_table(detection: &Detection, count: usize) -> String {
    let mut text = String::from(
        "       u       v   sigma  orientation  slope u  slope v  response     snr  octave  level\n      px      px      px          deg     px/f     px/f             sigma              \n",
    );
    for f in detection.features.iter().take(count) {
        // Writing into a string cannot fail.
        let _ = writeln!(
            text,
            "{:>8.2}{:>8.2}{:>8.2}{:>13.1}{:>9.2}{:>9.2}{:>10.4}{:>8.1}{:>8}{:>7}",
            f.u,
            f.v,
            f.sigma,
            f.orientation.to_degrees(),
            f.slope.u,
            f.slope.v,
            f.response,
            f.snr,
            f.octave,
            f.level
        );
    }
    if detection.features.len() > count {
        let _ = writeln!(text, "     … and {} more", detection.features.len() - count);
    }
    text
}
