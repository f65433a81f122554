//! Tables: of commands, reports and documents, as text, CSV, LaTeX and drawn.

use super::shape::{Anchor, Drawing};
use super::sheet::{GRID, INK, Sheet};

/// Cell of a table.
#[derive(Debug, Clone, PartialEq)]
pub enum Cell {
    /// A word or a sentence.
    Text(String),
    /// Number, and how many decimals are shown; CSV has all of them.
    Number(f64, usize),
    /// Value that could not be measured, or does not exist.
    Missing,
}

impl Cell {
    /// A number; missing if `None` or not finite.
    pub fn of(value: Option<f64>, decimals: usize) -> Self {
        value.filter(|x| x.is_finite()).map_or(Self::Missing, |x| Self::Number(x, decimals))
    }

    /// A number with the fewest digits that read back to it.
    pub fn single(value: f32, decimals: usize) -> Self {
        Self::of(value.to_string().parse().ok(), decimals)
    }

    /// A number of things.
    pub fn count(count: usize) -> Self {
        Self::Number(count as f64, 0)
    }

    fn shown(&self) -> String {
        match self {
            Self::Text(text) => text.clone(),
            Self::Number(x, decimals) => format!("{x:.decimals$}"),
            Self::Missing => "–".to_owned(),
        }
    }

    fn csv(&self) -> String {
        match self {
            Self::Text(text) if text.contains([',', '"', '\n', '\r']) => format!("\"{}\"", text.replace('"', "\"\"")),
            Self::Text(text) => text.clone(),
            Self::Number(x, _) => x.to_string(),
            Self::Missing => String::new(),
        }
    }
}

impl From<&str> for Cell {
    fn from(text: &str) -> Self {
        Self::Text(text.to_owned())
    }
}

/// Head of a column: two lines where it is drawn, and its name in CSV.
pub type Head = ([String; 2], String);

/// Table with a head for each column.
#[derive(Debug, Clone, PartialEq)]
#[allow(missing_docs)] // where a name says it
pub struct Table {
    pub title: String,
    pub columns: Vec<Head>,
    /// Rows, each with a cell for every column; a shorter one panics where it is drawn.
    pub rows: Vec<Vec<Cell>>,
    pub notes: Vec<String>,
}

const ROW: f64 = 22.0;
/// Approximate width of a letter of 12 px.
const LETTER: f64 = 6.6;

impl Table {
    /// A table whose columns `header` names as CSV does, separated by commas.
    pub fn new(title: &str, header: &str, rows: Vec<Vec<Cell>>) -> Self {
        let head = |name: &str| ([name.replace('_', " "), String::new()], name.to_owned());
        Self { title: title.to_owned(), columns: header.split(',').map(head).collect(), rows, notes: Vec::new() }
    }

    /// This table with other heads where it is drawn or printed.
    #[must_use]
    pub fn headed(mut self, heads: &[&str]) -> Self {
        self.columns.iter_mut().zip(heads).for_each(|((head, _), text)| *head = [(*text).to_owned(), String::new()]);
        self
    }

    /// The table as CSV; missing values are empty.
    pub fn csv(&self) -> String {
        let names: Vec<&str> = self.columns.iter().map(|(_, name)| &**name).collect();
        let rows = self.rows.iter().map(|row| row.iter().map(Cell::csv).collect::<Vec<_>>().join(","));
        std::iter::once(names.join(",")).chain(rows).map(|line| line + "\n").collect()
    }

    /// The cells of each row, as they are shown.
    pub fn shown(&self) -> impl Iterator<Item = Vec<String>> {
        self.rows.iter().map(|row| row.iter().map(Cell::shown).collect())
    }

    /// The table for LaTeX's package booktabs, with title and notes as comments.
    pub fn latex(&self) -> String {
        let comment = |text: &String| format!("% {}\n", text.replace(['\n', '\r'], " "));
        let line = |cells: Vec<String>| {
            let cells: Vec<String> = cells.iter().map(|cell| latex_text(cell)).collect();
            format!("{} \\\\\n", cells.join(" & "))
        };
        let sides: String = (0..self.columns.len()).map(|i| if self.is_text(i) { 'l' } else { 'r' }).collect();
        let rows: String = self.shown().map(line).collect();
        format!(
            "{}\\begin{{tabular}}{{{sides}}}\n\\toprule\n{}\\midrule\n{rows}\\bottomrule\n\\end{{tabular}}\n{}",
            comment(&self.title),
            line(self.heads()),
            self.notes.iter().map(comment).collect::<String>()
        )
    }

