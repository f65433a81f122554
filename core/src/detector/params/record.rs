//! Record of one parameter: all that the program knows about it, in one place.
//!
//! Options, rows of the window, changes by advice, checks, help texts and the page of reference come from a [`Param`].

use super::{Distinct, FrameRange, NoiseGate, SlopeAxis, Slopes, SlopesPart, Word};
use crate::error::{Error, Result};
use crate::files::whole_number;
use std::fmt;
use std::ops::{Bound, Deref, RangeBounds, RangeInclusive};

/// Description of a parameter, in the words of help pages, tooltips and error messages.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ParamDoc {
    /// Name on the command line, without dashes in front; the file's field has `_` for `-`.
    pub name: &'static str,
    /// Name in the window, in sentence case.
    pub label: &'static str,
    /// Unit of the value; empty where it has none.
    pub unit: &'static str,
    /// Entry of the program's glossary that explains it.
    pub term: &'static str,
    /// Meaning, as a sentence.
    pub meaning: &'static str,
    /// Effect of raising (or changing) the value.
    pub effect: &'static str,
}

impl ParamDoc {
    /// Meaning, unit and effect as running text, for help pages and tooltips.
    pub fn help(&self) -> String {
        if self.unit.is_empty() {
            format!("{} {}", self.meaning, self.effect)
        } else {
            format!("{} Unit: {}. {}", self.meaning, self.unit, self.effect)
        }
    }
}

/// Stage of the processing, in order. A parameter belongs to the first stage whose result depends on it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Stage {
    /// Choice of the frames: decides merged frames.
    Frames,
    /// Motion stack: shifting and averaging of the frames.
    Stack,
    /// Scale space and DoG responses of a motion stack.
    Response,
    /// Search for extrema over all slopes and scales, with the noise and all tests.
    Search,
    /// Choice, orientation and description of the features found.
    Description,
    /// Matching of two sets of features.
    Matching,
}

