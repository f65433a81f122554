//! Options of a command's output, and of the threads and memory that it may use.

use crate::detector::memory;
use clap::Args;

/// What is printed, and with how many threads the work is done.
#[derive(Debug, Clone, Copy, Args)]
#[command(next_help_heading = "Output")]
pub struct OutputArgs {
    /// Print one JSON document on the standard output instead of the summary.
    #[arg(long)]
    pub json: bool,
    /// Print no summary and show no progress; errors are still told.
    #[arg(long, short)]
    pub quiet: bool,
    /// Number of threads; results are the same for any number [default: one for each core].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
    /// Memory that a search may take beside its burst, such as 8G, 500M or 50% of the machine's; one that needs more is
    /// done in groups of slopes, with the same result, or refused before it starts where that is not enough
    /// [default: 75%].
    #[arg(long = memory::OPTION, value_name = "SIZE", value_parser = parse_memory)]
    pub memory: Option<u64>,
}

/// What may be written over.
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

    #[test]
    fn sizes_are_read_and_nonsense_is_refused() {
        assert_eq!((parse_memory("1.5G"), parse_memory("500 MB")), (Ok(1_500_000_000), Ok(500_000_000)));
        for bad in ["", "8", "G", "-1G", "120%", "0M", "many"] {
            assert!(parse_memory(bad).is_err(), "{bad}");
        }
    }
}