    /// Lines of text as wide as their cells: the first column stands to the left, the others to the right.
    pub fn text(&self) -> String {
        let lines: Vec<Vec<String>> = std::iter::once(self.heads()).chain(self.shown()).collect();
        let width = |column: usize| lines.iter().filter_map(|line| Some(line.get(column)?.chars().count())).max();
        let widths: Vec<usize> = (0..self.columns.len()).map(|column| width(column).unwrap_or(0)).collect();
        let line = |line: &Vec<String>| {
            let cells = line.iter().zip(&widths).enumerate().map(|(column, (cell, &width))| match column {
                0 => format!("{cell:<width$}"),
                _ => format!("   {cell:>width$}"),
            });
            cells.collect::<String>() + "\n"
        };
        lines.iter().map(line).collect()
    }

    /// The table as a sheet.
    pub fn drawing(&self) -> Drawing {
        let widths: Vec<f64> = (0..self.columns.len()).map(|column| self.width(column)).collect();
        let width = (widths.iter().sum::<f64>() + 32.0).max(560.0);
        let mut sheet = Sheet::new(width, &self.title);
        sheet.heading((16.0, 28.0), 15.0, &self.title);
        let top = 56.0;
        let mut x = 16.0;
        for (column, ((head, _), width)) in self.columns.iter().zip(&widths).enumerate() {
            let (at, anchor) = self.place(column, x, *width);
            for (line, text) in head.iter().enumerate() {
                let style = (super::shape::Face::Bold, INK);
                sheet.styled_text((at, top + 15.0 * line as f64), 12.0, anchor, style, text);
            }
            x += width;
        }
        let rule = |sheet: &mut Sheet, y: f64, colour| sheet.line((16.0, y), (width - 16.0, y), colour);
        let body = top + 26.0;
        rule(&mut sheet, body, INK);
        for (index, row) in self.rows.iter().enumerate() {
            let y = body + ROW * (index as f64 + 1.0);
            let mut x = 16.0;
            for (column, (cell, width)) in row.iter().zip(&widths).enumerate() {
                let (at, anchor) = self.place(column, x, *width);
                sheet.text((at, y - 6.0), 12.0, anchor, &cell.shown());
                x += width;
            }
            // A dark rule where the first column changes holds the rows of one subject together.
            let begins_anew = self.rows.get(index + 1).is_some_and(|next| next[0] != row[0]);
            rule(&mut sheet, y, if begins_anew || index + 1 == self.rows.len() { INK } else { GRID });
        }
        let mut y = body + ROW * self.rows.len() as f64 + 24.0;
        for note in &self.notes {
            y = sheet.paragraph((16.0, y), 12.0, width - 32.0, note) + 4.0;
        }
        sheet.finish(y)
    }

    fn heads(&self) -> Vec<String> {
        self.columns.iter().map(|(head, _)| head.join(" ").trim().to_owned()).collect()
    }

    fn is_text(&self, column: usize) -> bool {
        self.rows.iter().all(|row| matches!(row[column], Cell::Text(_)))
    }

    fn place(&self, column: usize, x: f64, width: f64) -> (f64, Anchor) {
        if self.is_text(column) { (x, Anchor::Start) } else { (x + width - 14.0, Anchor::End) }
    }

    fn width(&self, column: usize) -> f64 {
        let heads = self.columns[column].0.iter().map(|text| 7.2 * text.chars().count() as f64);
        let cells = self.rows.iter().map(|row| LETTER * row[column].shown().chars().count() as f64);
        heads.chain(cells).fold(40.0, f64::max) + 20.0
    }
}

fn latex_text(text: &str) -> String {
    let letter = |c: char| match c {
        '&' | '%' | '$' | '#' | '_' | '{' | '}' => format!("\\{c}"),
        '[' | ']' | '*' | '<' | '>' | '|' => format!("{{${c}$}}"), // A line break before would take brackets.
        '\\' => "\\textbackslash{}".to_owned(),
        '~' => "\\textasciitilde{}".to_owned(),
        '^' => "\\textasciicircum{}".to_owned(),
        '–' => "--".to_owned(),
        '−' => "$-$".to_owned(),
        'σ' => "$\\sigma$".to_owned(),
        c if c.is_control() => " ".to_owned(),
        c => c.to_string(),
    };
    text.chars().map(letter).collect()
}
