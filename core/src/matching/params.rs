//! The parameters of matching, with their descriptions and checks: the command line, the window and files use [`doc`].

use crate::detector::params::{Param, TextValue, words};
use crate::error::{Error, Result};
use crate::{camera::Camera, files::without_table};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use toml::Table;

/// Geometry of the two views against which the matches are verified.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Geometry {
    /// Matches are not verified.
    None,
    /// The fundamental matrix: any rigid scene, unknown cameras.
    #[default]
    Fundamental,
    /// The essential matrix: any rigid scene, known intrinsics.
    Essential,
    /// A homography: a plane, or a camera that only turns.
    Homography,
}

impl Geometry {
    /// All geometries, in the order in which they are offered.
    pub const ALL: [Self; 4] = [Self::None, Self::Fundamental, Self::Essential, Self::Homography];
}

words!(
    Geometry,
    (None, "none", "None"),
    (Fundamental, "fundamental", "Fundamental"),
    (Essential, "essential", "Essential"),
    (Homography, "homography", "Homography")
);

/// Parameters of matching and verification. The same features and parameters give the same bits.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
#[allow(missing_docs)] // each is described by the record of its name in `doc`
pub struct MatchParams {
    pub ratio: f32,
    pub mutual: bool,
    pub predict: bool,
    pub align: bool,
    pub geometry: Geometry,
    pub max_error_px: f32,
    pub min_inliers: usize,
    pub confidence: f32,
    pub max_iterations: usize,
    pub seed: u64,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub camera: Option<Camera>,
    /// Camera of image B where it has another one than `camera`, which is A's then. No option: a dataset knows both.
    #[serde(skip_deserializing, skip_serializing_if = "Option::is_none")]
    pub camera_b: Option<Camera>,
}

impl Default for MatchParams {
    fn default() -> Self {
        Self {
            ratio: 0.8,
            mutual: true,
            predict: true,
            align: true,
            geometry: Geometry::Fundamental,
            max_error_px: 4.0,
            min_inliers: 15,
            confidence: 0.999,
            max_iterations: 20_000,
            seed: 0,
            camera: None,
            camera_b: None,
        }
    }
}

impl TextValue for Option<Camera> {
    fn text(&self) -> String {
        self.as_ref().map_or_else(|| "none".to_owned(), Camera::to_string)
    }

    fn read(&mut self, text: &str) -> Result<(), String> {
        *self = Some(text.parse()?);
        Ok(())
    }
}

impl MatchParams {
    /// Whether matches are aligned: those that are verified alone can be.
    pub fn aligns(&self) -> bool {
        self.align && self.geometry != Geometry::None
    }

    /// Options that the table `[matching]` in the text of a parameter file gives; none without one.
    ///
    /// # Errors
    /// TOML's error with its place, also of an unknown name.
    pub fn table_of(text: &str) -> Result<Table, String> {
        let [_, text] = without_table(text, "matching");
        let told = |e: toml::de::Error| e.to_string();
        // Errors of the text have a place, those of a table have none.
        let _: BTreeMap<String, Self> = toml::from_str(&text).map_err(told)?;
        let table = text.parse::<Table>().map_err(told)?.remove("matching");
        Ok(table.and_then(|table| table.try_into().ok()).unwrap_or_default())
    }

    /// Checked parameters: those of a [table](Self::table_of), under the `given` values as typed. A `camera` without a
    /// geometry means the essential matrix.
    ///
    /// # Errors
    /// A value that cannot be read, or the first parameter that makes no sense.
    pub fn of_texts<'a>(
        table: Table,
        camera: Option<Camera>,
        given: impl IntoIterator<Item = (Param<Self>, &'a str)>,
    ) -> Result<Self> {
        let names_geometry = table.contains_key(doc::GEOMETRY.name);
        let wrong = |e: toml::de::Error| Error::param("matching", e.to_string().trim_end(), "give what options take");
        let mut params: Self = table.try_into().map_err(wrong)?;
        params.camera = camera.or(params.camera);
        if params.camera.is_some() && !names_geometry {
            params.geometry = Geometry::Essential;
        }
        for (record, text) in given {
            record.set(&mut params, text)?;
        }
        params.validate()?;
        Ok(params)
    }

    /// Checks the parameters.
    pub fn validate(&self) -> Result<()> {
        doc::ALL.iter().try_for_each(|record| record.check(self))?;
        if self.geometry == Geometry::Essential && self.camera.is_none() {
            return Err(Error::param(
                doc::CAMERA.name,
                "the essential matrix needs the camera's intrinsics",
                "give them, such as PINHOLE,640,480,500,500,320,240, or ask for the fundamental matrix",
            ));
        }
        let mut cameras = [&self.camera, &self.camera_b].into_iter().flatten();
        cameras.try_for_each(|camera| camera.validate(doc::CAMERA.name))
    }

    /// Cameras of image A and of image B.
    pub fn cameras(&self) -> Option<[&Camera; 2]> {
        let a = self.camera.as_ref()?;
        Some([a, self.camera_b.as_ref().unwrap_or(a)])
    }

    /// These parameters for a pair with the cameras `a` and `b`. Where one is unknown there is no essential matrix: the
    /// fundamental matrix takes its place.
    pub fn with_cameras(&self, a: Option<&Camera>, b: Option<&Camera>) -> Self {
        let (camera, camera_b) = a.zip(b).map(|(a, b)| (a.clone(), (a != b).then(|| b.clone()))).unzip();
        let is_unknown = camera.is_none() && self.geometry == Geometry::Essential;
        let geometry = if is_unknown { Geometry::Fundamental } else { self.geometry };
        Self { geometry, camera, camera_b: camera_b.flatten(), ..self.clone() }
    }
}

