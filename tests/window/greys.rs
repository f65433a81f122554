//! Greys of a part of the window: a picture of it in 160 digits, which noise does not change.
//!
//! The pictures of a burst change a little with every change of the detector, because features are drawn over them.
//! A picture that is missing, black, shifted, or another one must still be noticed.

use crate::support::*;

const CELLS: [u32; 2] = [16, 10];
const STEPS: u32 = 16;
const CLASSES: usize = 8;

/// Largest sum of the cells' differences, steps. Three changes of the detector, each of which found other features at
/// other slopes, changed 252 panes by at most 49 steps, 10 cells and 6 percent. With these limits all of them pass. A
/// black or empty picture in their place is always told, one that is moved by a tenth of its width 96 times in 100, one
/// that is darker by a tenth 98 times.
const MAX_STEPS: u32 = 56;
const MAX_CELLS: usize = 10;
const MAX_PERCENT: u32 = 10;

#[derive(Debug, PartialEq)]
pub struct Greys {
    /// Mean grey of each cell, row by row; steps.
    cells: Vec<u32>,
    /// Share of the pixels near the middle grey of each class, percent. A pixel counts for the two nearest classes, in
    /// proportion: so rounding never moves all pixels of an even picture to another class.
    percent: Vec<u32>,
}

impl Greys {
    /// Greys of `image` in `rect`, pixels; `None` where fewer pixels than cells are in the image.
    pub fn of(image: &RgbaImage, rect: Rect) -> Option<Self> {
        let inside =
            rect.intersect(Rect::from_min_size(Pos2::ZERO, [image.width(), image.height()].map(|s| s as f32).into()));
        let [left, top, right, bottom] =
            [inside.left(), inside.top(), inside.right(), inside.bottom()].map(|x| x.round() as u32);
        if right < left + CELLS[0] || bottom < top + CELLS[1] {
            return None;
        }
        let bounds = |start: u32, end: u32, cell: u32, cells: u32| {
            start + (end - start) * cell / cells..start + (end - start) * (cell + 1) / cells
        };
        // A class is WIDTH greys wide, and each pixel counts WIDTH times.
        const WIDTH: u64 = 256 / CLASSES as u64;
        let (mut cells, mut counts) = (Vec::new(), [0u64; CLASSES]);
        for row in 0..CELLS[1] {
            for column in 0..CELLS[0] {
                let (mut sum, mut count) = (0, 0);
                for y in bounds(top, bottom, row, CELLS[1]) {
                    for x in bounds(left, right, column, CELLS[0]) {
                        let [r, g, b, _] = image.get_pixel(x, y).0.map(u32::from);
                        let grey = (299 * r + 587 * g + 114 * b) / 1000;
                        (sum, count) = (sum + grey, count + 1);
                        let since_first = u64::from(grey).saturating_sub(WIDTH / 2);
                        let (class, beyond) = ((since_first / WIDTH) as usize, since_first % WIDTH);
                        counts[class] += WIDTH - beyond;
                        counts[(class + 1).min(CLASSES - 1)] += beyond;
                    }
                }
                cells.push(sum * STEPS / (256 * count));
            }
        }
        let all: u64 = counts.iter().sum();
        let percent = counts.iter().map(|count| ((100 * count + all / 2) / all) as u32).collect();
        Some(Self { cells, percent })
    }

    /// A digit for each cell, a word for each row, and the percentages.
    pub fn words(&self) -> String {
        let digit = |&step: &u32| char::from_digit(step, STEPS).expect("a step");
        let rows = self.cells.chunks(CELLS[0] as usize).map(|row| row.iter().map(digit).collect());
        rows.chain(self.percent.iter().map(u32::to_string)).collect::<Vec<String>>().join(" ")
    }

    /// Reads [`Self::words`] from the end of a line; also returns the line before them.
    pub fn read(line: &str) -> Option<(&str, Self)> {
        let count = CELLS[1] as usize + CLASSES;
        let mut words: Vec<&str> = line.rsplitn(count + 1, ' ').collect();
        let before = words.pop().filter(|_| words.len() == count)?;
        words.reverse();
        let (rows, percent) = words.split_at(CELLS[1] as usize);
        let cells: Option<Vec<u32>> = rows.iter().flat_map(|row| row.chars()).map(|c| c.to_digit(STEPS)).collect();
        let percent = percent.iter().map(|number| number.parse().ok()).collect::<Option<_>>()?;
        let greys = Self { cells: cells?, percent };
        (greys.cells.len() == (CELLS[0] * CELLS[1]) as usize).then_some((before, greys))
    }

