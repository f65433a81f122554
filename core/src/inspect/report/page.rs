//! A burst on one page, as Markdown, or drawn on a sheet under a picture of the burst: what it is, its slopes, noise,
//! tests, false features and the places asked about, in the words of the other answers.

use super::{decoy_cells, doubts, reasons, shown_bars, slope_cells, test_cells, written};
use crate::burst::{Burst, Info};
use crate::detector::Test;
use crate::detector::advice::grouped;
use crate::detector::test::NOT_SEARCHED;
use crate::error::Result;
use crate::export::sheet::{Anchor, Colour, Face, INK, RED};
use crate::export::{Drawing, FigureRect, FigureShape, FigureStroke, FigureUnit};
use crate::inspect::ProbeCache;
use crate::inspect::place::{Outcome, Probe, ProbeOptions, probe};
use crate::inspect::result::{DecoyReport, DecoyStudy, decoys};
use crate::inspect::slopes::{Spectrum, spectrum};
use crate::inspect::words::{capitalised, counted, number, sentence};
use crate::monitor::Monitor;
use crate::plane::Plane;
use crate::plane::display::{Display, to_rgba8};
use std::fmt::Write;
use std::sync::Arc;

/// Answers about a burst and its search.
#[derive(Debug)]
pub struct BurstPage<'a> {
    /// The search.
    pub cache: &'a ProbeCache,
    /// The burst, not merged.
    pub burst: &'a Burst,
    /// Description by the files.
    pub info: Info,
    /// Slopes and their judgement.
    pub spectrum: Spectrum,
    /// False rates, or the reason why there are none.
    pub decoys: Result<DecoyReport, String>,
    /// Names and fates of the places asked about.
    pub places: Vec<(String, Probe)>,
}

/// Share of the work that copies of the burst take.
const DECOYS: f32 = 0.7;
/// Largest number of slopes in the table.
const SLOPES: usize = 12;

impl<'a> BurstPage<'a> {
    /// Asks all questions of a search of `burst`, which `info` describes: `places` have a name each, and (u, v) in
    /// input pixels.
    ///
    /// # Errors
    /// A place outside the picture, and cancellation. A burst without decoys of `study` has a reason instead.
    pub fn of(
        (cache, burst, info): (&'a ProbeCache, &'a Burst, Info),
        places: &[(String, [f32; 2])],
        study: &DecoyStudy,
        monitor: &Monitor,
    ) -> Result<Self> {
        let decoys = match decoys(&cache.trail, study, &monitor.part(0.0, DECOYS)) {
            Err(error) if error.is_cancelled() => return Err(error),
            report => report.map_err(|error| error.to_string()),
        };
        let rest = monitor.part(DECOYS, 1.0 - DECOYS);
        let fate = |at: [f32; 2]| probe(cache, at, &ProbeOptions::default(), &rest);
        let places = places.iter().map(|(name, at)| Ok((name.clone(), fate(*at)?)));
        Ok(Self {
            cache,
            burst,
            spectrum: spectrum(cache, &rest)?,
            decoys,
            places: places.collect::<Result<_>>()?,
            info,
        })
    }

    /// The page as Markdown, with a comment as the first line, so that the mark is a comment too.
    pub fn markdown(&self) -> String {
        page_head()
            + &written(|out| {
                self.write_input(out)?;
                self.write_slopes(out)?;
                self.write_features(out)?;
                self.places.iter().try_for_each(|(name, place)| write_place(out, name, place))
            })
    }

    fn write_input(&self, out: &mut String) -> std::fmt::Result {
        let described = self.info.text();
        let mut lines = described.lines();
        writeln!(out, "# {}\n", escaped(lines.next().unwrap_or_default()))?;
        for (subject, words) in lines.filter_map(|line| line.trim().split_once(' ')) {
            writeln!(out, "- {subject}: {}", escaped(words.trim()))?;
        }
        for note in self.burst.notes().iter().filter(|note| !self.info.taken.contains(&note.text)) {
            writeln!(out, "- note: {}", escaped(&note.for_command()))?;
        }
        Ok(())
    }

