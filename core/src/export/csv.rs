//! Tables as CSV: features, matches, and profiles of pictures; a header line, then one line for each, in order.
//!
//! Numbers have the fewest digits that read back to the same `f32`. `at_slope_limit` is 1 or 0; `motion` is a word, and
//! nothing else is. An infinite `snr` (a noiseless burst) is written `inf`, which numpy, pandas and R read.

use super::atomic::write_whole;
use super::drawing::{Cell, Table};
use crate::detector::{Feature, Moves, Quantity};
use crate::error::{Error, Result};
use crate::files::{self, MAX_TABLE_BYTES, read_bytes, read_text};
use crate::plane::sample::ProfileSample;
use std::io::{BufRead, BufReader, Read, Write};
use std::path::Path;

/// Header of a table of features: the keys of [`Quantity::STORED`].
pub fn feature_header() -> String {
    header_of(Quantity::STORED.len())
}

fn header_of(columns: usize) -> String {
    Quantity::STORED[..columns].iter().map(|quantity| quantity.record().key).collect::<Vec<_>>().join(",")
}

/// Numbers of columns of tables of features, also of earlier versions.
fn feature_columns() -> impl Iterator<Item = usize> {
    std::iter::once(Quantity::STORED.len()).chain(Quantity::STORED_EARLIER)
}

/// Columns that follow those of a feature, where features were judged.
pub const VERDICT_COLUMNS: &str = ",verdict,coherence";

/// Verdict on a feature.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FeatureVerdict {
    /// Its word.
    pub word: &'static str,
    /// Its place among the verdicts, from 0.
    pub code: u8,
    /// Coherence, 0 … 1; `None` where single frames are too noisy to be compared.
    pub coherence: Option<f32>,
}

/// Writes the features as CSV, with their verdicts, one for each, where they were judged.
///
/// ```
/// use burstscope_core::export::{read_features_csv, write_csv};
/// use burstscope_core::{DetectorParams, Monitor, detect, synth::demo_burst};
/// let found = detect(&demo_burst(), &DetectorParams::default(), &Monitor::default())?;
/// let folder = tempfile::tempdir()?;
/// let table = folder.path().join("demo.csv");
/// write_csv(&table, &found.features, None)?;
/// let read = read_features_csv(&table)?;
/// assert_eq!((read.len(), read[0].u), (found.features.len(), found.features[0].u));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn write_csv(path: &Path, features: &[Feature], verdicts: Option<&[FeatureVerdict]>) -> Result<()> {
    write_whole(path, |out| {
        writeln!(out, "{}{}", feature_header(), verdicts.map_or("", |_| VERDICT_COLUMNS))?;
        for (index, feature) in features.iter().enumerate() {
            write!(out, "{}", Quantity::STORED.map(|quantity| quantity.cell(feature)).join(","))?;
            if let Some(FeatureVerdict { word, coherence, .. }) = verdicts.map(|verdicts| verdicts[index]) {
                write!(out, ",{word},{}", coherence.map_or_else(String::new, |coherence| coherence.to_string()))?;
            }
            writeln!(out)?;
        }
        Ok(())
    })
}

/// Reads a table that [`write_csv`] wrote, also one of an earlier version, without field of motion, ghosts or edges;
/// verdicts are left out, as they are found again with the burst. The header must be exact and every line complete.
/// `slope_index` is 0, since the table does not have it.
///
/// # Errors
/// The file cannot be read, or a line has a wrong form; it is named with its number.
pub fn read_features_csv(path: &Path) -> Result<Vec<Feature>> {
    let bytes = read_bytes(path, MAX_TABLE_BYTES).map_err(|e| Error::unread_file(path, e))?;
    let text = std::str::from_utf8(&bytes).map_err(|e| {
        let line = 1 + bytes[..e.valid_up_to()].iter().filter(|b| **b == b'\n').count();
        Error::in_line(path, line, "this is not text; save it as UTF-8")
    })?;
    parse(text).map_err(|(line, problem)| Error::in_line(path, line, &problem))
}

/// The error is the number of the wrong line and its problem.
fn parse(text: &str) -> Result<Vec<Feature>, (usize, String)> {
    let mut lines = text.lines().enumerate().map(|(i, line)| (i + 1, line));
    let first = lines.next().map_or("", |(_, first)| first);
    let judged = usize::from(first.ends_with(VERDICT_COLUMNS)) * VERDICT_COLUMNS.matches(',').count();
    let first = first.strip_suffix(VERDICT_COLUMNS).unwrap_or(first);
    let columns = feature_columns().find(|&count| header_of(count) == first);
    let columns = columns.ok_or_else(|| (1, format!("the header must be {}", feature_header())))?;
    lines.map(|(number, line)| row(line, columns, judged).map_err(|problem| (number, problem))).collect()
}

