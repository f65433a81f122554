//! Arguments that several commands share, and those of the plain commands: names, kinds and help texts.

use super::SearchArgs;
use crate::burst::{FrameRange, OpenOptions};
use crate::detector::params::doc;
use crate::detector::{Combine, Slope, memory};
use crate::export::ExportFormat;
use crate::inspect::place::Verdict;
use clap::Args;
use std::path::PathBuf;
use std::str::FromStr;

pub(super) const INPUT_HELP: &str = "Folder of frames, folder of such folders, image files, raw files (DNG), multi-page TIFF, .npy stack [N,H,W], .npz, FITS, SER, Y4M, film (with ffmpeg), ROS bag or MCAP, file without header (--raw), 'demo', 'demo-later', or one of the examples 'demo-depths', 'demo-views', 'demo-crossing', 'demo-street', 'demo-street-later', 'demo-aliasing', 'demo-low-contrast', 'demo-tripod', 'demo-hot-pixels'";

/// How long sequences of frames are cut into bursts.
#[derive(Debug, Clone, Copy, Default, Args)]
#[command(next_help_heading = "Sequence")]
pub struct SequenceArgs {
    /// Take each input for a long sequence and cut it into bursts of N frames, each named after its middle frame.
    #[arg(long, value_name = "N")]
    pub burst_length: Option<usize>,
    /// Frames from the start of a burst to the start of the next [default: as many as a burst has].
    #[arg(long, value_name = "K", requires = "burst_length")]
    pub burst_step: Option<usize>,
}

/// Find the features of one or many bursts.
///
/// A folder whose subfolders hold frames is a dataset: each subfolder is a burst. Image files given together are the
/// frames of one burst, in the order given. A long sequence is cut into bursts by --burst-length. A burst that fails is
/// reported; the others go on.
#[derive(Debug, Args)]
#[command(after_long_help = DETECT_HELP)]
pub struct DetectArgs {
    /// Folder for the features, made if it is missing; files are named after their burst.
    #[arg(long, short, value_name = "DIR")]
    pub out: PathBuf,
    /// Formats, separated by commas: csv, colmap, npz.
    #[arg(long, value_name = "FORMAT", value_delimiter = ',', default_value = "csv")]
    pub format: Vec<ExportFormat>,
    /// Judge each feature and keep those with these verdicts, separated by commas: real, ghost, alias, duplicate,
    /// unclear, or all. Tables then have the verdict and the coherence, 0 to 1, as last columns.
    #[arg(long, value_name = "VERDICT", value_delimiter = ',', value_parser = parse_verdict)]
    pub verdict: Vec<VerdictChoice>,
    #[command(flatten)]
    pub sequence: SequenceArgs,
    #[command(flatten)]
    pub bursts: BurstsArgs,
}

/// A verdict that features may have to be kept; `None` for any.
type VerdictChoice = Option<Verdict>;

fn parse_verdict(text: &str) -> Result<VerdictChoice, String> {
    let named = Verdict::ALL.into_iter().find(|verdict| verdict.word() == text);
    match (named, text) {
        (None, "all") => Ok(None),
        (Some(verdict), _) => Ok(Some(verdict)),
        _ => Err(format!("'{text}' is no verdict; give real, ghost, alias, duplicate, unclear or all")),
    }
}

const DETECT_HELP: &str = "\
Files, for each burst NAME:
  csv     NAME.csv  u,v,sigma,orientation,slope_u,slope_v,response,snr,octave,level,at_slope_limit,slope_sigma,field_u,field_v,field_sigma,layer,motion; strongest first;
                    empty: no field or layer there; motion: surroundings, own, edge, ghost or unknown
  colmap  NAME.txt  'N 128', then x y scale orientation d1 … d128; first pixel centre at 0.5, UBC order
  npz     NAME.npz  features [N,17] f32 in the csv's columns (motion: 0 unknown, 1 surroundings, 2 own, 3 edge, 4 ghost), descriptors [N,128] u8
  With --verdict: csv also verdict,coherence; npz also verdict [N] u8 (0 real, 1 ghost, 2 alias, 3 duplicate, 4 unclear), coherence [N] f32

