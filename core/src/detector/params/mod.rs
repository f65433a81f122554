//! Parameters of the detector, their records and checks.
//!
//! Each parameter has one record ([`Param`], all of them in [`doc::ALL`]), from which its option, its row in the
//! window, its checks and its help are made. A parameter file is TOML with the fields of [`DetectorParams`]; a missing
//! field has its default, or what goes with the rules that the file chooses.

mod change;
mod choices;
pub mod doc;
mod record;
mod rules;
mod searched;
pub mod slope_grid;
mod validate;

pub use crate::burst::FrameRange;
pub use change::ParamChange;
pub(crate) use choices::words;
pub use choices::{
    CoarseStart, DescribeSlope, Distinct, Flicker, Interpolation, Localisation, Method, NoiseGate, NoiseModelKind,
    SearchSlopes, SlopeExtrema, SlopeNeighbours, Word,
};
pub use doc::DetectorParams;
pub(crate) use record::params;
pub use record::{Bounds, Drag, Field, Param, ParamDoc, Stage, TextValue};
pub use rules::Rules;
pub use searched::{AUTO, SearchParams, SlopeChoice};
pub use slope_grid::{MAX_SLOPES, Slope, SlopeAxis, SlopeGrid};

use toml::Table;

impl DetectorParams {
    /// Indices into the burst of the frames that take part: the whole range for BuFF and the merge, its middle frame
    /// for SIFT.
    pub fn used_frames(&self, frame_count: usize) -> std::ops::Range<usize> {
        let range = self.frames.map_or(0..frame_count, |r| r.start..r.end.min(frame_count));
        match self.method {
            Method::Buff | Method::Merge => range,
            Method::Sift => {
                let middle = range.start + range.len() / 2;
                middle..middle + 1
            }
        }
    }

    /// Slopes that take part: the grid for BuFF, slope 0 for a single image.
    pub fn used_slopes(&self) -> SlopeGrid {
        match self.method {
            Method::Buff => self.slopes,
            Method::Sift | Method::Merge => SlopeGrid::single(Slope::default()),
        }
    }

    /// Rule for candidates that takes part: with one slope there is no other to compare with.
    pub fn used_extrema(&self) -> SlopeExtrema {
        if self.used_slopes().len() == 1 { SlopeExtrema::Each } else { self.slope_extrema }
    }

    /// These parameters with those of `other` that change neither a stack nor a sample of D, only the judgement of what
    /// a search left: see [`Trail::rejudged`](crate::detector::Trail::rejudged).
    pub fn judged_as(&self, other: &Self) -> Self {
        let &Self { noise_gate, peak_threshold, edge_threshold, distinct, distinct_scale, max_features, .. } = other;
        Self { noise_gate, peak_threshold, edge_threshold, distinct, distinct_scale, max_features, ..self.clone() }
    }

    /// Texts of the parameters that decide the result of `stage`: those of this stage and of the ones before it.
    pub fn deciding(&self, stage: Stage) -> Vec<String> {
        doc::ALL.iter().filter(|record| record.stage <= stage).map(|record| record.text(self)).collect()
    }

    /// Reads a parameter file.
    ///
    /// # Errors
    /// TOML's error with its place, or the first parameter that makes no sense.
    pub fn from_toml(text: &str) -> Result<Self, String> {
        let _: Self = toml::from_str(text).map_err(|e| e.to_string())?;
        // Errors of the text have a place, those of a table have none.
        let params = Self::of_table(text.parse().map_err(|e: toml::de::Error| e.to_string())?)?;
        params.validate().map_err(|e| e.to_string())?;
        Ok(params)
    }

    /// Parameters of a file's table. What is missing is that of the rules it chooses.
    fn of_table(table: Table) -> Result<Self, String> {
        let given: Self = table.clone().try_into().map_err(|e: toml::de::Error| e.to_string())?;
        let base = Self::default().under(given.rules);
        let mut whole = Table::try_from(&base).expect("parameters are plain values, which TOML can always hold");
        whole.extend(table);
        whole.try_into().map_err(|e: toml::de::Error| e.to_string())
    }

    /// Text of the parameter file, which [`Self::from_toml`] reads back.
    pub fn to_toml(&self) -> String {
        let body = toml::to_string(self).expect("parameters are plain values, which TOML can always hold");
        format!("# Burstscope detector parameters. Slopes are in pixels of the input image per frame.\n{body}")
    }
}

