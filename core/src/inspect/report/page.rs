//! A burst on one page: what it is, its slopes, noise, tests, false features and the places asked about, in the words
//! of the other answers. It is written as Markdown, or drawn on a sheet under a picture of the burst.

use super::{decoy_cells, doubts, reasons, shown_bars, slope_cells, test_cells};
use crate::burst::{Burst, Info};
use crate::detector::advice::grouped;
use crate::detector::test::NOT_SEARCHED;
use crate::detector::{Feature, Tally, Test};
use crate::error::Result;
use crate::export::{Colour, Drawing, FigureRect, FigureShape, FigureStroke, FigureUnit};
use crate::inspect::ProbeCache;
use crate::inspect::place::{Outcome, Probe, ProbeOptions, probe};
use crate::inspect::result::{DecoyReport, DecoyStudy, decoys};
use crate::inspect::slopes::{Spectrum, spectrum};
use crate::inspect::words::{counted, number, sentence};
use crate::monitor::Monitor;
use crate::plane::Plane;
use crate::plane::display::{Display, to_rgba8};
use serde::Serialize;
use std::sync::Arc;

/// Answers about a burst and its search, of which the page consists.
#[derive(Debug, Serialize)]
pub struct BurstPage {
    /// Description by the files.
    pub info: Info,
    /// Notes on how the values were interpreted, beside those of `info`.
    pub notes: Vec<String>,
    /// Number of features.
    pub features: usize,
    /// Noise of a frame, fraction of full scale.
    pub frame_noise: f32,
    /// Noise gate, standard deviations of D.
    pub noise_gate_factor: f32,
    /// Warnings of the noise model.
    pub noise_warnings: Vec<String>,
    /// Fates of all samples.
    pub tally: Tally,
    /// Slopes and their judgement.
    pub spectrum: Spectrum,
    /// False rates; `None` where the frames have no other orders.
    pub decoys: Option<DecoyReport>,
    /// Reason for no false rates.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub no_decoys: Option<String>,
    /// Fates of the places asked about.
    pub places: Vec<Probe>,
}

/// Share of the work that copies of the burst take.
const DECOYS: f32 = 0.7;
/// Most slopes in the table.
const SLOPES: usize = 12;

impl BurstPage {
    /// Asks all questions of a search of `burst`, which `info` describes: `places` (u, v) are input pixels.
    ///
    /// # Errors
    /// A place outside the picture, and cancellation. A burst without decoys of `study` has a reason instead.
    pub fn of(
        cache: &ProbeCache,
        burst: &Burst,
        info: Info,
        (places, study): (&[[f32; 2]], &DecoyStudy),
        monitor: &Monitor,
    ) -> Result<Self> {
        let detection = cache.detection();
        let rest = monitor.part(DECOYS, 1.0 - DECOYS);
        let (decoys, no_decoys) = match decoys(&cache.trail, study, &monitor.part(0.0, DECOYS)) {
            Ok(report) => (Some(report), None),
            Err(error) if error.is_cancelled() => return Err(error),
            Err(error) => (None, Some(error.to_string())),
        };
        let notes = burst.notes().into_iter().filter(|note| !info.taken.contains(&note.text));
        let options = ProbeOptions::default();
        Ok(Self {
            notes: notes.map(|note| note.for_command()).collect(),
            features: detection.features.len(),
            frame_noise: detection.frame_noise,
            noise_gate_factor: detection.noise_gate_factor,
            noise_warnings: detection.noise.warnings.iter().map(|warning| warning.text.clone()).collect(),
            tally: detection.tally,
            spectrum: spectrum(cache, &rest)?,
            decoys,
            no_decoys,
            places: places.iter().map(|&place| probe(cache, place, &options, &rest)).collect::<Result<_>>()?,
            info,
        })
    }

