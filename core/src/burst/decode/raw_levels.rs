//! Black and white levels of a raw frame, as in the file or as given: the values that become 0 and 1.
//!
//! Black may differ from colour to colour, and by a little from column to column and from row to row (DNG's
//! `BlackLevelDeltaH` and `BlackLevelDeltaV`): stripes that the sensor has in the dark, and that would stay in every
//! frame at one place.

use crate::burst::options::OpenOptions;
use rawler::RawImage;
use rawler::formats::tiff::IFD;
use rawler::rawimage::BlackLevel;
use rawler::tags::DngTag;

/// Black of each column and row above the level of its colour. Empty where the file gives none.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct BlackSteps {
    columns: Vec<f32>,
    rows: Vec<f32>,
}

impl BlackSteps {
    /// Reads the steps of a directory.
    pub(super) fn of(directory: &IFD) -> Self {
        let steps = |tag: DngTag| {
            let value = directory.get_entry(tag).map(|entry| &entry.value);
            value.map_or_else(Vec::new, |value| {
                (0..value.count()).map(|index| value.get_f32(index).ok().flatten().unwrap_or(f32::NAN)).collect()
            })
        };
        Self { columns: steps(DngTag::BlackLevelDeltaH), rows: steps(DngTag::BlackLevelDeltaV) }
    }

    /// Whether there is one finite step for each column and row of an area of `size` (columns, rows), or none.
    fn fits(&self, size: (usize, usize)) -> bool {
        let fits =
            |steps: &[f32], count| steps.is_empty() || (steps.len() == count && steps.iter().all(|s| s.is_finite()));
        fits(&self.columns, size.0) && fits(&self.rows, size.1)
    }

    fn max(&self) -> f32 {
        let max = |steps: &[f32]| steps.iter().copied().fold(0.0, f32::max);
        max(&self.columns) + max(&self.rows)
    }

    fn at(&self, (u, v): (usize, usize)) -> f32 {
        self.columns.get(u).copied().unwrap_or(0.0) + self.rows.get(v).copied().unwrap_or(0.0)
    }
}

/// Values that become 0 and 1.
pub(super) struct RawLevels {
    /// Levels of a pattern of columns and rows, each with its samples, that begins at the active area's corner.
    black: Vec<f32>,
    black_size: (usize, usize),
    black_steps: BlackSteps,
    white: Vec<f32>,
    samples: usize,
}

impl RawLevels {
    /// Levels of `raw`, whose active area has `size` (columns, rows), or those that `options` gives.
    ///
    /// # Errors
    /// The fault of the levels, as the end of a sentence about the file.
    pub(super) fn of(
        raw: &RawImage,
        size: (usize, usize),
        black_steps: BlackSteps,
        options: &OpenOptions,
    ) -> Result<Self, String> {
        let BlackLevel { width, height, cpp, .. } = raw.blacklevel;
        let mut black = raw.blacklevel.as_vec();
        let mut black_size = (width.max(1), height.max(1));
        let mut black_steps = black_steps;
        if black.len() < black_size.0 * black_size.1 * cpp.max(1) || cpp != raw.cpp {
            (black, black_size) = (vec![black.first().copied().unwrap_or(0.0); raw.cpp], (1, 1));
        }
        if let Some(level) = options.black_level {
            (black, black_size, black_steps) = (vec![level; raw.cpp], (1, 1), BlackSteps::default());
        }
        if !black_steps.fits(size) {
            return Err(format!(
                "its black levels of columns and rows are {} and {}, not one for each of {}×{}; give one black level",
                black_steps.columns.len(),
                black_steps.rows.len(),
                size.0,
                size.1
            ));
        }
        let mut white: Vec<f32> = raw.whitelevel.0.iter().map(|level| *level as f32).collect();
        if white.len() < raw.cpp {
            white = vec![white.first().copied().unwrap_or(65535.0); raw.cpp];
        }
        if let Some(level) = options.full_scale {
            white = vec![level; raw.cpp];
        }
        let levels = Self { black, black_size, black_steps, white, samples: raw.cpp };
        let darkest = levels.white.iter().copied().fold(f32::INFINITY, f32::min);
        let step = levels.black_steps.max();
        if levels.black.iter().all(|black| *black + step < darkest) {
            return Ok(levels);
        }
        Err(format!("its black level is not below its white level, {darkest}; give both by full scale and black level"))
    }

    /// Value of the first sample of a pixel that becomes 1.
    pub(super) fn white(&self) -> f32 {
        self.white[0]
    }

    /// Sample `c` of the pixel in column `u` and row `v` of the active area, scaled so that black becomes 0 and white
    /// 1.
    pub(super) fn fraction(&self, value: f32, (u, v): (usize, usize), c: usize) -> f32 {
        let (width, height) = self.black_size;
        let level = self.black[((v % height) * width + u % width) * self.samples + c];
        let black = level + self.black_steps.at((u, v));
        (value - black) / (self.white[c] - black)
    }
}
