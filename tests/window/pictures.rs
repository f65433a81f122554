//! Comparing the window with `screenshots/`.
//!
//! `NAME.txt` holds the [structure](crate::structure) of the window: the roles, texts and places of all that is shown,
//! and the greys of each pane. It is compared on every machine. `NAME.png` is there only
//! - where a document shows it: it is never compared, and is drawn anew for a release;
//! - in `flat/`, for windows without noise: it is compared too, at the size at which it is stored.
//!
//! `UPDATE_SNAPSHOTS=1` accepts texts and flat pictures that differ. `UPDATE_SNAPSHOTS=force` writes all texts and
//! pictures anew, those of the documents too.

use crate::{cut, structure, support::*};
use image::RgbImage;
use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::imageops::thumbnail;

const FLAT: &str = "flat/";
/// Colours of a picture of a document.
const COLOURS: usize = 256;
/// Number of samples from which the colours are learnt.
const SAMPLES: usize = 60_000;
/// Difference of a channel above which a pixel of a flat picture differs.
const CHANNEL_TOLERANCE: u8 = 40;
/// Number of pixels that may differ: software drivers of different versions round a few edges differently.
const MAX_PIXELS: usize = 8;

/// Compares the window of `harness` with the structure `name`, and with the picture if it is one without noise.
#[track_caller]
pub fn compare<State>(harness: &mut Harness<'_, State>, name: &str) {
    let image = harness.render().expect("it can be drawn");
    cut::assert_none_cut_off(harness, name);
    let shown = structure::structure_of(&harness.root(), harness.ctx.content_rect(), &image);
    let stored = Stored::new(name);
    let told = stored.differences(&shown, &image);
    match std::env::var("UPDATE_SNAPSHOTS").as_deref() {
        Err(_) | Ok("0" | "false" | "no" | "off") => stored.check(&shown, &image, told),
        Ok("force") => stored.write(&shown, &image, stored.is_flat() || is_in_a_document(name)),
        Ok(_) if told.is_some() => stored.write(&shown, &image, stored.is_flat()),
        Ok(_) => {}
    }
}

struct Stored {
    text: PathBuf,
    picture: PathBuf,
}

impl Stored {
    fn new(name: &str) -> Self {
        let file = |extension: &str| root().join(format!("screenshots/{name}.{extension}"));
        Self { text: file("txt"), picture: file("png") }
    }

    fn is_flat(&self) -> bool {
        self.text.parent().is_some_and(|folder| folder.ends_with(FLAT))
    }

    fn differences(&self, shown: &str, image: &RgbaImage) -> Option<String> {
        // A file that is not there is an empty one.
        let text = fs::read_to_string(&self.text).unwrap_or_default();
        structure::differences(&text, shown).or_else(|| {
            let is_stored = || Some(count_differing(&image::open(&self.picture).ok()?.into_rgb8(), &halved(image)));
            let pixels = self.is_flat().then(is_stored)?.unwrap_or(usize::MAX);
            (pixels > MAX_PIXELS).then(|| format!("{}: other pixels\n", self.picture.display()))
        })
    }

    /// Leaves what is shown beside the files where they differ.
    #[track_caller]
    fn check(&self, shown: &str, image: &RgbaImage, told: Option<String>) {
        let (text, picture) = (self.text.with_extension("new.txt"), self.picture.with_extension("new.png"));
        let _ = (fs::remove_file(&text), fs::remove_file(&picture));
        if let Some(told) = told {
            write(&text, shown.as_bytes());
            image.save(&picture).unwrap_or_else(|error| panic!("{}: {error}", picture.display()));
            panic!(
                "{} differs from what is shown, which is in {} and {}:\n{told}Run with UPDATE_SNAPSHOTS=1 to accept it.",
                self.text.display(),
                text.display(),
                picture.display()
            );
        }
    }

    fn write(&self, shown: &str, image: &RgbaImage, with_picture: bool) {
        fs::create_dir_all(self.text.parent().expect("a folder")).expect("a folder can be made");
        write(&self.text, shown.as_bytes());
        if with_picture {
            let stored = if self.is_flat() { coarse(&halved(image)) } else { in_few_colours(&halved(image)) };
            write(&self.picture, &stored);
        }
    }
}

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn write(path: &Path, bytes: &[u8]) {
    fs::write(path, bytes).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
}

/// Whether the README or a page of `docs/` shows the picture.
fn is_in_a_document(name: &str) -> bool {
    let pages = fs::read_dir(root().join("docs")).expect("a folder").map(|entry| entry.expect("an entry").path());
    let markdown = pages.filter(|path| path.extension().is_some_and(|extension| extension == "md"));
    let shows =
        |path: PathBuf| fs::read_to_string(&path).expect("a text").contains(&format!("screenshots/{name}.png)"));
    markdown.chain([root().join("README.md")]).any(shows)
}

