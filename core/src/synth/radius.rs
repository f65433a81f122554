//! Distribution of the radii of a chart's discs.

use super::random::Stream;
use serde::{Deserialize, Serialize};
use std::ops::RangeInclusive;
use std::str::FromStr;

/// Distribution of radii over their range.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum RadiusLaw {
    /// Uniform in the radius: most discs are large.
    #[default]
    Uniform,
    /// Uniform in the logarithm of the radius: equally many fine and coarse discs, like the sampling of a scale space.
    Log,
}

impl RadiusLaw {
    /// All distributions.
    pub const ALL: [Self; 2] = [Self::Uniform, Self::Log];

    /// Name on the command line.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Uniform => "uniform",
            Self::Log => "log",
        }
    }

    /// Draws a radius from `range` (pixels, above 0). Both distributions take one number from `stream`, so charts of
    /// the same seed differ only in their radii.
    pub(super) fn draw(self, range: &RangeInclusive<f64>, stream: &mut Stream) -> f64 {
        let (smallest, largest) = (*range.start(), *range.end());
        match self {
            Self::Uniform => stream.within(smallest, largest),
            Self::Log => {
                // Rounding in the exponential must not leave the range.
                libm::exp(stream.within(libm::log(smallest), libm::log(largest))).clamp(smallest, largest)
            }
        }
    }
}

impl FromStr for RadiusLaw {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let found = Self::ALL.into_iter().find(|law| law.name() == text);
        found.ok_or_else(|| format!("'{text}' is neither uniform nor log"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn share_below(law: RadiusLaw, limit: f64) -> f64 {
        const COUNT: usize = 40_000;
        let mut stream = Stream::new(3, 0);
        let range = 3.6..=19.0;
        let below = (0..COUNT).filter(|_| {
            let radius = law.draw(&range, &mut stream);
            assert!(range.contains(&radius), "{radius}");
            radius < limit
        });
        below.count() as f64 / COUNT as f64
    }

    #[test]
    fn each_law_spreads_radii_as_it_says() {
        // Five standard errors of a share.
        let error = 5.0 * (0.25f64 / 40_000.0).sqrt();
        let middle = 0.5 * (3.6 + 19.0);
        assert!((share_below(RadiusLaw::Uniform, middle) - 0.5).abs() < error);
        let geometric_middle = (3.6f64 * 19.0).sqrt();
        assert!((share_below(RadiusLaw::Log, geometric_middle) - 0.5).abs() < error);
        assert!(share_below(RadiusLaw::Log, middle) > 0.65);
    }

    #[test]
    fn a_range_of_one_radius_gives_it_and_names_are_read_back() {
        for law in RadiusLaw::ALL {
            assert_eq!(law.draw(&(5.3..=5.3), &mut Stream::new(1, 0)), 5.3);
            assert_eq!(law.name().parse(), Ok(law));
        }
        assert!("even".parse::<RadiusLaw>().expect_err("no law").contains("uniform nor log"));
    }
}
