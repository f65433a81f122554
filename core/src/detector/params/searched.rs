//! The detector's parameters together with the choice of the slopes, as commands, parameter files, datasets and the
//! window hold them.
//!
//! [`DetectorParams`] gives the slopes. [`SearchParams`] may instead request slopes found from each burst;
//! [`crate::detector::slopes::resolve`] then converts the one into the other, burst by burst, before the detection.

use super::{DetectorParams, Field, Param, Slope, SlopeGrid, doc};
use crate::error::{Error, Result};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use toml::{Table, Value};

/// Value for slopes that are found from each burst.
pub const AUTO: &str = "auto";
/// Field of a parameter file that holds the slopes.
const FIELD: &str = "slopes";

/// Choice of the slopes that are searched.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum SlopeChoice {
    /// Given by [`DetectorParams::slopes`].
    #[default]
    Given,
    /// Found from each burst; with a direction only on the line through slope 0 in it.
    Auto {
        /// Direction of the line, degrees from +u towards +v.
        direction_deg: Option<f32>,
    },
}

impl SlopeChoice {
    /// Found from each burst, anywhere in the plane.
    pub const AUTO: Self = Self::Auto { direction_deg: None };

    /// Whether slopes are found from each burst.
    pub fn is_auto(self) -> bool {
        matches!(self, Self::Auto { .. })
    }
}

/// The detector's parameters, and the choice of the slopes. By default the slopes are found from each burst.
///
/// Its file format is that of [`DetectorParams`], where `slopes = "auto"` (or a missing field) stands for slopes that
/// are found, and `slopes = { auto = true, direction_deg = 30.0 }` for those on a line.
#[derive(Debug, Clone, PartialEq)]
pub struct SearchParams {
    /// Parameters of the detector. Their slopes count only where they are [given](SlopeChoice::Given).
    pub detector: DetectorParams,
    /// Choice of the slopes.
    pub slopes: SlopeChoice,
}

impl Default for SearchParams {
    fn default() -> Self {
        Self { detector: DetectorParams::default(), slopes: SlopeChoice::AUTO }
    }
}

impl From<DetectorParams> for SearchParams {
    /// Takes the slopes of the parameters.
    fn from(detector: DetectorParams) -> Self {
        Self { detector, slopes: SlopeChoice::Given }
    }
}

impl SearchParams {
    /// Checks the parameters alone, without a burst.
    ///
    /// # Errors
    /// The first parameter that makes no sense.
    pub fn validate(&self) -> Result<()> {
        if let SlopeChoice::Auto { direction_deg: Some(degrees) } = self.slopes
            && !degrees.is_finite()
        {
            return Err(Error::param(doc::SLOPE_DIRECTION.name, "it is not finite", "give degrees"));
        }
        self.detector.validate()
    }

