//! The mark by which Burstscope recognises its own files, so that it replaces these and no others without being told
//! to.
//!
//! Pictures name the program in their format's field for it (`Software`), SVG figures in a comment, parameter and
//! session files in their first line. Tables and NumPy files have no place for a name: there the header is the mark.
//! Only the first few kilobytes of a file are read; they decide, whatever its name is.

use super::csv::{COLUMNS, MATCH_COLUMNS, PROFILE_COLUMNS};
use crate::files::WRITTEN_BY;
use std::fs::File;
use std::io::Read;
use std::path::Path;

/// The program's name and version, for the `Software` field of pictures.
pub(super) const SOFTWARE: &str = concat!("Burstscope ", env!("CARGO_PKG_VERSION"));
/// Comment in SVG figures.
pub(super) const SVG_COMMENT: &str = concat!("<!-- Written by Burstscope ", env!("CARGO_PKG_VERSION"), " -->");
/// Header of tables of curves.
pub const CURVE_COLUMNS: &str = "set,plot,curve,x,y,low,high";

/// Header of tables of planted things.
pub const PLANTED_COLUMNS: &str = "seed,id,varied,u,v,radius,slope_u,slope_v,sign,snr,amplitude,frames,expected_snr_d,found,found_slope_u,found_slope_v,found_snr,failed,why";

/// Beginning of every version's [`SOFTWARE`].
const ANY_SOFTWARE: &[u8] = b"Burstscope ";
/// Beginning of every version's [`SVG_COMMENT`].
const ANY_SVG_COMMENT: &[u8] = b"<!-- Written by Burstscope ";
/// Number of bytes that are read of a file.
const HEAD: u64 = 4096;

/// Whether this program, in any version, wrote the file at `path`, judging by its start; false for a file that cannot
/// be read.
pub fn is_ours(path: &Path) -> bool {
    let mut head = Vec::new();
    let read = File::open(path).and_then(|file| file.take(HEAD).read_to_end(&mut head));
    read.is_ok() && is_our_start(&head)
}

fn is_our_start(head: &[u8]) -> bool {
    let holds = |mark: &[u8]| head.windows(mark.len()).any(|window| window == mark);
    let line = head.split(|byte| *byte == b'\n').next().unwrap_or_default();
    let line = line.strip_suffix(b"\r").unwrap_or(line);
    let starts = |start: &[u8]| head.starts_with(start);
    if starts(b"\x89PNG\r\n\x1a\n") {
        holds(&[b"tEXtSoftware\0", ANY_SOFTWARE].concat())
    } else if [b"II*\0", b"MM\0*", b"II+\0", b"MM\0+"].iter().any(|start| starts(*start)) {
        holds(ANY_SOFTWARE)
    } else if starts(b"PK\x03\x04") {
        // A local header of a ZIP archive has the file's name at byte 30.
        head.get(30..).is_some_and(|name| name.starts_with(b"features.npy") || name.starts_with(b"case.toml"))
    } else if starts(b"GIF8") {
        holds(ANY_SOFTWARE)
    } else if starts(b"<") {
        holds(ANY_SVG_COMMENT)
    } else {
        let (features, matches) = (COLUMNS.join(","), MATCH_COLUMNS.join(","));
        let headers = [features.as_str(), &matches, PROFILE_COLUMNS, CURVE_COLUMNS, PLANTED_COLUMNS];
        let count = line.strip_suffix(b" 128").unwrap_or_default();
        headers.iter().any(|header| line == header.as_bytes())
            || line.starts_with(WRITTEN_BY.as_bytes())
            || (!count.is_empty() && count.iter().all(u8::is_ascii_digit))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::export::{
        Drawing, Picture, sheet, write_colmap, write_csv, write_drawing_svg, write_matches_csv, write_npz, write_png,
        write_profiles_csv, write_tiff,
    };
    use crate::plane::Plane;

    #[test]
    fn every_file_that_is_written_is_known_again() {
        let home = tempfile::tempdir().expect("a folder");
        let at = |name: &str| home.path().join(name);
        write_png(&at("a.png"), Picture::rgb(2, 1, &[9; 6])).expect("written");
        write_tiff(&at("a.tiff"), &Plane::from_fn(40, 30, |u, v| (u * v) as f32)).expect("written");
        let drawing = Drawing { title: "a".into(), size: [10.0, 10.0], shapes: Vec::new() };
        write_drawing_svg(&at("a.svg"), &drawing).expect("written");
        std::fs::write(at("b.svg"), sheet::Sheet::new(80.0, "b").finish(40.0)).expect("written");
        let parts = vec![sheet::Sheet::new(80.0, "b").finish(40.0); 2];
        std::fs::write(at("c.svg"), sheet::stacked("both", &parts)).expect("written");
        write_csv(&at("a.csv"), &[]).expect("written");
        write_colmap(&at("a.txt"), &[], &[]).expect("written");
        write_npz(&at("a.npz"), &[], &[]).expect("written");
        write_matches_csv(&at("m.csv"), &[]).expect("written");
        write_profiles_csv(&at("p.csv"), &[]).expect("written");
        std::fs::write(at("p.toml"), crate::files::written_by() + "levels = 4\n").expect("written");
        std::fs::write(at("c.csv"), format!("{CURVE_COLUMNS}\n")).expect("written");
        let mut known = 0;
        for entry in std::fs::read_dir(home.path()).expect("a folder") {
            let path = entry.expect("an entry").path();
            assert!(is_ours(&path), "{}", path.display());
            known += 1;
        }
        assert_eq!(known, 12);
    }

    #[test]
    fn what_others_wrote_is_not() {
        let home = tempfile::tempdir().expect("a folder");
        let at = |name: &str| home.path().join(name);
        let gray = image::GrayImage::from_pixel(8, 8, image::Luma([9]));
        for name in ["a.png", "a.tiff", "a.jpg"] {
            gray.save(at(name)).expect("written");
            assert!(!is_ours(&at(name)), "{name}");
        }
        for text in [
            "",
            "\n",
            " 128\n",
            "12 a 128",
            "u,v\n1,2\n",
            "u,v,sigma\n",
            "about Burstscope 0.1.0: # Written by Burstscope 0.1.0\n",
            "PK\u{3}\u{4}",
            "<svg><!-- made with Inkscape --></svg>",
            "II*\0",
        ] {
            std::fs::write(at("x"), text).expect("written");
            assert!(!is_ours(&at("x")), "{text:?}");
        }
        assert!(!is_ours(home.path()) && !is_ours(&at("none")));
    }
}
