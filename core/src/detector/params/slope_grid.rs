//! Slopes that the search tries: a grid of slopes, or the request to find one from each burst.
//!
//! A slope λ = (λu, λv) is an apparent motion in pixels of the input image per frame. The grid is the product of two
//! axes, `u` and `v`, turned as a whole by `direction_deg`: with one value on the `v` axis it is a line through the
//! slope plane (BuFF 1D), horizontal unless turned; with several values on both axes it is BuFF 2D.

use crate::burst::Offset;
use serde::ser::SerializeMap;
use serde::{Deserialize, Deserializer, Serialize, Serializer, de};
use std::ops::RangeInclusive;
use toml::Value;

/// Largest motion of a burst by one step of an [enclosing](SlopeGrid::enclosing) grid, pixels, where steps suffice.
const MAX_MOVED_PX: f32 = 13.0;

/// Maximum number of slopes of a grid.
pub const MAX_SLOPES: usize = 4096;

/// Apparent motion λ = (λu, λv), in pixels of the input image per frame.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Slope {
    /// Motion to the right, pixels per frame.
    pub u: f32,
    /// Motion down, pixels per frame.
    pub v: f32,
}

impl Slope {
    /// Slope (u, v), in pixels per frame.
    pub const fn new(u: f32, v: f32) -> Self {
        Self { u, v }
    }

    /// Length, in pixels per frame.
    pub fn magnitude(self) -> f32 {
        self.u.hypot(self.v)
    }

    /// Displacement (u, v), pixels, in a frame at `offset` from mid-burst.
    pub fn displacement(self, offset: Offset<f32>) -> (f32, f32) {
        offset.displacement((self.u, self.v))
    }
}

/// Equally spaced slopes on one axis: `count` values from `min` to `max`, both included.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SlopeAxis {
    /// First slope, pixels per frame.
    pub min: f32,
    /// Last slope, pixels per frame; at least `min`.
    pub max: f32,
    /// Number of slopes, at least 1; a single one is in the middle of `min` and `max`.
    pub count: usize,
}

impl SlopeAxis {
    /// Axis with only the slope 0.
    pub const ZERO: Self = Self { min: 0.0, max: 0.0, count: 1 };

    /// Axis of `count` slopes over `range`.
    pub fn new(range: RangeInclusive<f32>, count: usize) -> Self {
        Self { min: *range.start(), max: *range.end(), count }
    }

    /// Distance between neighbours in pixels per frame; 0 for a single slope.
    pub fn step(&self) -> f32 {
        // Rounding away the last bits gives axes that share slopes the same step.
        if self.count > 1 { rounded(self.exact_step(), self.exact_step(), 1e6) } else { 0.0 }
    }

    fn exact_step(&self) -> f64 {
        (f64::from(self.max) - f64::from(self.min)) / (self.count - 1) as f64
    }

    /// Axis with `below` more slopes before its first one and `above` after its last one, at an unchanged step; around
    /// a single slope at a step of 1 px/frame.
    pub fn with_more(&self, below: usize, above: usize) -> Self {
        if self.count < 2 {
            let at = self.value(0.0);
            return Self { min: at - below as f32, max: at + above as f32, count: 1 + below + above };
        }
        let first = if below > 0 { self.value(-(below as f32)) } else { self.min };
        let last = if above > 0 { self.value((self.count - 1 + above) as f32) } else { self.max };
        Self { min: first, max: last, count: self.count + below + above }
    }

    /// Slope at `index` of the axis; fractional indices are allowed. Axes that share slopes give them equal bits:
    /// values are rounded to 0.000 01 px/frame, unless the step is that small.
    pub fn value(&self, index: f32) -> f32 {
        match self.count {
            0 | 1 => 0.5 * (self.min + self.max),
            _ => {
                let step = self.exact_step();
                rounded(f64::from(self.min) + f64::from(index) * step, step, 1e5)
            }
        }
    }

