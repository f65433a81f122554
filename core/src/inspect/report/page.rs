//! A burst on one page, as text, or drawn on a sheet under a picture of the burst: what it is, its slopes, noise,
//! tests, false features and the places asked about, in the words of the other answers. Pages, as Markdown and HTML.

use super::{decoy_cells, doubts, reasons, shown_bars, slope_cells, test_cells};
use crate::burst::{Burst, Info};
use crate::detector::{Test, test::NOT_SEARCHED};
use crate::error::Result;
use crate::export::sheet::{Anchor, Area, Colour, Face, LETTER, RED, Sheet};
use crate::export::{Drawing, Escaped, FigureStroke, FigureUnit};
use crate::files::mark::SOFTWARE;
use crate::inspect::ProbeCache;
use crate::inspect::place::{Outcome, Probe, ProbeOptions, probe};
use crate::inspect::result::{DecoyReport, DecoyStudy, decoys};
use crate::inspect::slopes::{Spectrum, spectrum};
use crate::inspect::words::{counted, grouped, number, sentence};
use crate::monitor::Monitor;
use crate::plane::Plane;
use crate::plane::display::Display;
use std::path::Path;

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

/// A4, points.
const WIDTH: f64 = 595.0;
const HEIGHT: f64 = 842.0;
const MARGIN: f64 = 42.0;
const PICTURE_HEIGHT: f64 = 260.0;
const SIZE: f64 = 8.0;
/// Okabe and Ito's yellow, seen on dark pictures and on bright ones.
const RING: Colour = [240, 228, 66];
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
        let decoys = match decoys(&cache.trail, study, false, &monitor.part(0.0, DECOYS)) {
            Err(error) if error.is_cancelled() => return Err(error),
            decoys => decoys.map(|decoys| decoys.report).map_err(|error| error.to_string()),
        };
        let rest = monitor.part(DECOYS, 1.0 - DECOYS);
        let fate = |at: [f32; 2]| probe(cache, at, &ProbeOptions::default(), &rest);
        let places = places.iter().map(|(name, at)| Ok((name.clone(), fate(*at)?)));
        let (spectrum, places) = (spectrum(cache, &rest)?, places.collect::<Result<_>>()?);
        Ok(Self { cache, burst, info, spectrum, decoys, places })
    }

    /// The page: the input, its slopes, noise, features and tests, then the places.
    pub fn page(&self) -> Page {
        let mut page = Page::default();
        self.tell_input(&mut page);
        self.tell_slopes(&mut page);
        self.tell_features(&mut page);
        self.places.iter().for_each(|(name, place)| tell_place(&mut page, name, place));
        page
    }

    fn tell_input(&self, page: &mut Page) {
        let described = self.info.text();
        let mut lines = described.lines();
        page.line(TITLE, lines.next().unwrap_or_default());
        let told = lines.filter_map(|line| line.trim().split_once(' '));
        page.items(told.map(|(subject, words)| (format!("{subject}: {}", words.trim()), String::new())));
        let notes = self.burst.notes().into_iter().filter(|note| !self.info.taken.contains(&note.text));
        page.items(notes.map(|note| (format!("note: {}", note.for_command()), String::new())));
    }

    fn tell_slopes(&self, page: &mut Page) {
        let Spectrum { finding, judgement, advice, .. } = &self.spectrum;
        page.line(HEADING, "Slopes");
        page.line(TEXT, format!("The frames: {}.", finding.summary_beside_judgement()));
        if let Some(fits) = judgement.as_ref().filter(|judgement| judgement.advice.is_none()) {
            page.line(TEXT, sentence(&fits.sentence));
        }
        page.items(advice.iter().map(|one| (one.sentence.clone(), one.options())));
        let (bars, hidden) = shown_bars(&self.spectrum, SLOPES);
        let heads = ["slope, px/frame", "features", "evidence", "seen by all frames"];
        page.table(heads, bars.into_iter().map(slope_cells));
        if hidden > 0 {
            page.line(TEXT, format!("And {} with less.", counted(hidden, "more slope")));
        }
    }

    fn tell_features(&self, page: &mut Page) {
        let detection = self.cache.detection();
        let (noise, gate) = (detection.frame_noise, detection.noise_gate_factor);
        page.line(HEADING, "Noise");
        page.line(TEXT, format!("{noise:.5} of full scale in a frame; noise gate {gate:.2} σ."));
        page.items(detection.noise.warnings.iter().map(|warning| (warning.text.clone(), String::new())));
        let found = counted(detection.features.len(), "feature");
        page.line(HEADING, "Features");
        match &self.decoys {
            Err(why) => page.line(TEXT, format!("{found}. How many are false is not known: {why}.")),
            Ok(report) => {
                let (expected, rates) = (report.expected_words(), report.sentence());
                page.line(TEXT, format!("{found}; {expected}."));
                // Without rates the reason has just been given.
                if rates != expected {
                    page.line(TEXT, format!("With the frames in other orders {rates}."));
                    page.items(report.doubt().map(|doubt| (sentence(&doubt), String::new())));
                    let heads = ["SNR from", "found here", "in a copy", "there for each here"];
                    page.table(heads, report.rates.iter().map(decoy_cells));
                }
            }
        }
        let tally = &detection.tally;
        let (samples, kept) = (grouped(tally.samples), counted(tally.kept as usize, "keypoint"));
        page.line(HEADING, "Tests");
        page.line(
            TEXT,
            format!("{kept} of {samples} samples; each other one counts at the first test that it failed."),
        );
        let rejected = Test::ALL.into_iter().map(|test| (test.reason(), tally.rejected_by(test)));
        let rejected = rejected.chain([(NOT_SEARCHED, tally.not_searched)]).filter(|(_, count)| *count > 0);
        page.table(["samples", "rejected as"], rejected.map(|(why, count)| [grouped(count), why.to_owned()]));
    }

    /// The page as a drawing, at least as long as A4, with `picture` on top, circles around the features, and names
    /// or numbers at the places asked about; `caption` says what the picture is.
    pub fn drawing(&self, picture: &Plane, caption: &str) -> Drawing {
        let mut sheet = Sheet::new(WIDTH, &format!("Report of {}", self.info.name));
        let mut top = self.draw_picture(&mut sheet, picture);
        let line = |sheet: &mut Sheet, top: f64, size: f64, text: &str| {
            sheet.paragraph((MARGIN, top + size), size, WIDTH - 2.0 * MARGIN, text) - size
        };
        let found = counted(self.cache.detection().features.len(), "feature");
        top = line(&mut sheet, top, SIZE, &format!("{caption}; {found}"));
        for parts in self.page().groups() {
            top = parts.iter().fold(top + 0.5 * SIZE, |top, part| match part {
                Part::Line((.., size), text) => line(&mut sheet, top, size * SIZE, text),
                Part::Item(text, _) => line(&mut sheet, top, SIZE, &format!("- {text}")),
                Part::Table(rows) => draw_table(&mut sheet, top, rows),
            });
        }
        Drawing { unit: FigureUnit::Point, ..sheet.finish((top + MARGIN).max(HEIGHT)) }
    }

    /// Draws `picture` with the features and places; returns the top of what comes below it.
    fn draw_picture(&self, sheet: &mut Sheet, picture: &Plane) -> f64 {
        let (width, height) = (picture.width() as f64, picture.height() as f64);
        let scale = ((WIDTH - 2.0 * MARGIN) / width).min(PICTURE_HEIGHT / height);
        let area = Area { x: MARGIN, y: MARGIN, width: width * scale, height: height * scale };
        // Dark frames would be black on paper.
        sheet.picture(area, picture, &Display::stretched(picture));
        let at = |place: [f32; 2]| {
            let [u, v] = place.map(|x| (f64::from(x) + 0.5) * scale);
            (area.x + u, area.y + v)
        };
        let stroke = FigureStroke { opacity: 0.9, ..FigureStroke::new(RING, 0.6) };
        sheet.clipped(area, |sheet| {
            for feature in &self.cache.detection().features {
                let style = if feature.at_slope_limit { stroke.dashed([2.4; 2]) } else { stroke };
                sheet.circle(at([feature.u, feature.v]), scale * f64::from(feature.circle_radius_px()), style);
            }
            for (name, place) in &self.places {
                // Of a numbered place the number is enough.
                let short = name.strip_prefix("Place ").unwrap_or(name);
                sheet.styled_text(at(place.pos_image), 1.3 * SIZE, Anchor::Start, (Face::Plain, RED), short);
            }
        });
        area.bottom() + 0.5 * SIZE
    }
}