JSON (--json):
  {\"version\", \"commit\", \"detector_revision\", \"command\": \"detect\", \"params\": {as in the parameter file},
   \"bursts\": [{\"name\", \"inputs\": [path], \"frames\", \"frames_used\": [first, end], \"width\", \"height\", \"full_scale\", \"encoding\": linear or srgb,
     \"positions\": [frame intervals from the first frame] and \"interval_s\" where --times gives others than even ones,
     \"views\": [[column, row] from the first view] of a light field,
     \"binning\", \"suggested_full_scale\" where 16-bit files look like 10, 12 or 14 bits,
     \"damaged_frames\": [name] where --accept-damaged took some,
     \"taken\": [clause] where times or an order were found or files left a choice, with \"frame_names\": [name] in their order, \"features\",
     \"files\": {format: path}, \"frame_noise\", \"noise_gate_factor\", \"octaves\": [first, end],
     \"noise\": {\"frame_noise\", \"is_local\", \"transfer\": {\"slope\", \"dark\", \"bit\" of pixels that are 0 or it, \"points\": [{\"brightness\", \"variance\", \"squares\"}]}, \"excess\", \"levels\",
       \"frames\": [{\"gain\", \"relative_variance\", \"left_out\"}], \"correlations\", \"pattern\", \"warnings\": [{\"kind\", \"number\", \"text\"}]},
     \"slope_grid\": {\"u\": {\"min\", \"max\", \"count\"}, \"v\", \"direction_deg\"}, \"slopes_found\": {\"grid\", \"verdict\": found, still,
       nothing-seen, not-straight or film, \"confidence\", \"significance\", \"direction_deg\", \"moved_px\", \"deviation_px\",
       \"warnings\": [{\"kind\", \"frames\", \"number\", \"text\"}]} where slopes were found,
     \"slopes_judged\": {\"sentence\", \"fits\", \"advice\" or null},
     \"advice\": {\"message\", \"parameter\", \"value\"} on few features, parameter and value null where nothing helps, or null,
     \"slopes\": [{\"u\", \"v\", \"features\"}], \"tally\": {\"samples\", \"not_searched\" where --search field leaves some out,
       \"kept\", \"rejected\": {test: count}},
     \"times\": {\"open_secs\", \"slopes_secs\", \"noise_secs\", \"search_secs\", \"describe_secs\", \"write_secs\"}}],
   \"failures\": [{\"name\", \"error\"}]}
  Slopes are pixels per frame; frame_noise is the standard deviation of a frame's noise as a fraction of full scale. confidence is the part (0 … 1) of
  what is significant whose slope the grid holds; significance is the power of the strongest window over the standard deviation that frames with nothing in
  common would give it.";

/// Write the motion-stack image at a slope, or its DoG response, as 32-bit float TIFF.
///
/// The image is the mean of the frames shifted by the slope, or what --combine says; with --octave and --level it is
/// the DoG response of that image, on the octave's pixels. Values are fractions of full scale.
#[derive(Debug, Args)]
pub struct StackArgs {
    /// The slope, pixels per frame to the right and down.
    #[arg(long, value_name = "U,V", allow_hyphen_values = true, value_parser = parse_slope,
        required_unless_present_any = ["field", "in_focus"])]
    pub slope: Option<Slope>,
    /// In place of a stack the field of motion: the motion of every place and its uncertainty. As TIFF or FILE.pfm, on
    /// the image's pixels, three samples: motion to the right, down, and its standard deviation along the least certain
    /// direction, pixels per frame. As FILE.npz, on the field's cells: motion, covariance, known, layer, layers,
    /// cell_px.
    #[arg(long, conflicts_with_all = ["slope", "octave", "combine"])]
    pub field: bool,
    /// All in focus: the mean of the frames with each place shifted by its own motion.
    #[arg(long, conflicts_with_all = ["slope", "octave", "combine", "field"])]
    pub in_focus: bool,
    /// Octave of the DoG response.
    #[arg(long, value_name = "O", allow_hyphen_values = true, requires = "level")]
    pub octave: Option<i32>,
    /// Level of the DoG response within its octave.
    #[arg(long, value_name = "S", allow_hyphen_values = true, requires = "octave")]
    pub level: Option<i32>,
    /// How the shifted frames are combined: mean (what the detector uses), median, clipped-mean, max, min, deviation,
    /// or mean-minus-median, which shows what is in some frames only.
    #[arg(long, value_name = "HOW", value_enum, default_value = "mean", conflicts_with = "octave")]
    pub combine: Combine,
    /// The TIFF file to write; with --field also FILE.npz or FILE.pfm. An existing PFM is replaced only with --force.
    #[arg(long, short, value_name = "FILE.tiff")]
    pub out: PathBuf,
    #[command(flatten)]
    pub bursts: BurstsArgs,
}

/// Align the frames of a burst and average them into one image.
///
/// This is the burst-merge baseline. Each tile of the middle frame is looked for in every frame, from coarse to fine,
/// and the tiles are averaged robustly: those that do not fit are left out. Values are fractions of full scale, written
/// as 32-bit float TIFF. 'detect --method merge' finds the features of this image.
#[derive(Debug, Args)]
pub struct MergeArgs {
    #[arg(value_name = "INPUT", required = true, help = INPUT_HELP)]
    pub inputs: Vec<PathBuf>,
    /// The TIFF file to write.
    #[arg(long, short, value_name = "FILE.tiff")]
    pub out: PathBuf,
    #[arg(long = doc::FRAMES.name, value_name = "A..B", help = doc::FRAMES.meaning, value_parser = FrameRange::from_str)]
    pub frames: Option<FrameRange>,
    #[command(flatten)]
    pub calibration: OpenOptions,
    #[command(flatten)]
    pub output: OutputArgs,
    #[command(flatten)]
    pub overwrite: OverwriteArgs,
}