    /// The page as Markdown. It begins with a comment, so that its mark is one.
    pub fn markdown(&self) -> String {
        let mut text = format!("<!-- Burstscope {} -->\n", env!("CARGO_PKG_VERSION"));
        let mut was_item = false;
        for block in self.blocks() {
            let is_item = matches!(block, Block::Item(_));
            text += if is_item && was_item { "" } else { "\n" };
            was_item = is_item;
            match block {
                Block::Title(title) => text += &format!("# {}\n", escaped(&title)),
                Block::Heading(heading) => text += &format!("## {}\n", escaped(&heading)),
                Block::Text(words) => text += &format!("{}\n", escaped(&words)),
                Block::Item(words) => text += &format!("- {}\n", escaped(&words)),
                Block::Table(rows) => {
                    for (index, cells) in rows.iter().enumerate() {
                        let cells: Vec<String> = cells.iter().map(|cell| escaped(cell)).collect();
                        text += &format!("| {} |\n", cells.join(" | "));
                        text +=
                            &if index == 0 { format!("|{}\n", " --- |".repeat(cells.len())) } else { String::new() };
                    }
                }
            }
        }
        text
    }

    /// The page as a drawing, at least as long as A4, with `picture` on top, circles around the `features`, and numbers
    /// at the places asked about; `caption` says what the picture is.
    pub fn drawing(&self, (picture, caption): (&Plane, &str), features: &[Feature]) -> Drawing {
        let mut sheet = Sheet { shapes: Vec::new(), y: MARGIN };
        let mut blocks = self.blocks().into_iter();
        blocks.by_ref().take(1).for_each(|title| sheet.block(&title));
        sheet.picture(picture, features, &self.places);
        sheet.block(&Block::Text(format!("{caption}; circles: {}", counted(features.len(), "feature"))));
        blocks.for_each(|block| sheet.block(&block));
        let size = [WIDTH, (sheet.y + MARGIN).max(HEIGHT)];
        let paper = FigureShape::Fill { rect: FigureRect { min: [0.0; 2], size }, color: [255; 3] };
        sheet.shapes.insert(0, paper);
        Drawing { size, unit: FigureUnit::Point, shapes: sheet.shapes, title: format!("Report of {}", self.info.name) }
    }

    fn blocks(&self) -> Vec<Block> {
        let described = self.info.text();
        let mut lines = described.lines();
        let mut blocks = vec![Block::Title(lines.next().unwrap_or_default().to_owned())];
        blocks.extend(lines.filter_map(|line| {
            let (subject, words) = line.trim().split_once(' ')?;
            Some(Block::Item(format!("{subject}: {}", words.trim())))
        }));
        blocks.extend(self.notes.iter().map(|note| Block::Item(format!("note: {note}"))));
        self.tell_slopes(&mut blocks);
        blocks.push(Block::heading("Noise"));
        let (noise, gate) = (self.frame_noise, self.noise_gate_factor);
        blocks.push(Block::Text(format!("{noise:.5} of full scale in a frame; noise gate {gate:.2} σ.")));
        blocks.extend(self.noise_warnings.iter().map(|warning| Block::Item(warning.clone())));
        self.tell_features(&mut blocks);
        blocks.push(Block::heading("Tests"));
        let Tally { samples, kept, not_searched, .. } = self.tally;
        let (of, kept) = (grouped(samples), counted(kept as usize, "keypoint"));
        blocks.push(Block::Text(format!(
            "{kept} of {of} samples; the others were rejected by the first test they failed."
        )));
        let rejected = Test::ALL.into_iter().map(|test| (test.reason(), self.tally.rejected_by(test)));
        let rejected = rejected.chain([(NOT_SEARCHED, not_searched)]).filter(|(_, count)| *count > 0);
        blocks.push(table(["samples", "rejected as"], rejected.map(|(why, count)| [grouped(count), why.to_owned()])));
        (1..).zip(&self.places).for_each(|(index, place)| tell_place(index, place, &mut blocks));
        blocks
    }

    fn tell_slopes(&self, blocks: &mut Vec<Block>) {
        let Spectrum { finding, judgement, advice, .. } = &self.spectrum;
        blocks.push(Block::heading("Slopes"));
        blocks.push(Block::Text(format!("The frames show {}.", finding.summary_beside_judgement())));
        let fits = judgement.as_ref().filter(|judgement| judgement.advice.is_none());
        blocks.extend(fits.map(|fits| Block::Text(sentence(&fits.sentence))));
        blocks.extend(advice.iter().map(|one| item(&one.sentence, &one.options())));
        let (bars, hidden) = shown_bars(&self.spectrum, SLOPES);
        let heads = ["slope, px/frame", "features", "evidence", "seen by all frames"];
        blocks.push(table(heads, bars.into_iter().map(slope_cells)));
        blocks.extend((hidden > 0).then(|| Block::Text(format!("And {} with less.", counted(hidden, "more slope")))));
    }