    /// Whether both can be of one picture, before and after a change of the features in it. All cells of an even
    /// picture may be a step apart: rounding does that.
    pub fn are_near(&self, other: &Self) -> bool {
        let are_near_but_for = |all: i32| {
            let pairs = self.cells.iter().zip(&other.cells);
            let steps: Vec<u32> = pairs.map(|(a, b)| (*a as i32 - *b as i32 - all).unsigned_abs()).collect();
            steps.iter().sum::<u32>() <= MAX_STEPS && steps.iter().filter(|&&step| step >= 2).count() <= MAX_CELLS
        };
        let percent: u32 = self.percent.iter().zip(&other.percent).map(|(a, b)| a.abs_diff(*b)).sum();
        percent <= MAX_PERCENT && [-1, 0, 1].into_iter().any(are_near_but_for)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use image::Rgba;
    const AREA: Rect = Rect { min: pos2(20.0, 10.0), max: pos2(340.0, 250.0) };

    /// A window with a pane of blobs on an uneven ground: `light` of its brightness, `shift` pixels to the right, with
    /// `noise` of so many levels.
    fn window(light: f32, shift: f32, noise: u32) -> RgbaImage {
        RgbaImage::from_fn(400, 300, |x, y| {
            if !AREA.contains(pos2(x as f32, y as f32)) {
                return Rgba([27, 27, 27, 255]);
            }
            let at = pos2(x as f32 - shift, y as f32);
            let blob = |u: f32, v: f32, sigma: f32| (-(at - pos2(u, v)).length_sq() / (2.0 * sigma * sigma)).exp();
            let ground = 60.0 + 0.2 * at.y;
            let value =
                light * (ground + 120.0 * (blob(90.0, 70.0, 16.0) + blob(200.0, 160.0, 30.0) + blob(290.0, 60.0, 9.0)));
            let hash = (x.wrapping_mul(0x9E37_79B1) ^ y.wrapping_mul(0x85EB_CA77)).wrapping_mul(0x2C1B_3C6D) >> 8;
            let grain = if noise == 0 { 0.0 } else { (hash % (2 * noise + 1)) as f32 - noise as f32 };
            let grey = (value + grain).clamp(0.0, 255.0) as u8;
            Rgba([grey, grey, grey, 255])
        })
    }

    fn greys(image: &RgbaImage) -> Greys {
        Greys::of(image, AREA).expect("an area")
    }

    #[test]
    fn noise_and_a_few_marks_are_near_and_a_black_missing_shifted_or_dimmed_picture_is_not() {
        let stored = greys(&window(1.0, 0.0, 0));
        for noise in [4, 12] {
            assert!(stored.are_near(&greys(&window(1.0, 0.0, noise))), "noise of {noise} levels");
        }
        let mut marked = window(1.0, 0.0, 4);
        for (u, v) in [(60, 200), (150, 90), (310, 220), (250, 40)] {
            for i in 0..24 {
                for (x, y) in [(u + i, v), (u, v + i), (u + i, v + 24), (u + 24, v + i)] {
                    marked.put_pixel(x, y, Rgba([90, 200, 255, 255]));
                }
            }
        }
        assert!(stored.are_near(&greys(&marked)), "four squares over it");
        let missing = RgbaImage::from_pixel(400, 300, Rgba([27, 27, 27, 255]));
        let even = RgbaImage::from_pixel(400, 300, Rgba([90, 90, 90, 255]));
        let turned = image::imageops::rotate180(&window(1.0, 0.0, 0));
        let others = [window(0.0, 0.0, 0), missing, even, turned, window(1.0, 24.0, 0), window(0.8, 0.0, 0)];
        for (index, other) in others.iter().enumerate() {
            assert!(!stored.are_near(&greys(other)), "the {index}th is another picture");
        }
    }

    #[test]
    fn words_are_read_again_and_other_lines_are_not() {
        let greys = greys(&window(1.0, 0.0, 12));
        let line = format!("20 10 320 240 Grey \"Picture A, pane 1\" {}", greys.words());
        let (before, read) = Greys::read(&line).expect("greys");
        assert_eq!((before, &read), ("20 10 320 240 Grey \"Picture A, pane 1\"", &greys));
        for line in
            ["", "8 3 24 20 Button \"File\"", &line[..line.len() - 3], &line.replace("Grey \"Picture A, pane 1\" ", "")]
        {
            assert!(Greys::read(line).is_none_or(|(before, _)| !before.contains("Grey")), "{line}");
        }
    }

    #[test]
    fn areas_outside_the_window_have_no_greys_and_rounding_makes_no_difference() {
        let image = window(1.0, 0.0, 0);
        for rect in [
            Rect::from_min_size(pos2(400.0, 0.0), vec2(50.0, 50.0)),
            Rect::from_min_size(pos2(10.0, 10.0), vec2(15.0, 50.0)),
            Rect::from_min_size(pos2(-40.0, 10.0), vec2(50.0, 50.0)),
        ] {
            assert_eq!(Greys::of(&image, rect), None, "{rect}");
        }
        // An even picture on the edge between two steps is near itself, rounded otherwise.
        let even = |grey: u8| greys(&RgbaImage::from_pixel(400, 300, Rgba([grey, grey, grey, 255])));
        assert!(even(63).cells != even(64).cells && even(63).are_near(&even(64)));
        // The part in the window counts.
        let over = Rect::from_min_max(pos2(-300.0, AREA.top()), pos2(200.0, AREA.bottom()));
        let inside = Rect::from_min_max(pos2(0.0, AREA.top()), pos2(200.0, AREA.bottom()));
        assert_eq!(Greys::of(&image, over), Greys::of(&image, inside));
    }
}