    /// Checks the axis by itself.
    ///
    /// # Errors
    /// The fault and its remedy.
    pub fn check(&self) -> Result<(), (String, String)> {
        let Self { min, max, count } = self;
        let (problem, remedy) = if !(min.is_finite() && max.is_finite()) {
            ("the range is not finite".to_owned(), "give two numbers of pixels per frame")
        } else if *count == 0 {
            ("the count is 0".to_owned(), "give at least 1 slope")
        } else if min > max {
            (format!("{min} is above {max}"), "give the smaller slope first")
        } else if *count > 1 && min == max {
            (format!("{count} slopes on an empty range"), "widen the range, or ask for 1 slope")
        } else if *count > MAX_SLOPES {
            (format!("{count} slopes"), "at most 4096 slopes are searched; use a coarser step")
        } else {
            return Ok(());
        };
        Err((problem, remedy.to_owned()))
    }
}

/// Step, pixels per frame, from which slopes are rounded.
const ROUNDED_STEP: f64 = 1e-3;

/// `x` rounded to one part in `parts` of a pixel per frame, where the `step` of an axis is much larger.
fn rounded(x: f64, step: f64, parts: f64) -> f32 {
    (if step < ROUNDED_STEP { x } else { (x * parts).round() / parts }) as f32
}

impl std::fmt::Display for SlopeAxis {
    /// Writes `MIN:MAX:COUNT`, as the command line takes it.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}:{}:{}", self.min, self.max, self.count)
    }
}

impl std::str::FromStr for SlopeAxis {
    type Err = String;

    /// Reads `MIN:MAX:COUNT`, or a number for a single slope.
    fn from_str(text: &str) -> Result<Self, String> {
        let number = |s: &str| {
            s.trim().parse::<f32>().ok().filter(|x| x.is_finite()).ok_or_else(|| format!("'{s}' is not a number"))
        };
        let parts: Vec<&str> = text.split(':').collect();
        match parts.as_slice() {
            [one] => number(one).map(|value| Self::new(value..=value, 1)),
            [min, max, count] => Ok(Self {
                min: number(min)?,
                max: number(max)?,
                count: count.trim().parse().map_err(|_| format!("'{count}' is not a count of slopes"))?,
            }),
            _ => Err(format!("'{text}' is not MIN:MAX:COUNT, such as -3:3:7")),
        }
    }
}

/// Slopes of a search: the product of two axes, turned by a direction.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct SlopeGrid {
    /// Slopes along the first axis (to the right when `direction_deg` is 0).
    pub u: SlopeAxis,
    /// Slopes along the second axis (down when `direction_deg` is 0).
    pub v: SlopeAxis,
    /// Rotation of the whole grid from +u towards +v (clockwise on screen), degrees.
    pub direction_deg: f32,
}

impl Default for SlopeGrid {
    /// The paper's seven slopes, horizontal, over ±3 pixels per frame.
    fn default() -> Self {
        Self::line(-3.0..=3.0, 7)
    }
}

impl SlopeGrid {
    /// BuFF 1D: `count` horizontal slopes over `range` (pixels per frame).
    pub fn line(range: RangeInclusive<f32>, count: usize) -> Self {
        Self { u: SlopeAxis::new(range, count), v: SlopeAxis::ZERO, direction_deg: 0.0 }
    }

    /// BuFF 1D along any direction: degrees from +u towards +v.
    pub fn line_along(direction_deg: f32, range: RangeInclusive<f32>, count: usize) -> Self {
        Self { direction_deg, ..Self::line(range, count) }
    }

    /// BuFF 2D: the product of slopes to the right and slopes down.
    pub fn plane(u: RangeInclusive<f32>, count_u: usize, v: RangeInclusive<f32>, count_v: usize) -> Self {
        Self { u: SlopeAxis::new(u, count_u), v: SlopeAxis::new(v, count_v), direction_deg: 0.0 }
    }