    fn write_slopes(&self, out: &mut String) -> std::fmt::Result {
        let Spectrum { finding, judgement, advice, .. } = &self.spectrum;
        writeln!(out, "\n## Slopes\n\nThe frames: {}.\n", escaped(&finding.summary_beside_judgement()))?;
        if let Some(fits) = judgement.as_ref().filter(|judgement| judgement.advice.is_none()) {
            writeln!(out, "{}\n", escaped(&sentence(&fits.sentence)))?;
        }
        write_items(out, advice.iter().map(|one| (one.sentence.clone(), one.options())))?;
        let (bars, hidden) = shown_bars(&self.spectrum, SLOPES);
        let heads = ["slope, px/frame", "features", "evidence", "seen by all frames"];
        write_table(out, heads, bars.into_iter().map(slope_cells))?;
        if hidden > 0 { writeln!(out, "\nAnd {} with less.", counted(hidden, "more slope")) } else { Ok(()) }
    }

    fn write_features(&self, out: &mut String) -> std::fmt::Result {
        let detection = self.cache.detection();
        let (noise, gate) = (detection.frame_noise, detection.noise_gate_factor);
        writeln!(out, "\n## Noise\n\n{noise:.5} of full scale in a frame; noise gate {gate:.2} σ.\n")?;
        write_items(out, detection.noise.warnings.iter().map(|warning| (warning.text.clone(), String::new())))?;
        let found = counted(detection.features.len(), "feature");
        writeln!(out, "\n## Features\n")?;
        match &self.decoys {
            Err(why) => writeln!(out, "{found}. How many are false is not known: {}.", escaped(why))?,
            Ok(report) => {
                let all = report.rates.first().map_or(0.0, |all| all.mean_in_copies());
                let words = "are found on average with the frames in other orders: at most about as many are false";
                writeln!(out, "{found}; {all:.1} {words}. {}.\n", capitalised(&report.sentence()))?;
                write_items(out, report.doubt().map(|doubt| (sentence(&doubt), String::new())))?;
                let heads = ["SNR from", "found here", "in a copy", "there for each here"];
                write_table(out, heads, report.rates.iter().map(decoy_cells))?;
            }
        }
        let tally = &detection.tally;
        let (samples, kept) = (grouped(tally.samples), counted(tally.kept as usize, "keypoint"));
        writeln!(
            out,
            "\n## Tests\n\n{kept} of {samples} samples; each other one counts at the first test that it failed.\n"
        )?;
        let rejected = Test::ALL.into_iter().map(|test| (test.reason(), tally.rejected_by(test)));
        let rejected = rejected.chain([(NOT_SEARCHED, tally.not_searched)]).filter(|(_, count)| *count > 0);
        write_table(out, ["samples", "rejected as"], rejected.map(|(why, count)| [grouped(count), why.to_owned()]))
    }

    /// The page as a drawing, at least as long as A4, with `picture` on top, circles around the features, and names
    /// or numbers at the places asked about; `caption` says what the picture is.
    pub fn drawing(&self, picture: &Plane, caption: &str) -> Drawing {
        let mut sheet = Sheet { shapes: Vec::new(), y: MARGIN };
        sheet.picture(picture, self);
        sheet.line(&format!("{caption}; {}", counted(self.cache.detection().features.len(), "feature")));
        let text = self.markdown();
        // The first line is the mark's.
        let lines: Vec<&str> = text.lines().skip(1).collect();
        for lines in lines.chunk_by(|a, b| a.starts_with('|') && b.starts_with('|')) {
            if lines[0].starts_with('|') { sheet.table(lines) } else { sheet.line(lines[0]) }
        }
        let size = [WIDTH, (sheet.y + MARGIN).max(HEIGHT)];
        let paper = FigureShape::Rect { rect: FigureRect { min: [0.0; 2], size }, style: [255; 3].into() };
        sheet.shapes.insert(0, paper);
        Drawing { size, unit: FigureUnit::Point, shapes: sheet.shapes, title: format!("Report of {}", self.info.name) }
    }
}