fn halved(image: &RgbaImage) -> RgbImage {
    let half = thumbnail(image, image.width() / 2, image.height() / 2);
    image::DynamicImage::ImageRgba8(half).into_rgb8()
}

/// Number of pixels that differ; all of those where the sizes do.
fn count_differing(a: &RgbImage, b: &RgbImage) -> usize {
    if a.dimensions() != b.dimensions() {
        return usize::MAX;
    }
    let is_other =
        |a: &image::Rgb<u8>, b: &image::Rgb<u8>| a.0.iter().zip(b.0).any(|(a, b)| a.abs_diff(b) > CHANNEL_TOLERANCE);
    a.pixels().zip(b.pixels()).filter(|(a, b)| is_other(a, b)).count()
}

/// The value without its three finest bits.
fn coarse_value(value: u8) -> u8 {
    (value & 0xF8) | (value >> 5)
}

/// The picture as PNG in 32 steps a channel: what is free of noise becomes small by that, and no colour is lost.
fn coarse(image: &RgbImage) -> Vec<u8> {
    let mut coarse = image.clone();
    coarse.iter_mut().for_each(|value| *value = coarse_value(*value));
    let mut bytes = Vec::new();
    let encoder = PngEncoder::new_with_quality(&mut bytes, CompressionType::Best, FilterType::NoFilter);
    coarse.write_with_encoder(encoder).expect("memory");
    bytes
}

/// The picture as PNG with a palette.
fn in_few_colours(image: &RgbImage) -> Vec<u8> {
    let with_alpha = |pixel: &image::Rgb<u8>| [pixel.0[0], pixel.0[1], pixel.0[2], 255];
    // Each colour counts once, however rare it is: marks are small, and their colours tell them apart.
    let colours: BTreeSet<[u8; 4]> = image.pixels().map(|pixel| with_alpha(pixel).map(coarse_value)).collect();
    let learnt: Vec<[u8; 4]> = colours.iter().copied().cycle().take(SAMPLES).collect();
    let palette = color_quant::NeuQuant::new(1, COLOURS, learnt.as_flattened());
    let indices: Vec<u8> = image.pixels().map(|pixel| palette.index_of(&with_alpha(pixel)) as u8).collect();
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, image.width(), image.height());
    encoder.set_color(png::ColorType::Indexed);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_palette(palette.color_map_rgb());
    encoder.set_compression(png::Compression::High);
    encoder.set_filter(png::Filter::NoFilter);
    let mut writer = encoder.write_header().expect("memory");
    writer.write_image_data(&indices).expect("as many as it has pixels");
    writer.finish().expect("memory");
    bytes
}

#[test]
fn a_flat_picture_keeps_its_colours_and_a_changed_one_differs() {
    let image = RgbaImage::from_fn(320, 200, |x, y| {
        let grey = if (x / 40 + y / 20).is_multiple_of(2) { 27 } else { 140 + (x / 40) as u8 };
        image::Rgba([grey, grey, if y > 150 { 200 } else { grey }, 255])
    });
    let half = halved(&image);
    let read = |stored: &[u8]| image::load_from_memory(stored).unwrap().into_rgb8();
    let stored = read(&coarse(&half));
    assert_eq!((stored.dimensions(), count_differing(&stored, &half)), ((160, 100), 0));
    let mut changed = image;
    for (x, y) in (60..90).flat_map(|x| [(x, 30), (x, 31)]) {
        changed.put_pixel(x, y, image::Rgba([255, 255, 255, 255]));
    }
    assert!(count_differing(&stored, &halved(&changed)) > MAX_PIXELS, "a line of thirty points");
    assert!(count_differing(&stored, &RgbImage::new(160, 99)) > MAX_PIXELS);
}

#[test]
fn a_picture_with_noise_and_marks_is_near_itself_in_few_colours_and_small() {
    let noise =
        |x: u32, y: u32| (x.wrapping_mul(0x9E37_79B1) ^ y.wrapping_mul(0x85EB_CA77)).wrapping_mul(0x2C1B_3C6D) >> 26;
    let image = RgbImage::from_fn(320, 200, |x, y| match (x / 4, y) {
        (10, _) => image::Rgb([230, 60, 40]),
        (30, _) => image::Rgb([60, 120, 240]),
        _ => image::Rgb([60 + noise(x, y) as u8; 3]),
    });
    let stored = in_few_colours(&image);
    assert_eq!(count_differing(&image::load_from_memory(&stored).unwrap().into_rgb8(), &image), 0);
    assert!(stored.len() < 320 * 200, "{} bytes", stored.len());
}