/// Draws rows of a table, the heads first; returns the top of what comes below it.
fn draw_table(sheet: &mut Sheet, top: f64, rows: &[Vec<String>]) -> f64 {
    let letters = |column: usize| rows.iter().filter_map(|row| Some(row.get(column)?.chars().count())).max();
    rows.iter().fold(top, |top, row| {
        let mut x = MARGIN + 2.0 * LETTER * SIZE;
        for (column, cell) in row.iter().enumerate() {
            sheet.text((x, top + SIZE), SIZE, Anchor::Start, cell);
            x += (letters(column).unwrap_or(0) + 3) as f64 * LETTER * SIZE;
        }
        top + 1.3 * SIZE
    })
}

fn tell_place(page: &mut Page, name: &str, probe: &Probe) {
    let [u, v] = probe.pos_image.map(|x| number(x, 1));
    page.line(HEADING, format!("{name} at ({u}, {v})"));
    page.line(TEXT, probe.summary.clone());
    page.items(reasons(probe).into_iter().chain(doubts(probe)));
    let Some(fate) = probe.subject_fate() else { return };
    page.items([(sentence(&fate.verdict), String::new())]);
    page.items(fate.remedy.iter().map(|remedy| (remedy.sentence.clone(), remedy.change.option())));
    let asked = fate.tests.iter().filter(|report| report.outcome != Outcome::NotAsked);
    let rows = asked.map(|report| test_cells(report, Some(report.test) == fate.first_failed));
    page.table(["test", "value", "limit", "margin", "outcome"], rows);
}

