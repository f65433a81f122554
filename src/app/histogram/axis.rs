//! Range of values of the histogram's axis.

use crate::plane::display::Display;

/// Axis that contains all values and the display range, with a margin of 4 % of its length at each end.
pub fn axis_for(data_range: Option<(f32, f32)>, display: &Display) -> (f32, f32) {
    let (low, high) =
        data_range.map_or((display.min, display.max), |(low, high)| (low.min(display.min), high.max(display.max)));
    let (low, high) = if display.symmetric {
        let limit = low.abs().max(high.abs());
        (-limit, limit)
    } else {
        (low, high)
    };
    let room = 0.04 * (high - low);
    (low - room, high + room)
}

/// Whether an axis can stay: it contains the display range and the values, and they fill more than 40 % of it.
pub fn axis_fits(axis: (f32, f32), data_range: Option<(f32, f32)>, display: &Display) -> bool {
    let needed = axis_for(data_range, display);
    let holds = |low: f32, high: f32| low >= axis.0 && high <= axis.1;
    holds(display.min, display.max)
        && data_range.is_none_or(|(low, high)| holds(low, high))
        && (needed.1 - needed.0) > 0.4 * (axis.1 - axis.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_axis_stays_while_pictures_change_a_little() {
        let display = Display { min: 0.0, max: 0.1, ..Display::default() };
        let axis = axis_for(Some((0.01, 0.09)), &display);
        assert!(axis_fits(axis, Some((0.02, 0.095)), &display));
        assert!(!axis_fits(axis, Some((0.0, 0.2)), &display), "values outside must be seen");
        let narrow = Display { max: 0.001, ..display };
        assert!(!axis_fits(axis, Some((0.0, 0.001)), &narrow), "a range must not hide in a corner");
        let symmetric = axis_for(Some((-0.01, 0.05)), &Display::symmetric(0.02));
        assert_eq!(symmetric.0, -symmetric.1);
    }
}