/// Value of a parameter, in place, by its type.
#[allow(missing_docs)] // each is described by the type of its value
pub enum Field<'a> {
    F32(&'a mut f32),
    U32(&'a mut u32),
    I32(&'a mut i32),
    Usize(&'a mut usize),
    U64(&'a mut u64),
    Flag(&'a mut bool),
    /// One of a few named values.
    Word(&'a mut dyn Word),
    Axis(&'a mut SlopeAxis),
    Frames(&'a mut Option<FrameRange>),
    Gate(&'a mut NoiseGate),
    Distinct(&'a mut Distinct),
    /// Value with a syntax of its own.
    Text(&'a mut dyn TextValue),
    /// Part of slopes that has no field of its own.
    Slopes(&'a mut Slopes, SlopesPart),
}

/// Value that is written and read in a syntax of its own.
pub trait TextValue {
    /// Text that [`Self::read`] reads back.
    fn text(&self) -> String;
    /// Reads the value.
    ///
    /// # Errors
    /// The fault in `text`, and an example of what is right.
    fn read(&mut self, text: &str) -> Result<(), String>;
}

impl Slopes {
    pub(super) fn field(&mut self, part: SlopesPart) -> Field<'_> {
        match (part, self) {
            (SlopesPart::U, Self::Given(grid)) => Field::Axis(&mut grid.u),
            (SlopesPart::V, Self::Given(grid)) => Field::Axis(&mut grid.v),
            (SlopesPart::Direction, Self::Given(grid)) => Field::F32(&mut grid.direction_deg),
            (part, slopes) => Field::Slopes(slopes, part),
        }
    }
}

const ALL_FRAMES: &str = "all";

impl Field<'_> {
    /// Text of the value, as options of the commands and changes have it.
    pub fn text(&self) -> String {
        match self {
            Self::F32(x) => x.to_string(),
            Self::U32(n) => n.to_string(),
            Self::I32(n) => n.to_string(),
            Self::Usize(n) => n.to_string(),
            Self::U64(n) => n.to_string(),
            Self::Flag(flag) => flag.to_string(),
            Self::Word(word) => word.word().to_owned(),
            Self::Axis(axis) => axis.to_string(),
            Self::Frames(frames) => frames.map_or_else(|| ALL_FRAMES.to_owned(), |range| range.to_string()),
            Self::Gate(gate) => gate.to_string(),
            Self::Distinct(distinct) => distinct.to_string(),
            Self::Text(value) => value.text(),
            Self::Slopes(slopes, part) => slopes.text(*part),
        }
    }

    /// Reads the value from what [`Self::text`] writes.
    ///
    /// # Errors
    /// The fault in `text`.
    pub fn read(self, text: &str) -> Result<(), String> {
        fn number<T: std::str::FromStr>(place: &mut T, text: &str, kind: &str) -> Result<(), String> {
            text.trim().parse().map(|value| *place = value).map_err(|_| format!("'{text}' is not a {kind}"))
        }
        match self {
            Self::F32(x) => number(x, text, "number")?,
            Self::U32(n) => *n = whole_number(text)?,
            Self::I32(n) => number(n, text, "whole number")?,
            Self::Usize(n) => *n = whole_number(text)?,
            Self::U64(n) => *n = whole_number(text)?,
            Self::Flag(flag) => *flag = text.trim().parse().map_err(|_| format!("'{text}' is not true or false"))?,
            Self::Word(word) => word.set_word(text).then_some(()).ok_or_else(|| format!("'{text}' is not known"))?,
            Self::Axis(axis) => *axis = text.parse()?,
            Self::Frames(frames) => {
                *frames = if text.trim() == ALL_FRAMES { None } else { Some(text.parse()?) };
            }
            Self::Gate(gate) => *gate = text.parse()?,
            Self::Distinct(distinct) => *distinct = text.parse()?,
            Self::Text(value) => value.read(text)?,
            Self::Slopes(slopes, part) => slopes.read(part, text)?,
        }
        Ok(())
    }

    /// Value as a number, for checks of its range; `None` for other kinds.
    fn number(&self) -> Option<f64> {
        match self {
            Self::F32(x) => Some(f64::from(**x)),
            Self::U32(n) => Some(f64::from(**n)),
            Self::I32(n) => Some(f64::from(**n)),
            Self::Usize(n) => Some(**n as f64),
            Self::U64(n) => Some(**n as f64),
            Self::Gate(NoiseGate::Factor(x)) | Self::Distinct(Distinct::Radius(x)) => Some(f64::from(*x)),
            Self::Slopes(Slopes::Auto { direction_deg: Some(x) }, SlopesPart::Direction) => Some(f64::from(*x)),
            _ => None,
        }
    }

    fn fault(&self, bounds: Option<&Bounds>) -> Result<(), (String, String)> {
        match (self, self.number(), bounds) {
            (Self::Axis(axis), ..) => axis.check(),
            (Self::Frames(Some(range)), ..) => range.check(),
            (_, Some(number), Some(bounds)) if !bounds.allow(number) => {
                let problem = if number.is_finite() { self.text() } else { "it is not finite".to_owned() };
                Err((problem, bounds.remedy.to_owned()))
            }
            _ => Ok(()),
        }
    }

    /// Names of the values to choose from: on the command line, and in the window; `None` for other kinds.
    pub fn words(&self) -> Option<&'static [(&'static str, &'static str)]> {
        if let Self::Word(word) = self { Some(word.words()) } else { None }
    }
}

/// Range of the numbers that a parameter takes; NaN and infinity are never allowed.
#[derive(Debug, Clone, Copy)]
pub struct Bounds {
    /// Least and greatest number, each included, excluded or absent.
    pub range: (Bound<f64>, Bound<f64>),
    /// Remedy that the error gives for other numbers.
    pub remedy: &'static str,
}

impl Bounds {
    /// Bounds of the numbers in `range`; `remedy` is given for others.
    pub const fn new(range: (Bound<f64>, Bound<f64>), remedy: &'static str) -> Self {
        Self { range, remedy }
    }

    fn allow(&self, number: f64) -> bool {
        number.is_finite() && self.range.contains(&number)
    }

    /// Checks a number given for `parameter`.
    ///
    /// # Errors
    /// Fault of the number, with the remedy.
    pub fn check(&self, parameter: &'static str, number: f64) -> Result<()> {
        if self.allow(number) {
            return Ok(());
        }
        // 1e300, not a one with three hundred zeros; NaN is NaN in both forms.
        let problem = if number.abs() < 1e15 { number.to_string() } else { format!("{number:e}") };
        Err(Error::param(parameter, problem, self.remedy.to_owned()))
    }

    /// Numbers from the lower to the upper bound, both included, for a field of the window.
    pub fn span(&self) -> RangeInclusive<f64> {
        let end = |bound: Bound<f64>, without: f64| match bound {
            Bound::Included(end) | Bound::Excluded(end) => end,
            Bound::Unbounded => without,
        };
        end(self.range.0, f64::MIN)..=end(self.range.1, f64::MAX)
    }
}

impl fmt::Display for Bounds {
    /// Writes the range, such as `1 … 16` or `> 0`; nothing where all numbers are allowed.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        use Bound::{Excluded, Included, Unbounded};
        match self.range {
            (Included(least), Included(most)) => write!(f, "{least} … {most}"),
            (Excluded(least), Included(most)) => write!(f, "> {least}, ≤ {most}"),
            (Included(least), Excluded(most)) => write!(f, "≥ {least}, < {most}"),
            (Excluded(least), Excluded(most)) => write!(f, "> {least}, < {most}"),
            (Included(least), Unbounded) => write!(f, "≥ {least}"),
            (Excluded(least), Unbounded) => write!(f, "> {least}"),
            (Unbounded, Included(most)) => write!(f, "≤ {most}"),
            (Unbounded, Excluded(most)) => write!(f, "< {most}"),
            (Unbounded, Unbounded) => Ok(()),
        }
    }
}

/// Field of the window for a number, dragged or typed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Drag {
    /// Change for one point of dragging, in the parameter's unit.
    pub speed: f64,
    /// Largest number of decimals shown; integers have none.
    pub decimals: usize,
    /// Text after the number.
    pub suffix: &'static str,
    /// Word that stands for 0.
    pub zero: Option<&'static str>,
}

/// Record of one parameter of `P`. Records are equal if they describe the same parameter.
pub struct Param<P: 'static> {
    /// Description for people; the record dereferences to it.
    pub doc: ParamDoc,
    /// Name of the value in help pages, such as N.
    pub placeholder: &'static str,
    /// First stage whose result depends on the value.
    pub stage: Stage,
    /// Accessor of the value in the parameters.
    pub field: fn(&mut P) -> Field<'_>,
    /// Default in words, where it depends on what else is given.
    pub default_words: Option<&'static str>,
    /// Range of the number; `None` where any value that can be read is allowed.
    pub bounds: Option<Bounds>,
    /// Field of the window for its number.
    pub drag: Drag,
    /// Whether the value has an effect beside the other parameters.
    pub in_use: fn(&P) -> bool,
}

impl<P> Param<P> {
    /// Record of a parameter with no bounds, which always has an effect.
    pub const fn new(placeholder: &'static str, stage: Stage, field: fn(&mut P) -> Field<'_>) -> Self {
        let doc = ParamDoc { name: "", label: "", unit: "", term: "", meaning: "", effect: "" };
        let drag = Drag { speed: 0.05, decimals: 2, suffix: "", zero: None };
        Self { doc, placeholder, stage, field, default_words: None, bounds: None, drag, in_use: |_| true }
    }

    /// Record of a parameter whose number is in `range`; `remedy` is given for others.
    pub const fn within(self, range: (Bound<f64>, Bound<f64>), remedy: &'static str) -> Self {
        Self { bounds: Some(Bounds::new(range, remedy)), ..self }
    }

    /// Record with a field of the window of this speed and number of decimals.
    pub const fn dragged(self, speed: f64, decimals: usize) -> Self {
        Self { drag: Drag { speed, decimals, ..self.drag }, ..self }
    }

    /// Record with a text after the number in the window.
    pub const fn followed_by(self, suffix: &'static str) -> Self {
        Self { drag: Drag { suffix, ..self.drag }, ..self }
    }

    /// Record with a word that stands for 0 in the window.
    pub const fn zero_is(self, word: &'static str) -> Self {
        Self { drag: Drag { zero: Some(word), ..self.drag }, ..self }
    }

    /// Record whose default is given in words.
    pub const fn by_default(self, words: &'static str) -> Self {
        Self { default_words: Some(words), ..self }
    }

    /// Record of a parameter that has an effect only where `in_use` says so.
    pub const fn used_if(self, in_use: fn(&P) -> bool) -> Self {
        Self { in_use, ..self }
    }

    /// Sets the value in `params` from `text`.
    ///
    /// # Errors
    /// The fault in `text`; the value is not checked otherwise.
    pub fn read(&self, params: &mut P, text: &str) -> Result<(), String> {
        (self.field)(params).read(text)
    }

    /// Sets the value in `params` from an option of the command line.
    ///
    /// # Errors
    /// The fault in `text`, with a remedy. The value is checked only for whether it can be read.
    pub fn set(&self, params: &mut P, text: &str) -> Result<()> {
        let field = (self.field)(params);
        // The remedy names what this kind of value takes, since the problem alone does not.
        let remedy = match (field.words(), self.bounds) {
            (Some(words), _) => {
                let words: Vec<&str> = words.iter().map(|(word, _)| *word).collect();
                format!("give one of {}", words.join(", "))
            }
            (None, Some(bounds)) => bounds.remedy.to_owned(),
            (None, None) if self.placeholder == "N" => "give one".to_owned(),
            (None, None) => format!("give {}", self.placeholder),
        };
        field.read(text).map_err(|problem| Error::param(self.doc.name, problem, remedy))
    }
}

impl<P: Clone> Param<P> {
    /// Text of the value in `params`, which [`Self::read`] reads back.
    pub fn text(&self, params: &P) -> String {
        (self.field)(&mut params.clone()).text()
    }

    /// Checks the value in `params` by itself, without the other parameters.
    ///
    /// # Errors
    /// Fault of the value, with a remedy.
    pub fn check(&self, params: &P) -> Result<()> {
        let fault = (self.field)(&mut params.clone()).fault(self.bounds.as_ref());
        fault.map_err(|(problem, remedy)| Error::param(self.doc.name, problem, remedy))
    }
}

impl<P: Default> Param<P> {
    /// Default, as typed on the command line or in words.
    pub fn default_text(&self) -> String {
        self.default_words.map_or_else(|| (self.field)(&mut P::default()).text(), str::to_owned)
    }

    /// Text of `-h`: the meaning and the default.
    pub fn short_help(&self) -> String {
        format!("{} [default: {}]", self.meaning.trim_end_matches('.'), self.default_text())
    }

    /// Text of `--help`: all of the description, and the default.
    pub fn long_help(&self) -> String {
        format!("{} [default: {}]", self.help(), self.default_text())
    }
}

impl<P> Clone for Param<P> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<P> Copy for Param<P> {}

impl<P> PartialEq for Param<P> {
    fn eq(&self, other: &Self) -> bool {
        self.doc == other.doc
    }
}

impl<P> Eq for Param<P> {}

impl<P> fmt::Debug for Param<P> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.doc.name)
    }
}

impl<P> Deref for Param<P> {
    type Target = ParamDoc;

    fn deref(&self) -> &ParamDoc {
        &self.doc
    }
}

/// Declares the [`Param`] of each parameter, with these fields of its [`ParamDoc`], and the list of all.
macro_rules! params {
    ($params:ty; $($id:ident: $name:literal, $label:literal, $unit:literal, $term:literal;
        $meaning:literal, $effect:literal, $record:expr;)+) => {
        $(
            #[doc = concat!($meaning, " ", $effect)]
            pub const $id: Param<$params> = Param {
                doc: ParamDoc {
                    name: $name,
                    label: $label,
                    unit: $unit,
                    term: $term,
                    meaning: $meaning,
                    effect: $effect,
                },
                ..$record
            };
        )+

        /// Records of all parameters, in the order in which they are shown.
        pub const ALL: [Param<$params>; [$($name),+].len()] = [$($id),+];
    };
}
pub(crate) use params;
