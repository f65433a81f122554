//! The film that is exported: what changes in it, its rate and its size.

use crate::app::project::Model;
use crate::detector::SlopeAxis;
use crate::requests::{Film, FilmPlace, MAX_FILM_PICTURES, Sweep};
use serde::{Deserialize, Serialize};

#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum FilmContent {
    /// Slopes of the grid and half-way between, along its first axis that has several.
    #[default]
    Slopes,
    Scales,
    Frames,
}

impl FilmContent {
    pub const ALL: [Self; 3] = [Self::Slopes, Self::Scales, Self::Frames];

    pub fn label(self) -> &'static str {
        match self {
            Self::Slopes => "Slopes",
            Self::Scales => "Scales",
            Self::Frames => "Frames added",
        }
    }

    pub fn help(self) -> &'static str {
        match self {
            Self::Slopes => "The motion stack at the slopes of the search and half-way between",
            Self::Scales => "D at the slope of the cursor, from the finest octave and level to the coarsest",
            Self::Frames => "The motion stack at the slope of the cursor, of one frame to all",
        }
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct FilmChoice {
    pub content: FilmContent,
    pub rate: u16,
    pub max_side_px: usize,
}

impl Default for FilmChoice {
    fn default() -> Self {
        Self { content: FilmContent::default(), rate: 10, max_side_px: 640 }
    }
}

const STEPS: usize = 2;

impl Model {
    pub fn film_to_export(&self) -> Option<Film> {
        let side = self.active_side();
        let burst = self.burst_of(side)?.clone();
        let found = self.found_of(side);
        let params = found.map_or_else(|| self.results.slots[side].usable_params.clone(), |found| found.params.clone());
        let grid = params.used_slopes();
        let count = |axis: &SlopeAxis| (STEPS * (axis.count - 1) + 1).min(MAX_FILM_PICTURES);
        let sweep = match self.document.film.content {
            FilmContent::Scales => Sweep::Scale,
            FilmContent::Slopes if grid.u.count > 1 => Sweep::SlopeU(grid.u.min, grid.u.max, count(&grid.u)),
            FilmContent::Slopes if grid.v.count > 1 => Sweep::SlopeV(grid.v.min, grid.v.max, count(&grid.v)),
            FilmContent::Slopes | FilmContent::Frames => Sweep::Frames,
        };
        let detection = found.map(|found| found.detection.clone());
        // The place that is probed, at the scale of the cursor, as the curves of the probe follow it.
        let cursor = self.document.cursor();
        let probed = self.probed_place().filter(|_| self.document.probe.side == side);
        let place = probed.map(|at| FilmPlace { at, scale: (cursor.octave, cursor.level) });
        let max_side_px = self.document.film.max_side_px;
        Some(Film { burst, params, sweep, slope: cursor.slope, detection, place, max_side_px })
    }
}