/// Side in pixels below which an octave is not searched.
pub const MIN_OCTAVE_SIDE: usize = 16;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::burst::Positions;

    #[test]
    fn a_file_may_fix_the_gate_and_the_frames() {
        let text =
            "noise_gate = 4.5\nframes = { start = 2, end = 9 }\n[slopes]\nv = { min = -1.0, max = 1.0, count = 3 }\n";
        let params = DetectorParams::from_toml(text).expect("valid");
        assert_eq!(params.noise_gate, NoiseGate::Factor(4.5));
        assert_eq!(params.used_frames(20), 2..9);
        assert!(params.slopes.is_plane());
        assert_eq!(DetectorParams::from_toml(&params.to_toml()), Ok(params));
    }

    #[test]
    fn rules_of_a_file_bring_what_the_file_does_not_say() {
        let params = DetectorParams::from_toml("rules = \"buff\"\nlevels = 5\n").expect("valid");
        assert_eq!(params, DetectorParams { levels: 5, ..DetectorParams::default().under(Rules::BUFF) });
        assert_eq!(DetectorParams::from_toml(&params.to_toml()), Ok(params.clone()));
        let search = SearchParams::from_toml("rules = \"buff\"").expect("valid");
        assert_eq!(search.detector, DetectorParams::default().under(Rules::BUFF));
        let given = [(doc::LEVELS, "5"), (doc::RULES, "buff")];
        assert_eq!(SearchParams::default().with_texts(given).expect("valid").detector, params);
    }

    #[test]
    fn nonsense_is_named_with_its_remedy() {
        let good = DetectorParams::default;
        let cases: [(DetectorParams, &str); 9] = [
            (DetectorParams { slopes: SlopeGrid::line(3.0..=-3.0, 7), ..good() }, "slopes-u"),
            (DetectorParams { slopes: SlopeGrid::line(0.0..=0.0, 2), ..good() }, "slopes-u"),
            (DetectorParams { slopes: SlopeGrid::plane(0.0..=1.0, 100, 0.0..=1.0, 100), ..good() }, "slopes-v"),
            (DetectorParams { frames: Some(FrameRange { start: 3, end: 3 }), ..good() }, "frames"),
            (DetectorParams { octaves: 0, ..good() }, "octaves"),
            (DetectorParams { levels: 11, ..good() }, "levels"),
            (DetectorParams { peak_threshold: f32::NAN, ..good() }, "peak-threshold"),
            (DetectorParams { edge_threshold: 0.5, ..good() }, "edge-threshold"),
            (DetectorParams { noise_gate: NoiseGate::Factor(-1.0), ..good() }, "noise-gate"),
        ];
        for (params, name) in cases {
            assert_eq!(params.validate().expect_err(name).subject, name);
        }
        let one_frame = DetectorParams::default().validate_for(&Positions::even(1), (100, 100)).expect_err("one frame");
        assert_eq!(one_frame.subject, "frames");
        let sift = DetectorParams { method: Method::Sift, ..good() };
        assert_eq!(sift.validate_for(&Positions::even(1), (64, 64)), Ok(()));
        let too_fast = DetectorParams { slopes: SlopeGrid::line(-99.0..=99.0, 3), ..good() };
        assert_eq!(too_fast.validate_for(&Positions::even(10), (100, 100)).expect_err("too fast").subject, "slopes-u");
    }

    #[test]
    fn every_field_has_a_record_and_every_record_a_field() {
        // The reader's error names all fields, those that are left out of files too.
        let error = DetectorParams::from_toml("nonsense = 1").expect_err("no such field");
        let (_, expected) = error.split_once("expected one of").expect("the names of the fields");
        let fields: Vec<&str> = expected.split('`').skip(1).step_by(2).collect();
        assert!(fields.len() > 15 && fields.contains(&"frames"), "{error}");
        for field in fields.iter().filter(|field| **field != "slopes") {
            assert!(doc::ALL.iter().any(|d| d.name.replace('-', "_") == *field), "{field} has no record");
        }
        for record in doc::ALL.iter().filter(|record| !record.name.starts_with("slopes")) {
            let field = record.name.replace('-', "_");
            assert!(fields.contains(&field.as_str()) || *record == doc::SLOPE_DIRECTION, "{field} is no field");
        }
    }

    #[test]
    fn words_are_those_of_files_and_defaults_are_within_their_bounds() {
        for record in doc::ALL {
            assert_eq!(record.check(&DetectorParams::default()), Ok(()), "{}", record.name);
            let mut params = DetectorParams::default();
            for (word, _) in (record.field)(&mut params).words().unwrap_or_default() {
                record.read(&mut params, word).expect(word);
                let table = toml::Table::try_from(&params).expect("plain values");
                assert_eq!(table[&record.name.replace('-', "_")].as_str(), Some(*word));
            }
        }
    }

    #[test]
    fn a_stage_is_decided_by_its_own_parameters_and_those_of_the_stages_before() {
        let before = DetectorParams::default();
        let after = DetectorParams { levels: 3, ..before.clone() };
        assert_eq!(before.deciding(Stage::Stack), after.deciding(Stage::Stack));
        assert_ne!(before.deciding(Stage::Response), after.deciding(Stage::Response));
        assert_ne!(before.deciding(Stage::Search), after.deciding(Stage::Search));
        assert_eq!(before.deciding(Stage::Matching).len(), doc::ALL.len());
    }
}
