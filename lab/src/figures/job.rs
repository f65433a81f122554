//! Making figures one after the other into a folder, and the page that shows all figures there.

use super::record::{FigureRecord, KeptFigure, Pieces, begin, check_folder, read_record};
use super::{FigureSize, Made, PaperFigure};
use burstscope_core::export::{Escaped, MadeFrom, OutputRules, Record, Records, write_text, write_whole};
use burstscope_core::files::mark::{Checksum, OutputKind, sealed};
use burstscope_core::{error::Result, files::lock::FolderLock, monitor::Monitor};
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::{io::Write, time::Instant};

/// Figures to make, and their folder.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FiguresJob {
    /// Folder of the figures; created if missing.
    pub out: PathBuf,
    /// Figures to make; empty for all.
    pub only: Vec<PaperFigure>,
    /// Size of the material.
    pub size: FigureSize,
    /// COLMAP's program, for some figures; without COLMAP the notes name the missing columns.
    pub colmap: Option<PathBuf>,
}

/// Event of a job.
#[derive(Debug)]
pub enum FiguresEvent<'a> {
    /// A figure was started.
    Begin {
        /// The figure.
        figure: PaperFigure,
        /// Index among the figures that are made, from 0.
        index: usize,
        /// Number of figures that are made.
        count: usize,
    },
    /// A figure was finished, now or by an earlier run.
    Done(&'a FigureReport),
}

/// A finished figure.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FigureReport {
    /// The figure.
    pub figure: PaperFigure,
    /// Files of picture and numbers.
    pub files: Vec<PathBuf>,
    /// Notes for the reader, such as missing columns; sentences.
    pub notes: Vec<String>,
    /// Whether an earlier run had made it.
    pub resumed: bool,
    /// Seconds that the figure took to make, in this or an earlier run.
    pub seconds: f64,
}

/// Result of a job.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[allow(missing_docs)] // where a name says it
pub struct FiguresReport {
    pub page: PathBuf,
    pub size: FigureSize,
    pub figures: Vec<FigureReport>,
}

/// COLMAP's program in the system's search path; `None` where it is not installed.
pub fn find_colmap() -> Option<PathBuf> {
    let names: &[&str] = if cfg!(windows) { &["colmap.exe", "COLMAP.bat"] } else { &["colmap"] };
    let folders: Vec<PathBuf> = std::env::split_paths(&std::env::var_os("PATH")?).collect();
    folders.iter().flat_map(|folder| names.iter().map(|name| folder.join(name))).find(|path| path.is_file())
}

impl FiguresJob {
    fn wanted(&self) -> Vec<PaperFigure> {
        let is_wanted = |figure: &PaperFigure| self.only.is_empty() || self.only.contains(figure);
        PaperFigure::ALL.into_iter().filter(is_wanted).collect()
    }

