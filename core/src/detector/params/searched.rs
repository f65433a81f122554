//! Parameters as commands, parameter files, datasets and the window hold them, with slopes given or yet to be found.
//!
//! [`crate::detector::slopes::resolve`] turns [`SearchParams`] into the [`DetectorParams`] of one burst.

use super::doc::SearchParams;
use super::slope_grid::AUTO;
use super::{DetectorParams, Param, Slope, SlopeGrid, Slopes, doc};
use crate::error::{Error, Result};
use crate::files::without_table;
use toml::Table;

impl From<DetectorParams> for SearchParams {
    fn from(params: DetectorParams) -> Self {
        let grid = params.slopes;
        params.with_slopes(Slopes::Given(grid))
    }
}

impl SearchParams {
    /// Parameters of a search of the slopes of `grid`.
    pub fn at(&self, grid: SlopeGrid) -> DetectorParams {
        self.clone().with_slopes(grid)
    }

    /// Parameters of a search of the given slopes; of slope 0 alone where slopes are to be found.
    pub fn at_given(&self) -> DetectorParams {
        self.at(self.slopes.given().unwrap_or(SlopeGrid::single(Slope::default())))
    }

    /// These parameters with the `given` values, as typed on the command line, in place of their own; checked.
    ///
    /// Slopes are found from each burst unless ranges are given here or in these parameters; a direction alone
    /// restricts the search to a line in that direction. Rules come first, with the [parameters that go with
    /// them](DetectorParams::under). A missing axis is that of these parameters, or 0 without ranges.
    ///
    /// # Errors
    /// The first value that cannot be read, or the first parameter that makes no sense.
    pub fn with_texts<'a>(self, given: impl IntoIterator<Item = (Param<Self>, &'a str)>) -> Result<Self> {
        let mut params = self;
        let mut given: Vec<_> = given.into_iter().collect();
        // Rules come first: they bring other parameters, which values given besides replace. A direction turns ranges.
        given.sort_by_key(|(record, _)| (*record != doc::RULES, *record == doc::SLOPE_DIRECTION));
        let ranges = given.iter().find(|(record, _)| [doc::SLOPES_U, doc::SLOPES_V].contains(record));
        if let Some((_, text)) = given.iter().find(|(record, _)| *record == doc::SLOPES) {
            let error = |problem: String, remedy: &str| Error::param(doc::SLOPES.name, problem, remedy.to_owned());
            if *text != AUTO {
                return Err(error(format!("'{text}' is not known"), "give auto, or the ranges slopes-u and slopes-v"));
            }
            if let Some((range, _)) = ranges {
                return Err(error(format!("auto and {} are both given", range.name), "give one of them"));
            }
        }
        for (record, text) in given {
            record.set(&mut params, text)?;
        }
        params.validate()?;
        Ok(params)
    }

    /// Reads a parameter file.
    ///
    /// # Errors
    /// TOML's error with its place, or the first parameter that makes no sense.
    pub fn from_toml(text: &str) -> Result<Self, String> {
        Self::default().with_toml(text)
    }

    /// These parameters with those that a parameter file names in place of their own. Rules that it names come with the
    /// [parameters that go with them](DetectorParams::under).
    ///
    /// # Errors
    /// As [`Self::from_toml`].
    pub fn with_toml(self, text: &str) -> Result<Self, String> {
        // The commands that match read the table of their options.
        let [text, _] = without_table(text, "matching");
        let _: Self = toml::from_str(&text).map_err(|e| e.to_string())?;
        // Errors of the text have a place, those of a table have none.
        let params = self.with_table(text.parse().map_err(|e: toml::de::Error| e.to_string())?)?;
        params.validate().map_err(|e| e.to_string())?;
        Ok(params)
    }

    /// As [`Self::with_toml`], from a file's table, unchecked.
    ///
    /// # Errors
    /// The first value that cannot be read.
    pub fn with_table(self, table: Table) -> Result<Self, String> {
        let given: Self = table.clone().try_into().map_err(|e: toml::de::Error| e.to_string())?;
        let base = if table.contains_key(doc::RULES.name) { self.under(given.rules) } else { self };
        let mut whole = Table::try_from(&base).expect("parameters are plain values, which TOML can always hold");
        whole.extend(table);
        whole.try_into().map_err(|e: toml::de::Error| e.to_string())
    }

    /// Text of the parameter file, which [`Self::from_toml`] reads back.
    pub fn to_toml(&self) -> String {
        let body = toml::to_string(self).expect("parameters are plain values, which TOML can always hold");
        let slopes = match self.slopes {
            Slopes::Auto { .. } => "are found from each burst",
            Slopes::Given(_) => "are in pixels of the input image per frame",
        };
        format!("# Burstscope detector parameters. Slopes {slopes}.\n{body}")
    }
}