    /// Grid with one slope.
    pub fn single(slope: Slope) -> Self {
        Self::plane(slope.u..=slope.u, 1, slope.v..=slope.v, 1)
    }

    /// Coarse grid around zero that encloses this one, equal for all grids of about the same reach: each axis with more
    /// than one slope extends to 4, 8, 16 … px/frame, in steps that move a burst of `span` frame intervals by about a
    /// dozen pixels at most, or more where the range is very wide.
    pub fn enclosing(&self, span: f32) -> Self {
        // Powers of two, so that a slightly wider range of slopes has the same enclosing grid, and the same noise.
        let widest = [self.u, self.v].map(|axis| axis.min.abs().max(axis.max.abs())).into_iter().fold(4.0, f32::max);
        let reach = widest.log2().ceil().exp2();
        let steps = reach * ((span + 1.0) / MAX_MOVED_PX).max(1.0).log2().ceil().exp2();
        let most = if self.is_plane() { 8.0 } else { 32.0 };
        let enclosing = |axis: SlopeAxis| match axis.count {
            0 | 1 => axis,
            _ => SlopeAxis::new(-reach..=reach, 2 * steps.min(most) as usize + 1),
        };
        Self { u: enclosing(self.u), v: enclosing(self.v), ..*self }
    }

    /// Number of slopes, Mu·Mv.
    pub fn len(&self) -> usize {
        self.u.count * self.v.count
    }

    /// Whether there is no slope; validation rejects that.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Direction of a line of slopes, degrees from +u towards +v, and the slopes along it; `None` for other grids.
    pub fn as_line(&self) -> Option<(f32, SlopeAxis)> {
        match (self.u.count > 1, self.v.count > 1) {
            (true, false) => Some((self.direction_deg, self.u)),
            (false, true) => Some((self.direction_deg + 90.0, self.v)),
            _ => None,
        }
    }

    /// Whether both axes have more than one slope (BuFF 2D).
    pub fn is_plane(&self) -> bool {
        self.u.count > 1 && self.v.count > 1
    }

    /// Slope at grid coordinates (`i` along the first axis, `j` along the second); fractional coordinates are allowed.
    pub fn at(&self, i: f32, j: f32) -> Slope {
        let (a, b) = (self.u.value(i), self.v.value(j));
        if self.direction_deg == 0.0 {
            return Slope::new(a, b);
        }
        let (sin, cos) = f64::from(self.direction_deg).to_radians().sin_cos();
        let (a, b) = (f64::from(a), f64::from(b));
        // Rounding away the last bits keeps a line turned by 90° exactly vertical.
        let tidy = |x: f64| ((x * 1e6).round() / 1e6) as f32;
        Slope::new(tidy(a * cos - b * sin), tidy(a * sin + b * cos))
    }

    /// Slope with running index `index` = `j·Mu + i`. Indices past the end give slopes outside the grid.
    pub fn slope(&self, index: usize) -> Slope {
        let (i, j) = self.coordinates(index);
        self.at(i as f32, j as f32)
    }

    /// Slope (`di`, `dj`) steps from the slope `index`; its bits depend on that slope and the steps alone.
    pub fn beside(&self, index: usize, di: f32, dj: f32) -> Slope {
        let (sin, cos) = f64::from(self.direction_deg).to_radians().sin_cos();
        let (a, b) = (f64::from(di * self.u.step()), f64::from(dj * self.v.step()));
        let Slope { u, v } = self.slope(index);
        Slope::new(u + (a * cos - b * sin) as f32, v + (a * sin + b * cos) as f32)
    }

    /// Grid coordinates (i, j) of a running index.
    pub fn coordinates(&self, index: usize) -> (usize, usize) {
        (index % self.u.count.max(1), index / self.u.count.max(1))
    }

    /// Largest difference of the running indices of two neighbours (two slopes on a line, eight in a plane).
    pub fn neighbour_distance(&self) -> usize {
        if self.v.count > 1 { self.u.count + 1 } else { 1 }
    }

