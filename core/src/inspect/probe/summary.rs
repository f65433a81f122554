//! The summary of a place in words.

use crate::detector::Test;
use crate::inspect::fate::Fate;
use crate::inspect::response::ResponseMap;
use crate::inspect::words::{number, slope_text};

/// The summary, a sentence or two.
pub(super) fn summary(fates: &[Fate], response: &ResponseMap) -> String {
    let kept = fates.iter().filter(|f| f.is_kept()).count();
    if kept > 0 {
        let covered = fates.iter().filter(|f| f.first_failed == Some(Test::Duplicate)).count();
        let also = match covered {
            0 => String::new(),
            1 => "; 1 weaker keypoint lies on the same blob".to_owned(),
            n => format!("; {n} weaker keypoints lie on the same blob"),
        };
        return match kept {
            1 => format!("One candidate here was kept{also}."),
            n => format!("{n} candidates here were kept{also}."),
        };
    }
    let (column, row, strongest) = response.strongest();
    let Some(best) = fates.iter().max_by(|a, b| a.snr.total_cmp(&b.snr)) else {
        let scale = response.scales.get(row).map_or(0.0, |scale| scale.sigma);
        let slope = response.columns.get(column).copied().unwrap_or_default();
        let strength = if response.is_noiseless { format!("{strongest:+.1e}") } else { format!("{strongest:+.1} σ") };
        return format!(
            "Nothing here is an extremum at any slope and scale. The strongest response is {strength}, at scale {} px and slope {}.",
            number(scale, 1),
            slope_text(slope)
        );
    };
    let strength = if response.is_noiseless {
        format!("The strongest candidate here has |D| {:.2e}", best.value.abs())
    } else if best.snr.is_finite() {
        format!("The strongest candidate here has {:.1} σ (the gate requires {:.2})", best.snr, response.gate)
    } else {
        format!("The strongest response here is {strongest:.1} σ")
    };
    format!("Nothing was kept here. {strength}: {}.", best.verdict)
}