fn write_place(out: &mut String, name: &str, probe: &Probe) -> std::fmt::Result {
    let [u, v] = probe.pos_image.map(|x| number(x, 1));
    writeln!(out, "\n## {} at ({u}, {v})\n\n{}\n", escaped(name), escaped(&probe.summary))?;
    write_items(out, reasons(probe).into_iter().chain(doubts(probe)))?;
    let Some(fate) = probe.subject_fate() else { return Ok(()) };
    write_items(out, [(sentence(&fate.verdict), String::new())])?;
    write_items(out, fate.remedy.iter().map(|remedy| (remedy.sentence.clone(), remedy.change.option())))?;
    writeln!(out)?;
    let asked = fate.tests.iter().filter(|report| report.outcome != Outcome::NotAsked);
    let rows = asked.map(|report| test_cells(report, Some(report.test) == fate.first_failed));
    write_table(out, ["test", "value", "limit", "margin", "outcome"], rows)
}

/// Sentences, each with the option that mends the fault, or an empty text.
fn write_items(out: &mut String, items: impl IntoIterator<Item = (String, String)>) -> std::fmt::Result {
    items.into_iter().try_for_each(|(words, option)| {
        let told = if option.is_empty() { words } else { format!("{}: try {option}", words.trim_end_matches('.')) };
        writeln!(out, "- {}", escaped(&told))
    })
}

/// First line of a page, a comment.
pub(super) fn page_head() -> String {
    format!("<!-- Burstscope {} -->\n\n", env!("CARGO_PKG_VERSION"))
}

pub(super) fn write_table<'a, R: IntoIterator<Item = String>>(
    out: &mut String,
    heads: impl IntoIterator<Item = &'a str>,
    mut rows: impl Iterator<Item = R>,
) -> std::fmt::Result {
    let heads: Vec<String> = heads.into_iter().map(escaped).collect();
    writeln!(out, "\n| {} |\n|{}", heads.join(" | "), " --- |".repeat(heads.len()))?;
    rows.try_for_each(|cells| {
        let cells: Vec<String> = cells.into_iter().map(|cell| escaped(&cell)).collect();
        writeln!(out, "| {} |", cells.join(" | "))
    })
}

/// Marks that Markdown would read: names of files may hold any.
const MARKS: &str = "\\`*_[]<|#&~";

pub(super) fn escaped(text: &str) -> String {
    let marked = |letter: char| [MARKS.contains(letter).then_some('\\'), Some(letter)];
    text.replace(char::is_control, " ").chars().flat_map(marked).flatten().collect()
}

/// A4, points.
const WIDTH: f32 = 595.0;
const HEIGHT: f32 = 842.0;
const MARGIN: f32 = 42.0;
const PICTURE_HEIGHT: f32 = 260.0;
const SIZE: f32 = 8.0;
/// Width of a letter over its height, estimated.
const LETTER: f32 = 0.53;
/// Okabe and Ito's yellow, seen on dark pictures and on bright ones.
const RING: [u8; 3] = [240, 228, 66];

struct Sheet {
    shapes: Vec<FigureShape>,
    /// Lower end of what is drawn.
    y: f32,
}

impl Sheet {
    fn text(&mut self, x: f32, size: f32, text: &str) {
        self.shapes.push(words_at([x, self.y + size], size, INK, text.to_owned()));
    }