/// Records of the parameters of matching.
pub mod doc {
    use super::{Geometry, MatchParams};
    use crate::detector::params::{Field, Param, ParamDoc, Stage, params};
    use std::ops::Bound::{Excluded, Included, Unbounded};

    fn verified(p: &MatchParams) -> bool {
        !matches!(p.geometry, Geometry::None)
    }

    params! {
        MatchParams;

        RATIO: "ratio", "Ratio test", "", "ratio-test";
        "Max ratio of the distances to the nearest and the second nearest descriptor; 1 switches the test off.",
        "Raise it to keep more matches, of which more are wrong.",
        Param::<MatchParams>::new("R", Stage::Matching, |p| Field::F32(&mut p.ratio))
            .within(
                (Excluded(0.0), Included(1.0)),
                "give more than 0 and at most 1 (0.8 is usual, 1 switches the test off)"
            )
            .dragged(0.002, 3);

        MUTUAL: "mutual", "Mutual check", "", "match";
        "Whether two features must be nearest to each other, and pass the ratio test both ways: true or false.",
        "Switch it off to let several features of A match one of B.",
        Param::<MatchParams>::new("BOOL", Stage::Matching, |p| Field::Flag(&mut p.mutual));

        GEOMETRY: "geometry", "Geometry", "", "geometry";
        "What the matches are verified against: none, fundamental (any scene), essential (any scene, known camera) or homography (a plane, or a camera that only turns).",
        "The more a geometry demands, the fewer wrong matches fit it by chance; a homography rejects what is not on one plane.",
        Param::<MatchParams>::new("WHICH", Stage::Matching, |p| Field::Word(&mut p.geometry));

        PREDICT: "predict", "Predict", "", "match";
        "Whether matching is repeated at the places that the motions of the features and the geometry of the sure matches predict, with a ratio of 0.9 among the features there; a pair whose motions contradict its geometry is refused, or with an alignment left to its pictures: true or false.",
        "Switch it off for the sure matches alone; without motions, as of single frames, nothing changes.",
        Param::<MatchParams>::new("BOOL", Stage::Matching, |p| Field::Flag(&mut p.predict)).used_if(verified);

        ALIGN: "align", "Align", "", "match";
        "Whether inliers are measured by the pictures of their places, each keypoint is moved to where its matches agree, by at most 20 px, and what contradicts these by more than 0.35 times the max error, or all matches around by more than the max error, is no inlier any more; a pair that keeps too few is refused: true or false.",
        "Switch it off for the sure or predicted matches at the places of the blobs.",
        Param::<MatchParams>::new("BOOL", Stage::Matching, |p| Field::Flag(&mut p.align)).used_if(verified);

        MAX_ERROR_PX: "max-error-px", "Max error", "px", "inlier";
        "Max error of an inlier: the Sampson distance from epipolar geometry, or a homography's symmetric transfer error.",
        "Raise it to keep less exact matches, and more wrong ones that fit by chance.",
        Param::<MatchParams>::new("PX", Stage::Matching, |p| Field::F32(&mut p.max_error_px))
            .within((Excluded(0.0), Unbounded), "give more than 0 pixels (4 is usual)")
            .dragged(0.02, 2)
            .used_if(verified);

        MIN_INLIERS: "min-inliers", "Min inliers", "matches", "inlier";
        "Min number of inliers of a geometry; with fewer there is none, and no match is an inlier.",
        "Raise it to trust only pairs with much in common: seven wrong matches always agree on some fundamental matrix, and others fit by chance.",
        Param::<MatchParams>::new("N", Stage::Matching, |p| Field::Usize(&mut p.min_inliers))
            .dragged(0.1, 0)
            .used_if(verified);

        CONFIDENCE: "confidence", "Confidence", "", "consensus";
        "The probability that no better geometry was missed, at which the search for it stops.",
        "Raise it towards 1 to search longer.",
        Param::<MatchParams>::new("P", Stage::Matching, |p| Field::F32(&mut p.confidence))
            .within((Excluded(0.0), Excluded(1.0)), "give a probability between 0 and 1, such as 0.999")
            .dragged(0.0005, 6)
            .used_if(verified);

        MAX_ITERATIONS: "max-iterations", "Max iterations", "samples", "consensus";
        "Max number of samples of matches that are tried.",
        "Raise it where most matches are wrong, for more time.",
        Param::<MatchParams>::new("N", Stage::Matching, |p| Field::Usize(&mut p.max_iterations))
            .within((Included(1.0), Included(1e7)), "give 1 to 10000000 samples")
            .dragged(50.0, 0)
            .used_if(verified);

        SEED: "seed", "Seed", "", "consensus";
        "Seed of the samples of matches.",
        "The same seed gives the same inliers; another one shows how much they depend on chance.",
        Param::<MatchParams>::new("N", Stage::Matching, |p| Field::U64(&mut p.seed)).used_if(verified);

        CAMERA: "camera", "Camera", "", "geometry";
        "Intrinsics of the camera of both images: a model of COLMAP's with width, height and parameters, such as PINHOLE,640,480,500,500,320,240. Models: COLMAP's from SIMPLE_PINHOLE to RAD_TAN_THIN_PRISM_FISHEYE (its numbers 0 to 11).",
        "Needed for the essential matrix; the centre of the first pixel is at (0.5, 0.5) in it, as in COLMAP.",
        Param::<MatchParams>::new("CAMERA", Stage::Matching, |p| Field::Text(&mut p.camera))
            .used_if(|p| matches!(p.geometry, Geometry::Essential));
    }
}