    /// Makes the figures that are not finished yet, and the page. `on` is called with every event.
    ///
    /// # Errors
    /// A study, a file or COLMAP fails, or cancellation. Files are written whole or not at all; finished figures stay.
    pub fn run(&self, on: &mut dyn FnMut(FiguresEvent<'_>), monitor: &Monitor) -> Result<FiguresReport> {
        check_folder(&self.out)?;
        // Two runs in one folder would mix their records: the lock comes before anything is written.
        let lock = FolderLock::take(&self.out)?;
        begin(&self.out)?;
        let pieces = Pieces::of(&self.out);
        let wanted = self.wanted();
        // Figures differ much in cost, so that progress counts expected seconds instead of figures.
        let total: f32 = wanted.iter().map(|figure| figure.cost_secs(self.size)).sum();
        let mut figures = Vec::with_capacity(wanted.len());
        let mut done = 0.0;
        for (index, &figure) in wanted.iter().enumerate() {
            monitor.check()?;
            on(FiguresEvent::Begin { figure, index, count: wanted.len() });
            let cost = figure.cost_secs(self.size);
            let report = self.one(figure, &pieces, &lock, &monitor.part(done / total, cost / total))?;
            done += cost;
            on(FiguresEvent::Done(&report));
            figures.push(report);
        }
        lock.check()?;
        Ok(FiguresReport { page: write_page(&self.out, self.size)?, size: self.size, figures })
    }

    /// One figure: the finished one if it is up to date, otherwise made and written.
    fn one(&self, figure: PaperFigure, pieces: &Pieces, lock: &FolderLock, monitor: &Monitor) -> Result<FigureReport> {
        let maker = figure.maker(self.size, self.colmap.as_deref());
        // The `Debug` text holds all parameters: a figure with any other value is made again.
        let made_from = MadeFrom::new(format!("{maker:?}"));
        let kept = read_record(&self.out, figure).filter(|record| record.made_from == made_from);
        let resumed = kept.is_some();
        let record = match kept {
            Some(record) => record,
            None => {
                let started = Instant::now();
                let made = maker.make(pieces, monitor)?;
                monitor.check()?;
                lock.check()?;
                self.write(figure, made, made_from, started.elapsed().as_secs_f64())?
            }
        };
        let KeptFigure { files, notes, seconds, .. } = record.of;
        let files = files.iter().map(|(name, _)| self.out.join(name)).collect();
        Ok(FigureReport { figure, files, notes, resumed, seconds })
    }

    fn write(&self, figure: PaperFigure, made: Made, made_from: MadeFrom, seconds: f64) -> Result<FigureRecord> {
        let records = Records::of(&self.out);
        let earlier = records.read::<KeptFigure>(figure.name()).map(|record| record.of);
        let mut earlier = earlier.map_or_else(Vec::new, |of| [of.files, of.earlier].concat());
        earlier.retain(|(name, content)| content.is_of(&self.out.join(name)));
        let name = |ending: &str| format!("{}.{ending}", figure.name());
        let texts = [(name("svg"), sealed(made.svg, OutputKind::Drawing)), (name("csv"), made.csv)];
        // A file that no run wrote, or that was changed since, is the user's and is not overwritten.
        for (name, _) in &texts {
            let known = earlier.iter().filter(|(of, _)| of == name).map(|(_, content)| *content).collect::<Vec<_>>();
            OutputRules::default().check_own(&self.out.join(name), &known)?;
        }
        let files = texts.iter().map(|(name, text)| (name.clone(), Checksum::of(text.as_bytes()))).collect();
        // The record comes first: a run that dies in between knows its own files by their checksums.
        let record = Record { made_from, of: KeptFigure { figure, files, earlier, notes: made.notes, seconds } };
        records.write(figure.name(), &record)?;
        for (name, text) in texts {
            write_whole(&self.out.join(name), |out| out.write_all(text.as_bytes()))?;
        }
        Ok(record)
    }
}

/// Writes `index.html` into `folder`: every finished figure there, with its caption, notes and numbers.
pub(super) fn write_page(folder: &Path, size: FigureSize) -> Result<PathBuf> {
    let records: Vec<KeptFigure> =
        PaperFigure::ALL.into_iter().filter_map(|f| Some(read_record(folder, f)?.of)).collect();
    let path = folder.join("index.html");
    OutputRules::default().check_own(&path, &[])?;
    write_text(&path, OutputKind::Page, page(&records, size))?;
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
    html += &format!(
        "<p>A. Ravendran, M. Bryson, D. G. Dansereau: “BuFF: Burst Feature Finder for Light-Constrained 3D Reconstruction”, \
         arXiv 2209.09470. {about} Burstscope {}.</p>\n",
        env!("CARGO_PKG_VERSION")
    );
    for record in records {
        let (name, title) = (record.figure.name(), Escaped(record.figure.title()));
        html += &format!("<h2 id=\"{name}\">{title}</h2>\n<p>{}</p>\n", Escaped(record.figure.caption()));
        html += &format!("<p><a href=\"{name}.svg\"><img src=\"{name}.svg\" alt=\"{title}\"></a></p>\n");
        html.extend(record.notes.iter().map(|note| format!("<p class=\"note\">{}</p>\n", Escaped(note))));
        html += &format!(
            "<p class=\"note\"><a href=\"{name}.csv\">{name}.csv</a>: the numbers. Made in {:.0} s.</p>\n",
            record.seconds.max(1.0)
        );
    }
    html.push_str("</body>\n</html>\n");
    html
}
