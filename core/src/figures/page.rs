//! The page that shows all figures of a folder.

use super::record::{KeptFigure, read_record};
use super::{FigureSize, FiguresError, PaperFigure};
use crate::export::{Escaped, OutputRules, write_whole};
use std::fmt::Write as _;
use std::io::Write;
use std::path::{Path, PathBuf};

/// Writes `index.html` into `folder`: every finished figure there, with its caption, notes and numbers.
pub(super) fn write_page(folder: &Path, size: FigureSize) -> Result<PathBuf, FiguresError> {
    let records: Vec<KeptFigure> =
        PaperFigure::ALL.into_iter().filter_map(|f| Some(read_record(folder, f)?.of)).collect();
    let path = folder.join("index.html");
    OutputRules::default().check_own(&path)?;
    write_whole(&path, |out| out.write_all(page(&records, size).as_bytes()))?;
    Ok(path)
}

fn page(records: &[KeptFigure], size: FigureSize) -> String {
    let mut html = String::from(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<title>The figures of the BuFF paper, remade by Burstscope</title>\n\
         <style>body{font-family:Helvetica,Arial,sans-serif;max-width:1100px;margin:2em auto;padding:0 1em;color:#24292f;background:#fff;line-height:1.45}\n\
         img{max-width:100%;border:1px solid #e4e8ec}h2{margin-top:2em}.note{color:#57606a}</style>\n</head>\n<body>\n\
         <h1>The figures of the BuFF paper, remade</h1>\n",
    );
    let about = match size {
        FigureSize::Full => "The material is our own: charts, scenes and trajectories whose truth is known.",
        FigureSize::Quick => {
            "Made with --quick: the material is so small that these pictures show what there is, not how good it is."
        }
    };
    // Writing into a string cannot fail.
    let _ = writeln!(
        html,
        "<p>A. Ravendran, M. Bryson, D. G. Dansereau: “BuFF: Burst Feature Finder for Light-Constrained 3D Reconstruction”, \
         arXiv 2209.09470. {about} Burstscope {}.</p>",
        env!("CARGO_PKG_VERSION")
    );
    for record in records {
        let (name, title) = (record.figure.name(), Escaped(record.figure.title()));
        let _ = writeln!(html, "<h2 id=\"{name}\">{title}</h2>\n<p>{}</p>", Escaped(record.figure.caption()));
        let _ = writeln!(html, "<p><a href=\"{name}.svg\"><img src=\"{name}.svg\" alt=\"{title}\"></a></p>");
        for note in &record.notes {
            let _ = writeln!(html, "<p class=\"note\">{}</p>", Escaped(note));
        }
        let _ = writeln!(
            html,
            "<p class=\"note\"><a href=\"{name}.csv\">{name}.csv</a>: the numbers. Made in {:.0} s.</p>",
            record.seconds.max(1.0)
        );
    }
    html.push_str("</body>\n</html>\n");
    html
}