fn row(line: &str, columns: usize, judged: usize) -> Result<Feature, String> {
    let cells: Vec<&str> = line.split(',').collect();
    if cells.len() != columns + judged {
        return Err(format!("there must be {} cells, not {}", columns + judged, cells.len()));
    }
    // Columns that a shorter table lacks mean that no field of motion was found.
    let mut feature = Feature { field_sigma: f32::INFINITY, ..Feature::default() };
    for (quantity, cell) in Quantity::STORED.into_iter().zip(&cells[..columns]) {
        let wrong = |right| format!("{} must be {right}, not '{cell}'", quantity.record().key);
        quantity.read(&mut feature, cell).map_err(wrong)?;
    }
    // A table without that column: the word follows from the numbers.
    if columns < Quantity::STORED.len() {
        feature.moves = Moves::by_numbers(&feature);
    }
    Ok(feature)
}

/// Header of tables of curves.
pub const CURVE_COLUMNS: &str = "set,plot,curve,x,y,low,high";
/// Header of tables of a burst's slopes.
pub const SPECTRUM_COLUMNS: &str = "slope_u,slope_v,searched,features,at_limit,evidence";
/// Header of tables of methods on charts.
pub const METHOD_COLUMNS: &str = "snr,frames,method,found,found_error,default_found,default_found_error,default_false,default_false_error,default_false_per_disc,noise_ratio";
/// Header of tables of the middle frames of a burst.
pub const BURST_FRAMES_COLUMNS: &str =
    "frames,features,confirmed,unconfirmed,discs_found,false_features,putative,inliers";
/// Header of tables of errors of features.
pub const ACCURACY_COLUMNS: &str = "charts,snr,error,count,median,percentile_95,mean,mean_error";
/// Header of tables of false features on noise.
pub const NOISE_COLUMNS: &str =
    "noise,sigma,mean,bits,search,slopes,noise_gate,per_megapixel,standard_error,false_features,most_in_a_burst";
/// Header of tables of the matches of methods.
pub const METHOD_MATCH_COLUMNS: &str = "method,keypoints_per_image,putative_per_image,inliers_per_image,match_ratio,match_score,inlier_ratio,verified_pairs,on_gold_geometry_per_image";
/// Header of tables of right matches by the angle between two cameras.
pub const ANGLE_COLUMNS: &str = "method,from_deg,to_deg,pairs,seen_by_both,matches,right,precision";
/// Header of tables of errors of poses.
pub const POSE_COLUMNS: &str = "pose_error,rmse,mean,median,max";
/// Header of tables of the bursts of a flight.
pub const FLIGHT_COLUMNS: &str =
    "burst,frames,width,height,frame_noise,slopes_fit,slopes,features,motion,times,error,verified_pairs";
/// Headers of tables that commands write where they are asked to.
const OF_COMMANDS: [&str; 10] = [
    FLIGHT_COLUMNS,
    SPECTRUM_COLUMNS,
    METHOD_COLUMNS,
    BURST_FRAMES_COLUMNS,
    ACCURACY_COLUMNS,
    NOISE_COLUMNS,
    METHOD_MATCH_COLUMNS,
    ANGLE_COLUMNS,
    POSE_COLUMNS,
    PLANTED_COLUMNS,
];
/// Header of tables of planted things.
pub const PLANTED_COLUMNS: &str = "seed,id,varied,u,v,radius,slope_u,slope_v,sign,snr,amplitude,frames,expected_snr_d,found,found_slope_u,found_slope_v,found_snr,failed,why";

/// Whether the file at `path` has one of our headers, as many cells on every line, and a complete last one.
pub(super) fn is_table(path: &Path) -> bool {
    // Those of matches of earlier versions end earlier.
    let is_of_matches =
        |header: &str| MATCH_COLUMNS.strip_prefix(header).is_some_and(|more| ["", MATCHES_SINCE].contains(&more));
    let is_known = |header: &str| {
        is_of_matches(header)
            || [PROFILE_COLUMNS, CURVE_COLUMNS].contains(&header)
            || OF_COMMANDS.contains(&header)
            || feature_columns().any(|count| {
                header.strip_prefix(&header_of(count)).is_some_and(|more| ["", VERDICT_COLUMNS].contains(&more))
            })
    };
    // Commas outside of quotes.
    let commas = |line: &str| line.split('"').step_by(2).map(|part| part.matches(',').count()).sum::<usize>();
    first_line(path).is_some_and(|header| is_known(&header))
        && read_text(path, MAX_TABLE_BYTES).is_ok_and(|text| {
            let count = commas(text.lines().next().unwrap_or_default());
            text.ends_with('\n') && text.lines().all(|line| commas(line) == count)
        })
}