    fn tell_features(&self, blocks: &mut Vec<Block>) {
        blocks.push(Block::heading("Features"));
        let found = counted(self.features, "feature");
        let Some(report) = &self.decoys else {
            let why = self.no_decoys.as_deref().unwrap_or_default();
            blocks.push(Block::Text(format!("{found}. How many are false is not known: {why}.")));
            return;
        };
        let copies = counted(report.copies, "copy").replace("copys", "copies");
        let all = report.rates.first().map_or(0.0, |all| all.mean_in_copies());
        blocks.push(Block::Text(format!(
            "{found}, of which {all:.1} are false by expectation: as many are found on average in {copies} with the frames in other orders; {}.",
            report.sentence()
        )));
        blocks.extend(report.doubt().map(|doubt| Block::Text(sentence(&doubt))));
        blocks.push(table(
            ["SNR from", "found here", "in a copy", "there for each here"],
            report.rates.iter().map(decoy_cells),
        ));
    }
}

fn tell_place(index: usize, probe: &Probe, blocks: &mut Vec<Block>) {
    let [u, v] = probe.pos_image.map(|x| number(x, 1));
    blocks.push(Block::Heading(format!("Place {index} at ({u}, {v})")));
    blocks.push(Block::Text(probe.summary.clone()));
    blocks.extend(reasons(probe).into_iter().chain(doubts(probe)).map(|(words, option)| item(&words, &option)));
    let Some(fate) = probe.subject_fate() else { return };
    blocks.push(Block::Text(sentence(&fate.verdict)));
    blocks.extend(fate.remedy.iter().map(|remedy| item(&remedy.sentence, &remedy.change.option())));
    let asked = fate.tests.iter().filter(|report| report.outcome != Outcome::NotAsked);
    let rows = asked.map(|report| test_cells(report, Some(report.test) == fate.first_failed));
    blocks.push(table(["test", "value", "limit", "margin", "outcome"], rows));
}

enum Block {
    Title(String),
    Heading(String),
    Text(String),
    Item(String),
    /// Rows of cells, the heads first.
    Table(Vec<Vec<String>>),
}

impl Block {
    fn heading(text: &str) -> Self {
        Self::Heading(text.to_owned())
    }
}

fn item(words: &str, option: &str) -> Block {
    Block::Item(if option.is_empty() { words.to_owned() } else { format!("{words}: try {option}") })
}

fn table<const N: usize>(heads: [&str; N], rows: impl Iterator<Item = [String; N]>) -> Block {
    Block::Table(std::iter::once(heads.map(str::to_owned)).chain(rows).map(Vec::from).collect())
}

/// Text in which Markdown reads no marks: names of files may hold any.
fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for letter in text.trim().chars() {
        if matches!(letter, '\\' | '`' | '*' | '_' | '[' | ']' | '<' | '|' | '#') {
            out.push('\\');
        }
        out.push(if letter.is_control() { ' ' } else { letter });
    }
    out
}

/// A4, points.
const WIDTH: f32 = 595.0;
const HEIGHT: f32 = 842.0;
const MARGIN: f32 = 42.0;
const PICTURE_HEIGHT: f32 = 260.0;
const SIZE: f32 = 8.0;
/// Width of a letter over its height, estimated.
const LETTER: f32 = 0.53;
const INK: Colour = [36, 41, 47];
/// Okabe and Ito's yellow, seen on dark pictures and on bright ones.
const RING: Colour = [240, 228, 66];

struct Sheet {
    shapes: Vec<FigureShape>,
    /// Lower end of what is drawn.
    y: f32,
}

impl Sheet {
    fn line(&mut self, x: f32, size: f32, text: String) {
        self.shapes.push(FigureShape::Text { at: [x, self.y + size], size, text, color: INK });
    }

    fn paragraph(&mut self, indent: f32, size: f32, text: &str) {
        let most = ((WIDTH - 2.0 * MARGIN - indent) / (LETTER * size)) as usize;
        let mut line = String::new();
        for word in text.split_whitespace() {
            if !line.is_empty() && line.chars().count() + 1 + word.chars().count() > most {
                self.line(MARGIN + indent, size, std::mem::take(&mut line));
                self.y += 1.3 * size;
            }
            line += if line.is_empty() { "" } else { " " };
            line += word;
        }
        self.line(MARGIN + indent, size, line);
        self.y += 1.3 * size;
    }