    /// All slopes in running order, first axis fastest.
    pub fn slopes(&self) -> impl Iterator<Item = Slope> + '_ {
        (0..self.len()).map(|index| self.slope(index))
    }

    /// Indices of the slope `index` and of the eight around it, in running order; `None` beyond the grid.
    pub fn around(&self, index: usize) -> impl Iterator<Item = Option<usize>> + '_ {
        let (i, j) = self.coordinates(index);
        (-1..=1).flat_map(move |dj| (-1..=1).map(move |di| (di, dj))).map(move |(di, dj)| {
            let i = i.checked_add_signed(di).filter(|&i| i < self.u.count)?;
            let j = j.checked_add_signed(dj).filter(|&j| j < self.v.count)?;
            Some(j * self.u.count + i)
        })
    }

    /// Whether grid coordinates are on the rim, where a neighbour is missing. An axis with one slope has no rim.
    pub fn on_rim(&self, i: usize, j: usize) -> bool {
        (self.u.count > 1 && (i == 0 || i + 1 == self.u.count))
            || (self.v.count > 1 && (j == 0 || j + 1 == self.v.count))
    }

    /// Grid coordinates (first, second axis) of any slope: the inverse of [`Self::at`]; 0 on an axis with one slope.
    pub fn position(&self, slope: Slope) -> (f32, f32) {
        let (sin, cos) = f64::from(self.direction_deg).to_radians().sin_cos();
        let (u, v) = (f64::from(slope.u), f64::from(slope.v));
        let along = |axis: &SlopeAxis, value: f64| {
            if axis.count > 1 { ((value - f64::from(axis.min)) / f64::from(axis.step())) as f32 } else { 0.0 }
        };
        (along(&self.u, u * cos + v * sin), along(&self.v, v * cos - u * sin))
    }

    /// Coordinate of any slope along the first or the second axis, pixels per frame.
    pub(crate) fn along(&self, slope: Slope, second: bool) -> f32 {
        let unit = SlopeAxis { min: 0.0, max: 1.0, count: 2 };
        let (first, other) = Self { u: unit, v: unit, ..*self }.position(slope);
        if second { other } else { first }
    }

    /// Axes with several slopes, and whether each is the second.
    pub(crate) fn axes(&self) -> impl Iterator<Item = (bool, SlopeAxis)> {
        [(false, self.u), (true, self.v)].into_iter().filter(|(_, axis)| axis.count > 1)
    }

    /// Index of the grid's slope nearest to `slope`, by steps along the axes.
    pub fn nearest(&self, slope: Slope) -> usize {
        let (i, j) = self.position(slope);
        let nearest = |at: f32, axis: &SlopeAxis| at.round().clamp(0.0, (axis.count.max(1) - 1) as f32) as usize;
        nearest(j, &self.v) * self.u.count + nearest(i, &self.u)
    }

    /// Whether the grid's slope nearest to `slope` is on the rim; true for slopes beyond the grid.
    pub fn nearest_on_rim(&self, slope: Slope) -> bool {
        let (i, j) = self.coordinates(self.nearest(slope));
        self.on_rim(i, j)
    }

    /// Largest motion of any slope of the grid, pixels per frame.
    pub fn max_magnitude(&self) -> f32 {
        self.slopes().map(Slope::magnitude).fold(0.0, f32::max)
    }
}

/// Word for slopes found from each burst, on the command line and in files.
pub const AUTO: &str = "auto";
/// Direction of the line in a file, where slopes are found on one.
const DIRECTION: &str = "direction_deg";

/// The slopes to search: found from each burst, or given.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Slopes {
    /// Found from each burst; with a direction only on the line through slope 0 in it.
    Auto {
        /// Direction of the line, degrees from +u towards +v.
        direction_deg: Option<f32>,
    },
    /// Grid in pixels per frame, for every burst.
    Given(SlopeGrid),
}