/// Kind of a line: its mark in Markdown, its element in HTML, and the size of its letters over that of others.
type Look = (&'static str, &'static str, f64);
pub(super) const TITLE: Look = ("# ", "h1", 1.75);
pub(super) const HEADING: Look = ("## ", "h2", 1.3);
pub(super) const TEXT: Look = ("", "p", 1.0);

/// Part of a page, with its texts as they are read.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Part {
    Line(Look, String),
    /// Item of a list, with a command line or an empty text.
    Item(String, String),
    /// Heads, then a row each.
    Table(Vec<Vec<String>>),
}

/// Page of text, lists and tables, written as Markdown or as HTML that needs no other file.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Page(pub(super) Vec<Part>);

impl Page {
    /// The page for a file at `path`, by its ending: HTML or Markdown; `None` for any other.
    pub fn text_for(&self, path: &Path) -> Option<String> {
        let is = |name: &str| path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case(name));
        if is("html") { Some(self.html()) } else { is("md").then(|| self.markdown()) }
    }

    pub(super) fn line(&mut self, look: Look, text: impl Into<String>) {
        self.0.push(Part::Line(look, text.into()));
    }

    /// Sentences, each with the option that mends the fault, or an empty text.
    pub(super) fn items(&mut self, items: impl IntoIterator<Item = (String, String)>) {
        self.0.extend(items.into_iter().map(|(words, option)| {
            let told = if option.is_empty() { words } else { format!("{}: try {option}", words.trim_end_matches('.')) };
            Part::Item(told, String::new())
        }));
    }

    pub(super) fn table<'a, R: IntoIterator<Item = String>>(
        &mut self,
        heads: impl IntoIterator<Item = &'a str>,
        rows: impl Iterator<Item = R>,
    ) {
        let heads = heads.into_iter().map(str::to_owned).collect();
        self.0.push(Part::Table(std::iter::once(heads).chain(rows.map(|row| row.into_iter().collect())).collect()));
    }

    /// The parts, neighbouring items as one list.
    fn groups(&self) -> impl Iterator<Item = &[Part]> {
        self.0.chunk_by(|a, b| matches!((a, b), (Part::Item(..), Part::Item(..))))
    }

    /// Markdown, with a comment as the first line, so that the mark is a comment too.
    pub fn markdown(&self) -> String {
        let row =
            |cells: &Vec<String>| format!("| {} |\n", cells.iter().map(|c| escaped(c)).collect::<Vec<_>>().join(" | "));
        let part = |part: &Part| match part {
            Part::Line((mark, ..), text) => format!("{mark}{}\n", escaped(text)),
            Part::Item(text, line) if line.is_empty() => format!("- {}\n", escaped(text)),
            Part::Item(text, line) => format!("- {}\n\n      {line}\n", escaped(text)),
            Part::Table(rows) => {
                let rule = " --- |".repeat(rows[0].len());
                format!("{}|{rule}\n{}", row(&rows[0]), rows[1..].iter().map(row).collect::<String>())
            }
        };
        let groups = self.groups().map(|parts| format!("\n{}", parts.iter().map(part).collect::<String>()));
        format!("<!-- {SOFTWARE} -->\n{}", groups.collect::<String>())
    }

    /// HTML, which is XML too, in the colours of the reader's system.
    fn html(&self) -> String {
        let cells = |tag: &str, cells: &[String]| {
            let cell = |cell: &String| {
                let is_number = cell.replace(['−', '%', ' '], "").parse::<f64>().is_ok();
                format!("<{tag}{}>{}</{tag}>", if is_number { " class=\"number\"" } else { "" }, Escaped(cell))
            };
            format!("<tr>{}</tr>\n", cells.iter().map(cell).collect::<String>())
        };
        let part = |part: &Part| match part {
            Part::Line((_, tag, _), text) => format!("<{tag}>{}</{tag}>\n", Escaped(text)),
            Part::Item(text, line) if line.is_empty() => format!("<li>{}</li>\n", Escaped(text)),
            Part::Item(text, line) => format!("<li>{}<pre>{}</pre></li>\n", Escaped(text), Escaped(line)),
            Part::Table(rows) => {
                let rest: String = rows[1..].iter().map(|row| cells("td", row)).collect();
                format!(
                    "<div><table>\n<thead>{}</thead>\n<tbody>\n{rest}</tbody>\n</table></div>\n",
                    cells("th", &rows[0])
                )
            }
        };
        let groups = self.groups().map(|parts| {
            let [begin, end] = if let Part::Item(..) = parts[0] { ["<ul>\n", "</ul>\n"] } else { [""; 2] };
            format!("{begin}{}{end}", parts.iter().map(part).collect::<String>())
        });
        let title = self.0.iter().find_map(|part| if let Part::Line(_, text) = part { Some(&**text) } else { None });
        format!(
            "{}<meta name=\"generator\" content=\"{SOFTWARE}\"/>\n<title>{}</title>\n</head>\n<body>\n{}</body>\n</html>\n",
            include_str!("page.html"),
            Escaped(title.unwrap_or_default()),
            groups.collect::<String>()
        )
    }
}

/// Text without marks that Markdown would read: names of files may hold any.
fn escaped(text: &str) -> String {
    let marked = |letter: char| ["\\`*_[]<|#&~".contains(letter).then_some('\\'), Some(letter)];
    text.replace(char::is_control, " ").chars().flat_map(marked).flatten().collect()
}