pub(super) fn parse_slope(text: &str) -> Result<Slope, String> {
    let slope = two(text, ',', f32::is_finite).map(|[u, v]| Slope::new(u, v));
    slope.ok_or_else(|| format!("'{text}' is not U,V in pixels per frame, such as -2.1,0"))
}

pub(super) fn two<T: FromStr + Copy>(text: &str, separator: char, valid: fn(T) -> bool) -> Option<[T; 2]> {
    let (first, second) = text.split_once(separator)?;
    let value = |text: &str| text.trim().parse().ok().filter(|value| valid(*value));
    Some([value(first)?, value(second)?])
}

/// Bursts to search, and whether files that exist already are replaced.
#[derive(Debug, Clone, Args)]
pub struct BurstsArgs {
    #[arg(value_name = "INPUT", required = true, help = INPUT_HELP)]
    pub inputs: Vec<PathBuf>,
    #[command(flatten)]
    pub run: BurstSearchArgs,
    #[command(flatten)]
    pub overwrite: OverwriteArgs,
}

/// Options of the search, of opening bursts, and of the output.
#[derive(Debug, Clone, Args)]
pub struct BurstSearchArgs {
    #[command(flatten)]
    pub search: SearchArgs,
    #[command(flatten)]
    pub calibration: OpenOptions,
    #[command(flatten)]
    pub output: OutputArgs,
}

/// Options of the output: JSON, quiet, number of threads.
#[derive(Debug, Clone, Copy, Args)]
#[command(next_help_heading = "Output")]
pub struct OutputArgs {
    /// Print one JSON document on the standard output instead of the summary.
    #[arg(long)]
    pub json: bool,
    /// Print no summary and show no progress; errors are still printed.
    #[arg(long, short)]
    pub quiet: bool,
    /// Number of threads; results are the same for any number [default: one for each core].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
    /// Memory that a search may take beside its burst, such as 8G, 500M or 50% of the machine's. A larger search runs
    /// in groups of slopes, with the same result, or is refused before it starts. A film keeps fewer pictures at a time
    /// [default: 75%].
    #[arg(long = memory::OPTION, value_name = "SIZE", value_parser = parse_memory)]
    pub memory: Option<u64>,
}

/// Options for files that exist already.
#[derive(Debug, Clone, Copy, Default, Args)]
#[command(next_help_heading = "Output")]
pub struct OverwriteArgs {
    /// Replace files that Burstscope did not write, and links, which are not followed. Files that the command opens are
    /// never replaced.
    #[arg(long)]
    pub force: bool,
}

/// Reads a number of bytes: `8G`, `500M` (powers of 1000), or a percentage of the machine's memory.
fn parse_memory(text: &str) -> Result<u64, String> {
    let bad =
        || format!("'{text}' is neither a size such as 8G or 500M nor a part of the machine's memory such as 50%");
    let text = text.trim();
    let (number, unit) = text.split_at(text.find(|c: char| !(c.is_ascii_digit() || c == '.')).unwrap_or(text.len()));
    let number = number.parse::<f64>().ok().filter(|n| n.is_finite() && *n > 0.0).ok_or_else(bad)?;
    let unit = match unit.trim_end_matches(['B', 'b']).trim() {
        "G" | "g" => 1e9,
        "M" | "m" => 1e6,
        "%" if number <= 100.0 => {
            let all = memory::machine_bytes().ok_or("this system does not say how much memory it has; give a size")?;
            all as f64 / 100.0
        }
        _ => return Err(bad()),
    };
    Ok((number * unit) as u64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cli::probe::parse_place;

    #[test]
    fn small_parsers_refuse_nonsense() {
        assert_eq!(parse_slope("-2.1, 0"), Ok(Slope::new(-2.1, 0.0)));
        assert_eq!(parse_place("412, 230.5"), Ok([412.0, 230.5]));
        for bad in ["", "1", "1,", "a,b", "nan,0", "1,2,3"] {
            assert!(parse_slope(bad).is_err() && parse_place(bad).is_err(), "{bad}");
        }
        assert_eq!((parse_memory("1.5G"), parse_memory("500 MB")), (Ok(1_500_000_000), Ok(500_000_000)));
        for bad in ["", "8", "G", "-1G", "120%", "0M", "many"] {
            assert!(parse_memory(bad).is_err(), "{bad}");
        }
    }
}