    /// These parameters with the `given` values in place of their own, as typed on the command line; checked.
    ///
    /// Slopes are found from each burst unless ranges are given here or in these parameters; a direction alone
    /// restricts the search to a line in that direction. Rules come first, with the
    /// [parameters that go with them](DetectorParams::under). An axis of slopes that is missing is that of these
    /// parameters, or 0 where they have no ranges.
    ///
    /// # Errors
    /// The first value that cannot be read, or the first parameter that makes no sense.
    pub fn with_texts<'a>(self, given: impl IntoIterator<Item = (Param<DetectorParams>, &'a str)>) -> Result<Self> {
        let mut params = self;
        let (slopes, mut others): (Vec<_>, Vec<_>) = given.into_iter().partition(|(record, _)| *record == doc::SLOPES);
        // Rules bring other parameters with them, which what is given besides replaces.
        others.sort_by_key(|(record, _)| *record != doc::RULES);
        let ranges = others.iter().find(|(record, _)| *record == doc::SLOPES_U || *record == doc::SLOPES_V);
        let error = |problem: String, remedy: &str| Error::param(doc::SLOPES.name, problem, remedy.to_owned());
        for (_, text) in slopes {
            if text != AUTO {
                return Err(error(format!("'{text}' is not known"), "give auto, or the ranges slopes-u and slopes-v"));
            }
            if let Some((range, _)) = ranges {
                return Err(error(format!("auto and {} are both given", range.name), "give one of them"));
            }
            params.slopes = SlopeChoice::AUTO;
        }
        if ranges.is_some() && params.slopes.is_auto() {
            params.detector.slopes = SlopeGrid::single(Slope::default());
            params.slopes = SlopeChoice::Given;
        }
        for (record, text) in others {
            match &mut params.slopes {
                SlopeChoice::Auto { direction_deg } if record == doc::SLOPE_DIRECTION => {
                    record.set_field(Field::F32(direction_deg.insert(0.0)), text)?;
                }
                _ => record.set(&mut params.detector, text)?,
            }
        }
        params.validate()?;
        Ok(params)
    }

    /// Reads a parameter file.
    ///
    /// # Errors
    /// TOML's error with its place, or the first parameter that makes no sense.
    pub fn from_toml(text: &str) -> Result<Self, String> {
        let params: Self = match text.parse::<Table>() {
            Ok(table) if choice_in(&table)?.is_auto() => Self::of_table(table)?,
            // Errors of TOML's reader include their place.
            _ => DetectorParams::from_toml(text)?.into(),
        };
        params.validate().map_err(|e| e.to_string())?;
        Ok(params)
    }

    /// Text of the parameter file, which [`Self::from_toml`] reads back.
    pub fn to_toml(&self) -> String {
        if !self.slopes.is_auto() {
            return self.detector.to_toml();
        }
        let body = toml::to_string(&self.table()).expect("parameters are plain values, which TOML can always hold");
        format!("# Burstscope detector parameters. Slopes are found from each burst.\n{body}")
    }

    fn of_table(mut table: Table) -> Result<Self, String> {
        let slopes = choice_in(&table)?;
        if slopes.is_auto() {
            table.remove(FIELD);
        }
        let detector = DetectorParams::of_table(table)?;
        Ok(Self { detector, slopes })
    }

    /// Content of the file where slopes are found.
    fn table(&self) -> Table {
        let mut table =
            Table::try_from(&self.detector).expect("parameters are plain values, which TOML can always hold");
        shorten(&mut table);
        let slopes = match self.slopes {
            SlopeChoice::Auto { direction_deg: Some(degrees) } => {
                let mut line = Table::new();
                line.insert(AUTO.into(), Value::Boolean(true));
                line.insert("direction_deg".into(), Value::Float(short(f64::from(degrees))));
                Value::Table(line)
            }
            _ => Value::String(AUTO.into()),
        };
        table.insert(FIELD.into(), slopes);
        table
    }
}

/// Choice of the slopes in a file.
fn choice_in(table: &Table) -> Result<SlopeChoice, String> {
    match table.get(FIELD) {
        None => Ok(SlopeChoice::AUTO),
        Some(Value::String(word)) if word == AUTO => Ok(SlopeChoice::AUTO),
        Some(Value::String(word)) => {
            Err(format!("slopes: '{word}' is not known; give \"auto\" or a table with u and v"))
        }
        Some(Value::Table(slopes)) => match slopes.get(AUTO) {
            None | Some(Value::Boolean(false)) if !slopes.contains_key(AUTO) => Ok(SlopeChoice::Given),
            Some(Value::Boolean(true)) if slopes.keys().all(|key| [AUTO, "direction_deg"].contains(&key.as_str())) => {
                let degrees = match slopes.get("direction_deg") {
                    None => None,
                    Some(Value::Float(degrees)) => Some(*degrees as f32),
                    Some(Value::Integer(degrees)) => Some(*degrees as f32),
                    Some(_) => return Err("slopes: direction_deg is not a number; give degrees".into()),
                };
                Ok(SlopeChoice::Auto { direction_deg: degrees })
            }
            _ => Err("slopes: auto = true stands alone or with direction_deg; leave out the rest, or auto".into()),
        },
        Some(_) => Ok(SlopeChoice::Given),
    }
}

/// Replaces floats by the shortest decimals of their f32: 0.0003, not the double nearest to the f32.
fn shorten(table: &mut Table) {
    for (_, value) in table.iter_mut() {
        match value {
            Value::Float(x) => *x = short(*x),
            Value::Table(inner) => shorten(inner),
            _ => {}
        }
    }
}

fn short(x: f64) -> f64 {
    (x as f32).to_string().parse().unwrap_or(x)
}

impl Serialize for SearchParams {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self.slopes {
            SlopeChoice::Given => self.detector.serialize(serializer),
            SlopeChoice::Auto { .. } => self.table().serialize(serializer),
        }
    }
}

impl<'de> Deserialize<'de> for SearchParams {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        Self::of_table(Table::deserialize(deserializer)?).map_err(serde::de::Error::custom)
    }
}
