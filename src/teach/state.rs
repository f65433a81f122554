//! State of the window as a step begins: the tables `set` of lesson and step, otherwise a newly opened window.

use super::part::field_of;
use super::values::{Near, finite};
use crate::detector::{SearchParams, Slope};
use crate::error::Error;
use crate::inspect::slopes::SetUp;
use crate::matching::MatchParams;
use crate::requests::{BurstSource, ViewKind};
use serde::{Deserialize, Deserializer, Serialize, de};

#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Workspace {
    /// Files may name *Methods* as a workspace of its own.
    #[default]
    #[serde(alias = "methods")]
    Inspect,
    Pair,
    Matches,
    Trajectories,
    Lab,
}

/// Arrangement of the pictures of *Inspect*, made from the one in focus.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Layout {
    Single,
    FrameAndStack,
    /// The slope beside the grid's next one, with their cursors not linked.
    TwoSlopes,
    ThreeSlopes,
    FiveSlopes,
    SevenSlopes,
    NineSlopes,
    Scales,
    TwoByTwo,
    /// The motion stack above slices through the frames at the probed place.
    Slice,
    Methods,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum BottomTab {
    #[default]
    Table,
    Tally,
    Noise,
    Slopes,
    Profile,
    Region,
    Compared,
    Methods,
}

/// Flat spot on flat ground, where the SNR is measured: `[u, v, inner, from, to]`, pixels at mid-burst.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(try_from = "[f32; 5]")]
pub struct Spot {
    pub place: [f32; 2],
    pub inner: f32,
    /// Inner and outer radius of the background ring, pixels from the centre.
    pub ground: [f32; 2],
}

impl TryFrom<[f32; 5]> for Spot {
    type Error = String;

    fn try_from(numbers: [f32; 5]) -> Result<Self, String> {
        let [u, v, inner, from, to] = finite(numbers)?;
        if 0.0 < inner && inner <= from && from < to {
            Ok(Self { place: [u, v], inner, ground: [from, to] })
        } else {
            Err(format!(
                "a spot is [u, v, inner, from, to] with 0 < inner ≤ from < to, but inner is {inner}, from {from}, to {to}"
            ))
        }
    }
}

/// Part of the picture that is in view, pixels of the image at mid-burst.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum InView {
    /// The centre (column, row), and the points of the window for each pixel: `[u, v, zoom]`.
    Centre([f32; 3]),
    /// A rectangle that is seen whole, as large as it fits: `[left, top, right, bottom]`.
    Region([f32; 4]),
}

#[derive(Debug, Clone, Default, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct State {
    #[serde(deserialize_with = "built_in_burst")]
    pub burst: Option<BurstSource>,
    #[serde(deserialize_with = "built_in_burst")]
    pub second: Option<BurstSource>,
    pub workspace: Option<Workspace>,
    pub show: Option<ViewKind>,
    pub layout: Option<Layout>,
    pub frame: Option<usize>,
    #[serde(deserialize_with = "slope")]
    pub slope: Option<Slope>,
    pub octave: Option<i32>,
    pub level: Option<i32>,
    #[serde(deserialize_with = "view")]
    pub view: Option<InView>,
    /// Detector's parameters, as in a parameter file: absent ones have their defaults.
    #[serde(deserialize_with = "params")]
    pub params: Option<SearchParams>,
    #[serde(deserialize_with = "matching")]
    pub matching: Option<MatchParams>,
    pub detect: Option<bool>,
    pub features: Option<bool>,
    pub tab: Option<BottomTab>,
    #[serde(deserialize_with = "place")]
    pub probe: Option<[f32; 2]>,
    /// Whether the strongest feature (or, of two bursts, the best match) is selected.
    pub select: Option<bool>,
    pub spot: Option<Spot>,
    /// Places with a ring around them, as the texts speak of them.
    pub rings: Option<Vec<Near>>,
    #[serde(deserialize_with = "set_up")]
    pub set_up: Option<SetUp>,
    /// Whether the built-in reconstruction is in *Trajectories*.
    pub cameras: Option<bool>,
}

impl State {
    /// Values of `self`, and those of `default` for absent ones.
    #[must_use]
    pub(super) fn over(self, default: &Self) -> Self {
        macro_rules! over {
            ($($field:ident)*) => { Self { $($field: self.$field.or_else(|| default.$field.clone()),)* } };
        }
        over! {
            burst second workspace show layout frame slope octave level view
            params matching detect features tab probe select spot rings set_up cameras
        }
    }

    pub fn burst(&self) -> BurstSource {
        self.burst.clone().unwrap_or(BurstSource::Demo)
    }
}

fn built_in_burst<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<BurstSource>, D::Error> {
    let name = String::deserialize(deserializer)?;
    BurstSource::named(&name).map(Some).ok_or_else(|| {
        let names: Vec<&str> = BurstSource::built_in().iter().filter_map(BurstSource::name).collect();
        de::Error::custom(format!("there is no built-in burst '{name}'; give one of {}", names.join(", ")))
    })
}

fn slope<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<Slope>, D::Error> {
    Ok(place(deserializer)?.map(|[u, v]| Slope::new(u, v)))
}

fn place<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<[f32; 2]>, D::Error> {
    finite(<[f32; 2]>::deserialize(deserializer)?).map(Some).map_err(de::Error::custom)
}

fn view<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<InView>, D::Error> {
    let numbers = Vec::<f32>::deserialize(deserializer)?;
    // Three numbers are a centre with a zoom, four a rectangle.
    let in_view = match numbers[..] {
        [u, v, zoom] if (0.01..=100.0).contains(&zoom) => finite([u, v, zoom]).map(InView::Centre),
        [_, _, zoom] => Err(format!("the zoom {zoom} is out of range; give 0.01 to 100 points per pixel")),
        [left, top, right, bottom] if left < right && top < bottom => {
            finite([left, top, right, bottom]).map(InView::Region)
        }
        _ => Err("a view is [left, top, right, bottom] with left < right and top < bottom, or [u, v, zoom]".to_owned()),
    };
    in_view.map(Some).map_err(de::Error::custom)
}

fn set_up<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<SetUp>, D::Error> {
    let set_up = SetUp::deserialize(deserializer)?;
    set_up.check().map_err(de::Error::custom)?;
    Ok(Some(set_up))
}

fn params<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<SearchParams>, D::Error> {
    let params =
        SearchParams::default().with_table(toml::Table::deserialize(deserializer)?).map_err(de::Error::custom)?;
    params.validate().map_err(wrong)?;
    Ok(Some(params))
}

fn matching<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<MatchParams>, D::Error> {
    let params = MatchParams::deserialize(deserializer)?;
    params.validate().map_err(wrong)?;
    Ok(Some(params))
}

fn wrong<E: de::Error>(error: Error) -> E {
    E::custom(format!("{}: {}; {}", field_of(&error.subject), error.problem, error.remedy))
}