    fn block(&mut self, block: &Block) {
        match block {
            Block::Title(text) => self.paragraph(0.0, 1.75 * SIZE, text),
            Block::Heading(text) => {
                self.y += SIZE;
                self.paragraph(0.0, 1.3 * SIZE, text);
            }
            Block::Text(text) => self.paragraph(0.0, SIZE, text),
            Block::Item(text) => self.paragraph(SIZE, SIZE, &format!("• {text}")),
            Block::Table(rows) => {
                let columns = rows.first().map_or(0, Vec::len);
                let letters = |column: usize| rows.iter().map(|row| row[column].chars().count()).max().unwrap_or(0);
                let widths: Vec<f32> =
                    (0..columns).map(|column| (letters(column) as f32 + 3.0) * LETTER * SIZE).collect();
                for row in rows {
                    let mut x = MARGIN + SIZE;
                    for (cell, width) in row.iter().zip(&widths) {
                        self.line(x, SIZE, cell.clone());
                        x += width;
                    }
                    self.y += 1.3 * SIZE;
                }
            }
        }
        self.y += 0.3 * SIZE;
    }

    fn picture(&mut self, picture: &Plane, features: &[Feature], places: &[Probe]) {
        let (width, height) = picture.size();
        let scale = ((WIDTH - 2.0 * MARGIN) / width as f32).min(PICTURE_HEIGHT / height as f32);
        let rect = FigureRect { min: [MARGIN, self.y], size: [width as f32 * scale, height as f32 * scale] };
        // Dark frames would be black on paper.
        let rgba = Arc::new(to_rgba8(picture, &Display::stretched(picture)).into_raw());
        self.shapes.push(FigureShape::Picture { rect, size: (width, height), rgba });
        let at = |[u, v]: [f32; 2]| [rect.min[0] + (u + 0.5) * scale, rect.min[1] + (v + 0.5) * scale];
        let stroke = FigureStroke { width: 0.6, color: RING, opacity: 0.9 };
        let ring = |feature: &Feature| {
            let (centre, radius) = (at([feature.u, feature.v]), scale * feature.circle_radius_px());
            FigureShape::Circle { centre, radius, stroke, dashed: feature.at_slope_limit }
        };
        let name = |(index, place): (usize, &Probe)| FigureShape::Text {
            at: at(place.pos_image),
            size: 1.3 * SIZE,
            text: index.to_string(),
            color: [213, 94, 0],
        };
        let shapes = features.iter().map(ring).chain((1..).zip(places).map(name)).collect();
        self.shapes.push(FigureShape::Clipped { rect, shapes });
        self.y += rect.size[1] + 0.5 * SIZE;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::detector::SearchParams;
    use crate::synth::demo_burst;

    #[test]
    fn markdown_reads_no_marks_in_names_and_the_sheet_holds_all_lines() {
        assert_eq!(escaped("a_b|*<c>\n"), r"a\_b\|\*\<c>");
        let (burst, monitor) = (demo_burst(), Monitor::default());
        let part = burst.of_frames(&[0, 1, 2], crate::burst::Positions::even(3));
        let cache = ProbeCache::new(&part, &SearchParams::default(), &monitor).expect("searched");
        let info = Info::of_burst(&part, "made");
        let asked = (&[[92.0, 58.0]][..], &DecoyStudy::default());
        let page = BurstPage::of(&cache, &part, info, asked, &monitor).expect("answers");
        assert!(page.decoys.is_none() && page.no_decoys.is_some(), "three frames have no other orders");
        let text = page.markdown();
        for words in ["## Slopes", "## Noise", "## Tests", "## Place 1 at (92, 58)", "How many are false is not known"]
        {
            assert!(text.contains(words), "{words}: {text}");
        }
        let drawing = page.drawing((&part.frames[1], "middle frame"), &cache.detection().features);
        let lowest = drawing.shapes.iter().filter_map(|shape| match shape {
            FigureShape::Text { at, .. } => Some(at[1]),
            _ => None,
        });
        assert!(lowest.fold(0.0, f32::max) < drawing.size[1] - 0.5 * MARGIN);
    }
}