/// Part of [`Slopes`] that a parameter of its own sets.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SlopesPart {
    /// Whether slopes are found.
    Auto,
    /// First axis of the grid.
    U,
    /// Second axis of the grid.
    V,
    /// Direction of the grid, or of the line on which slopes are found.
    Direction,
}

impl Default for Slopes {
    fn default() -> Self {
        Self::AUTO
    }
}

impl Slopes {
    /// Slopes found from each burst, anywhere in the plane.
    pub const AUTO: Self = Self::Auto { direction_deg: None };

    /// Whether slopes are found from each burst.
    pub fn is_auto(self) -> bool {
        matches!(self, Self::Auto { .. })
    }

    /// Grid, where it is given; `None` where slopes are to be found.
    pub fn given(self) -> Option<SlopeGrid> {
        if let Self::Given(grid) = self { Some(grid) } else { None }
    }

    /// Text of a part that has no field of its own; empty where slopes are found.
    pub(super) fn text(self, part: SlopesPart) -> String {
        match (part, self) {
            (SlopesPart::Auto, Self::Auto { .. }) => AUTO.to_owned(),
            (SlopesPart::Direction, Self::Auto { direction_deg: Some(degrees) }) => degrees.to_string(),
            _ => String::new(),
        }
    }

    /// Reads a part that has no field of its own. A range turns the slopes into given ones, 0 along the other axis.
    pub(super) fn read(&mut self, part: SlopesPart, text: &str) -> Result<(), String> {
        let axis = || text.parse::<SlopeAxis>();
        *self = match part {
            SlopesPart::Auto if text == AUTO => Self::AUTO,
            SlopesPart::Auto => return Err(format!("'{text}' is not known")),
            SlopesPart::U => Self::Given(SlopeGrid { u: axis()?, ..SlopeGrid::single(Slope::default()) }),
            SlopesPart::V => Self::Given(SlopeGrid { v: axis()?, ..SlopeGrid::single(Slope::default()) }),
            SlopesPart::Direction => {
                let degrees = text.trim().parse().map_err(|_| format!("'{text}' is not a number"))?;
                Self::Auto { direction_deg: Some(degrees) }
            }
        };
        Ok(())
    }
}

impl From<SlopeGrid> for Slopes {
    fn from(grid: SlopeGrid) -> Self {
        Self::Given(grid)
    }
}

impl Serialize for Slopes {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Auto { direction_deg: None } => serializer.serialize_str(AUTO),
            Self::Auto { direction_deg: Some(degrees) } => {
                let mut line = serializer.serialize_map(Some(2))?;
                line.serialize_entry(AUTO, &true)?;
                line.serialize_entry(DIRECTION, degrees)?;
                line.end()
            }
            Self::Given(grid) => grid.serialize(serializer),
        }
    }
}

impl<'de> Deserialize<'de> for Slopes {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let wrong = |problem: String| de::Error::custom(problem);
        let mut table = match Value::deserialize(deserializer)? {
            Value::String(word) if word == AUTO => return Ok(Self::AUTO),
            Value::Table(table) => table,
            other => {
                return Err(wrong(format!("slopes: {other} is not known; give \"auto\" or a table with u and v")));
            }
        };
        let degrees = table.get(DIRECTION).map(|degrees| degrees.clone().try_into()).transpose();
        // A wrong direction is a fault of `auto` only here: a given grid reports its own.
        match table.remove(AUTO) {
            None => table.try_into().map(Self::Given).map_err(|e| wrong(e.to_string())),
            Some(Value::Boolean(true)) if table.keys().all(|key| key == DIRECTION) => degrees
                .map(|direction_deg| Self::Auto { direction_deg })
                .map_err(|_| wrong("slopes: direction_deg is not a number; give degrees".into())),
            Some(_) => {
                Err(wrong("slopes: auto = true stands alone or with direction_deg; leave out the rest, or auto".into()))
            }
        }
    }
}