    /// A line of Markdown, broken where it is too long.
    fn line(&mut self, line: &str) {
        let (size, words) = match line.split_once(' ') {
            Some(("#", words)) => (1.75 * SIZE, words),
            Some(("##", words)) => (1.3 * SIZE, words),
            _ => (SIZE, line),
        };
        let most = ((WIDTH - 2.0 * MARGIN) / (LETTER * size)) as usize;
        let mut part = String::new();
        for word in shown(words).split_whitespace() {
            if part.chars().count() + word.chars().count() >= most && !part.is_empty() {
                self.text(MARGIN, size, &std::mem::take(&mut part));
                self.y += 1.3 * size;
            }
            part = format!("{part} {word}").trim_start().to_owned();
        }
        self.text(MARGIN, size, &part);
        self.y += if part.is_empty() { 0.5 } else { 1.3 } * size;
    }

    /// Rows of a table of Markdown: the heads, a rule, and the others.
    fn table(&mut self, lines: &[&str]) {
        let cells = |line: &str| line.trim_matches(['|', ' ']).split(" | ").map(shown).collect::<Vec<String>>();
        let rows: Vec<Vec<String>> =
            lines.iter().filter(|line| !line.starts_with("| ---")).map(|line| cells(line)).collect();
        let columns = rows.iter().map(Vec::len).max().unwrap_or(0);
        let letters = |column: usize| rows.iter().filter_map(|row| Some(row.get(column)?.chars().count())).max();
        let widths: Vec<usize> = (0..columns).map(|column| letters(column).unwrap_or(0) + 3).collect();
        for row in rows {
            let mut before = 2;
            for (cell, width) in row.iter().zip(&widths) {
                self.text(MARGIN + before as f32 * LETTER * SIZE, SIZE, cell);
                before += width;
            }
            self.y += 1.3 * SIZE;
        }
    }

    fn picture(&mut self, picture: &Plane, page: &BurstPage<'_>) {
        let (width, height) = picture.size();
        let scale = ((WIDTH - 2.0 * MARGIN) / width as f32).min(PICTURE_HEIGHT / height as f32);
        let rect = FigureRect { min: [MARGIN, self.y], size: [width as f32 * scale, height as f32 * scale] };
        // Dark frames would be black on paper.
        let rgba = Arc::new(to_rgba8(picture, &Display::stretched(picture)).into_raw());
        self.shapes.push(FigureShape::Picture { rect, size: (width, height), rgba });
        let at = |[u, v]: [f32; 2]| [rect.min[0] + (u + 0.5) * scale, rect.min[1] + (v + 0.5) * scale];
        let stroke = FigureStroke { opacity: 0.9, ..FigureStroke::new(RING, 0.6) };
        let rings = page.cache.detection().features.iter().map(|feature| FigureShape::Circle {
            centre: at([feature.u, feature.v]),
            radius: scale * feature.circle_radius_px(),
            style: if feature.at_slope_limit { stroke.dashed([2.4; 2]) } else { stroke }.into(),
        });
        // Of a numbered place the number is enough.
        let short = |name: &str| name.strip_prefix("Place ").unwrap_or(name).to_owned();
        let names = page.places.iter().map(|(name, place)| words_at(at(place.pos_image), 1.3 * SIZE, RED, short(name)));
        let shapes = rings.chain(names).collect();
        self.shapes.push(FigureShape::Clipped { rect, round: false, shapes });
        self.y += rect.size[1] + 0.5 * SIZE;
    }
}

fn words_at(at: [f32; 2], size: f32, color: Colour, text: String) -> FigureShape {
    FigureShape::Text { at, anchor: Anchor::Start, size, face: Face::Plain, color, upwards: false, text }
}

/// Text of Markdown as it is read.
fn shown(text: &str) -> String {
    let mut letters = text.chars();
    let letter = |letters: &mut std::str::Chars<'_>| {
        letters.next().and_then(|c| if c == '\\' { letters.next() } else { Some(c) })
    };
    std::iter::from_fn(|| letter(&mut letters)).collect()
}
