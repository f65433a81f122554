//! Parts that several figures are drawn from: pictures with marks on them, and tables, which are also written as CSV.

use burstscope_core::detector::Feature;
use burstscope_core::export::sheet::{Anchor, Area, GRID, INK, Sheet};
use burstscope_core::plane::Plane;
use burstscope_core::plane::display::Display;

pub(super) const RIGHT: &str = "#4fa3ff";
pub(super) const WRONG: &str = "#ff8c1a";

#[derive(Debug, Clone, Copy)]
pub(super) struct Panel {
    pub area: Area,
    /// Sheet pixels for each image pixel.
    pub scale: f64,
    /// Image pixel at the left top, (u, v).
    origin: [usize; 2],
}

impl Panel {
    /// Draws `plane` with its left top at `at`, `width` wide, under a line of text.
    pub fn draw(sheet: &mut Sheet, at: (f64, f64), width: f64, plane: &Plane, display: &Display, title: &str) -> Self {
        Self::draw_part(sheet, at, width, (plane, [0, 0], plane.size()), display, title)
    }

    /// Draws the part of `plane` that begins at `origin` and has this `size`, cut to the plane.
    pub fn draw_part(
        sheet: &mut Sheet,
        at: (f64, f64),
        width: f64,
        (plane, origin, size): (&Plane, [usize; 2], (usize, usize)),
        display: &Display,
        title: &str,
    ) -> Self {
        let size = (size.0.min(plane.width() - origin[0]), size.1.min(plane.height() - origin[1]));
        let part = Plane::from_fn(size.0, size.1, |u, v| plane.at(origin[0] + u, origin[1] + v));
        let scale = width / size.0 as f64;
        let area = Area { x: at.0, y: at.1, width, height: scale * size.1 as f64 };
        sheet.styled_text((at.0, at.1 - 6.0), 12.0, Anchor::Start, r#"font-weight="bold""#, title);
        sheet.picture(area, &part, display);
        Self { area, scale, origin }
    }

    /// The position on the sheet of the image pixel (u, v), of its middle.
    pub fn at(&self, [u, v]: [f64; 2]) -> (f64, f64) {
        let place = |x: f64, origin: usize| (x + 0.5 - origin as f64) * self.scale;
        (self.area.x + place(u, self.origin[0]), self.area.y + place(v, self.origin[1]))
    }

    pub fn shows(&self, pos_image: [f64; 2]) -> bool {
        let (x, y) = self.at(pos_image);
        x >= self.area.x && x <= self.area.right() && y >= self.area.y && y <= self.area.bottom()
    }

    pub fn circle(&self, sheet: &mut Sheet, pos_image: [f64; 2], radius_px: f64, colour: &str, style: &str) {
        if self.shows(pos_image) {
            let style = format!(r#"fill="none" stroke="{colour}" {style}"#);
            sheet.circle(self.at(pos_image), radius_px * self.scale, &style);
        }
    }

    /// Draws a feature: the rim of the disc with the strongest response at its scale.
    pub fn feature(&self, sheet: &mut Sheet, feature: &Feature, colour: &str) {
        let pos_image = [f64::from(feature.u), f64::from(feature.v)];
        self.circle(sheet, pos_image, 1.5 * f64::from(feature.sigma), colour, r#"stroke-width="1.6""#);
    }
}

#[derive(Debug, Clone, PartialEq)]
pub(super) enum Cell {
    Text(String),
    /// Number, and how many decimals are shown; CSV has all of them.
    Number(f64, usize),
    /// Value that could not be measured, or does not exist.
    Missing,
}

impl Cell {
    pub fn of(value: Option<f64>, decimals: usize) -> Self {
        value.filter(|x| x.is_finite()).map_or(Self::Missing, |x| Self::Number(x, decimals))
    }

    fn shown(&self) -> String {
        match self {
            Self::Text(text) => text.clone(),
            Self::Number(x, decimals) => format!("{x:.decimals$}"),
            Self::Missing => "–".to_owned(),
        }
    }
}

/// Table whose first columns are words.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Table {
    pub title: String,
    /// Heads of the columns: two lines for the picture, and a name for CSV.
    pub columns: Vec<([&'static str; 2], &'static str)>,
    pub rows: Vec<Vec<Cell>>,
    pub notes: Vec<String>,
}

const ROW: f64 = 22.0;
/// Approximate width of a letter of 12 px.
const LETTER: f64 = 6.6;

impl Table {
    /// The table as CSV; missing values are empty.
    pub fn csv(&self) -> String {
        let names: Vec<&str> = self.columns.iter().map(|(_, name)| *name).collect();
        let mut csv = names.join(",") + "\n";
        for row in &self.rows {
            let cells = row.iter().map(|cell| match cell {
                // Without commas no cell needs quotes.
                Cell::Text(text) => text.replace(',', ";"),
                Cell::Number(x, _) => x.to_string(),
                Cell::Missing => String::new(),
            });
            csv += &format!("{}\n", cells.collect::<Vec<_>>().join(","));
        }
        csv
    }

    pub fn svg(&self) -> String {
        let widths: Vec<f64> = (0..self.columns.len()).map(|column| self.width(column)).collect();
        let width = (widths.iter().sum::<f64>() + 32.0).max(560.0);
        let mut sheet = Sheet::new(width, &self.title);
        sheet.styled_text((16.0, 28.0), 15.0, Anchor::Start, r#"font-weight="bold""#, &self.title);
        let top = 56.0;
        let mut x = 16.0;
        for (column, ((head, _), width)) in self.columns.iter().zip(&widths).enumerate() {
            let (at, anchor) = self.place(column, x, *width);
            for (line, text) in head.iter().enumerate() {
                let y = top + 15.0 * line as f64;
                sheet.styled_text((at, y), 12.0, anchor, r#"font-weight="bold""#, text);
            }
            x += width;
        }
        let rule = |sheet: &mut Sheet, y: f64, colour| sheet.line((16.0, y), (width - 16.0, y), colour, "");
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_missing_is_said_in_the_picture_and_empty_in_the_file() {
        let table = Table {
            title: "Numbers".into(),
            columns: vec![(["method", ""], "method"), (["images", "pass, %"], "images_pass_percent")],
            rows: vec![
                vec![Cell::Text("A, B".into()), Cell::Number(98.25, 1)],
                vec![Cell::Text("C".into()), Cell::of(Some(f64::NAN), 1)],
            ],
            notes: vec!["– means missing".into()],
        };
        assert_eq!(table.csv(), "method,images_pass_percent\nA; B,98.25\nC,\n");
        let svg = table.svg();
        assert!(svg.contains(">98.2<") || svg.contains(">98.3<"), "{svg}");
        assert!(svg.contains(">–<") && svg.contains("– means missing"));
    }
}