/// The first line of the regular file at `path`, if it is short enough for a header.
pub(super) fn first_line(path: &Path) -> Option<String> {
    let mut line = String::new();
    let file = files::open(path).ok()?;
    // A file without line ends may be of any length.
    BufReader::new(file.take(1024)).read_line(&mut line).ok()?;
    line.strip_suffix('\n').map(str::to_owned)
}

/// Row of the table of matches: everything that commands and libraries report about a match.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MatchRow {
    /// Indices of the features in images A and B.
    pub features: [usize; 2],
    /// (u, v) in A and in B as they were found, pixels.
    pub places: [[f32; 2]; 2],
    /// (u, v) in A and in B after the alignment, pixels; as found where nothing was measured.
    pub aligned: [[f32; 2]; 2],
    /// Distance of the descriptors.
    pub distance: f32,
    /// Ratio of the distances to the nearest and the second nearest of those compared; `None` without a second.
    pub ratio: Option<f32>,
    /// Of a predicted match the number of places compared, and its ratio among all of B; `None` for a sure one.
    pub predicted: Option<(usize, Option<f32>)>,
    /// Error from the geometry at the aligned places and at those found, pixels; `None` where it is not defined.
    pub error_px: [Option<f32>; 2],
    /// Whether it is an inlier; `None` where no geometry was requested.
    pub inlier: Option<bool>,
    /// Vector from the place in B to A's place seen there (u, v), pixels, and the correlation; `None` if not measured.
    pub measured: Option<([f64; 2], f64)>,
}

impl MatchRow {
    /// Word for how the match was found: `sure` or `predicted`.
    pub fn how(&self) -> &'static str {
        if self.predicted.is_some() { "predicted" } else { "sure" }
    }

    /// Cells in the order of [`MATCH_COLUMNS`], empty where there is no value.
    fn cells(&self) -> Vec<String> {
        let Self { features: [a, b], places, aligned, predicted, error_px: [error_px, as_found], measured, .. } = self;
        let known = |x: Option<f32>| x.filter(|x| x.is_finite()).map_or_else(String::new, |x| x.to_string());
        let short = |x: Option<f64>| x.map_or_else(String::new, |x| format!("{x:.4}"));
        let mut cells = vec![a.to_string(), b.to_string()];
        cells.extend(places.as_flattened().iter().map(f32::to_string));
        cells.extend([self.distance.to_string(), known(self.ratio), known(*error_px)]);
        cells.push(self.inlier.map_or_else(String::new, |inlier| u8::from(inlier).to_string()));
        cells.extend([0, 1].map(|k| short(measured.map(|(shift, _)| shift[k]))));
        cells.extend([short(measured.map(|(_, correlation)| correlation)), self.how().to_owned()]);
        cells.push(predicted.map_or_else(String::new, |(among, _)| among.to_string()));
        cells.push(known(predicted.and_then(|(_, ratio_among_all)| ratio_among_all)));
        cells.extend(aligned.as_flattened().iter().map(f32::to_string));
        cells.push(known(*as_found));
        cells
    }
}

/// Header of tables of matches.
pub const MATCH_COLUMNS: &str = "a,b,u_a,v_a,u_b,v_b,distance,ratio,error_px,inlier,shift_u_b,shift_v_b,correlation,\
    how,among,ratio_among_all,aligned_u_a,aligned_v_a,aligned_u_b,aligned_v_b,error_found_px";
/// Columns that those of earlier versions do not have.
const MATCHES_SINCE: &str = ",how,among,ratio_among_all,aligned_u_a,aligned_v_a,aligned_u_b,aligned_v_b,error_found_px";

/// Writes the matches as CSV.
pub fn write_matches_csv(path: &Path, matches: &[MatchRow]) -> Result<()> {
    write_whole(path, |out| {
        writeln!(out, "{MATCH_COLUMNS}")?;
        matches.iter().try_for_each(|row| writeln!(out, "{}", row.cells().join(",")))
    })
}

/// Header of tables of profiles.
pub const PROFILE_COLUMNS: &str = "picture,distance_px,u,v,value";

/// The profiles of pictures with these names, one after the other; positions in pixels of the input image, values as
/// fractions of full scale. A sample outside its picture has no value.
pub fn profiles_table(profiles: &[(String, Vec<ProfileSample>)]) -> Table {
    let row = |name: &str, sample: &ProfileSample| {
        let ProfileSample { distance_px, u, v, value } = *sample;
        std::iter::once(name.into()).chain([distance_px, u, v, value].map(|x| Cell::single(x, 4))).collect()
    };
    let rows = profiles.iter().flat_map(|(name, samples)| samples.iter().map(move |sample| row(name, sample)));
    Table::new("Profiles", PROFILE_COLUMNS, rows.collect())
}
