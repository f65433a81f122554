//! Films: pictures of one size one after the other, for ever, as GIF, which is shown everywhere but has 256 colours; as
//! MP4 by the `ffmpeg` in `PATH`, small and with all colours; or as PNG files with numbers, for other programs.

use super::atomic::{replace, write_marked};
use super::{Bitmap, png::write_png};
use crate::burst::{Ran, ffmpeg, file_url, ran};
use crate::error::{Error, ErrorKind, Result};
use crate::files::{self, mark::OutputKind, mark::seal};
use crate::monitor::{Monitor, Stage};
use image::RgbaImage;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::{fs::OpenOptions, process::Command};

/// Whether the name of a file ends as that of a film: `.gif`, `.mp4`, or `.png` for pictures with numbers.
pub fn is_film(path: &Path) -> bool {
    ["gif", "mp4", "png"].iter().any(|ending| ends(path, ending))
}

fn ends(path: &Path, ending: &str) -> bool {
    path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case(ending))
}

fn is_series(path: &Path) -> bool {
    ends(path, "png")
}

/// Checks that this machine can encode a film at `path`.
///
/// # Errors
/// An MP4 without `ffmpeg` in `PATH`.
pub fn check_film(path: &Path) -> Result<()> {
    encoder(path).map(drop)
}

/// The `ffmpeg` that encodes a film at `path`; `None` for one that needs none.
fn encoder(path: &Path) -> Result<Option<PathBuf>> {
    let missing = || {
        let remedy = "install it, or name the file .gif or .png, which need none";
        Error::new(ErrorKind::Unwritten, "MP4 needs ffmpeg, which is not in PATH", remedy).about(path)
    };
    ends(path, "mp4").then(|| ffmpeg().ok_or_else(missing)).transpose()
}

/// Files of a film of `count` pictures at `path`: the GIF, or for `sweep.png` `sweep-000.png`, `sweep-001.png`, ….
pub fn film_files(path: &Path, count: usize) -> Vec<PathBuf> {
    if !is_series(path) {
        return vec![path.to_owned()];
    }
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    (0..count).map(|index| path.with_file_name(format!("{stem}-{index:03}.png"))).collect()
}

/// Pictures per second that a film may have.
pub const FILM_RATES: std::ops::RangeInclusive<u16> = 1..=50;
/// Speed of the choice of a GIF's colours: 1 is best, 30 fastest.
const GIF_SPEED: i32 = 10;

/// Encodes `count` `pictures` of one size, `per_second` of them a second, each as it comes.
///
/// # Errors
/// Pictures of no size, of several sizes, too few or too large for the format, and errors of `pictures` and `out`.
pub fn encode_film(
    out: &mut dyn Write,
    (count, pictures): (usize, impl IntoIterator<Item = io::Result<RgbaImage>>),
    per_second: u16,
    monitor: &Monitor,
) -> io::Result<()> {
    let (size, pictures) = of_one_size(count, pictures, monitor)?;
    let (Ok(width), Ok(height)) = (u16::try_from(size.0), u16::try_from(size.1)) else {
        return Err(io::Error::other("a GIF has at most 65535 columns and rows"));
    };
    let mut encoder = gif::Encoder::new(out, width, height, &[]).map_err(io::Error::other)?;
    // Viewers show a film without this once, and then its last picture.
    encoder.set_repeat(gif::Repeat::Infinite).map_err(io::Error::other)?;
    for (index, picture) in pictures.enumerate() {
        let picture = picture?;
        let mut frame = gif::Frame::from_rgba_speed(width, height, &mut picture.into_raw(), GIF_SPEED);
        // Hundredths of a second, the unit of the format; rounded so that the sum is right, not each of them.
        let until = |count: usize| 100 * count / usize::from(per_second.max(1));
        frame.delay = (until(index + 1) - until(index)) as u16;
        encoder.write_frame(&frame).map_err(io::Error::other)?;
    }
    Ok(())
}

/// Size (columns, rows) of the pictures, and these as they come, with progress; errors for none or several sizes.
fn of_one_size(
    count: usize,
    pictures: impl IntoIterator<Item = io::Result<RgbaImage>>,
    monitor: &Monitor,
) -> io::Result<((u32, u32), impl Iterator<Item = io::Result<RgbaImage>>)> {
    let mut pictures = pictures.into_iter();
    let first = pictures.next().ok_or_else(|| io::Error::other("a film has at least one picture"))??;
    let size = first.dimensions();
    let check = move |(index, picture): (usize, io::Result<RgbaImage>)| {
        let picture = picture?;
        if size.0 == 0 || size.1 == 0 || picture.dimensions() != size {
            return Err(io::Error::other("all pictures of a film have one size, of at least one pixel"));
        }
        monitor.check().map_err(io::Error::other)?;
        monitor.report(Stage::Write, index as f32 / count.max(1) as f32);
        Ok(picture)
    };
    Ok((size, std::iter::once(Ok(first)).chain(pictures).enumerate().map(check)))
}

/// Bytes, about, of a film of `count` pictures at `path`: the mean size of two of them, times their number. `None` for
/// an MP4, whose pictures are stored as differences.
pub fn estimated_film_bytes(path: &Path, pictures: [&RgbaImage; 2], count: usize) -> Option<u64> {
    let of_one = |picture: &RgbaImage| {
        let mut bytes = Vec::new();
        let encoded = match is_series(path) {
            true => bitmap(picture).encode_png(&mut bytes),
            false => encode_film(&mut bytes, (1, [Ok(picture.clone())]), 10, &Monitor::default()),
        };
        encoded.map_or(0, |()| bytes.len() as u64)
    };
    (!ends(path, "mp4")).then(|| (of_one(pictures[0]) + of_one(pictures[1])) / 2 * count as u64)
}

fn bitmap(picture: &RgbaImage) -> Bitmap<'_> {
    Bitmap::rgba(picture.width() as usize, picture.height() as usize, picture.as_raw())
}

/// Writes a film to its [`film_files`]; [`encode_film`] encodes a GIF, `ffmpeg` an MP4.
///
/// # Errors
/// Those of the pictures, of `ffmpeg` or its lack, a file that cannot be written, and cancellation, which leaves no
/// picture of this film.
pub fn write_film(
    path: &Path,
    (count, pictures): (usize, impl IntoIterator<Item = io::Result<RgbaImage>>),
    per_second: u16,
    monitor: &Monitor,
) -> Result<()> {
    if let Some(program) = encoder(path)? {
        return replace(path, |new| {
            let (size, pictures) = of_one_size(count, pictures, monitor)?;
            encode_mp4(&program, new, size, pictures, per_second, monitor)?;
            let mut file = files::open_as(new, OpenOptions::new().read(true).write(true))?;
            seal(&mut file, OutputKind::Film)?;
            Ok(file)
        });
    }
    if !is_series(path) {
        return write_marked(path, OutputKind::Film, |mut out| {
            encode_film(&mut out, (count, pictures), per_second, monitor)
        });
    }
    let files = film_files(path, count);
    let (_, pictures) = of_one_size(count, pictures, monitor).map_err(|e| Error::unwritten(path, &e))?;
    let mut written = 0;
    let result = files.iter().zip(pictures).try_for_each(|(file, picture)| {
        let picture = picture.map_err(|e| Error::unwritten(file, &e))?;
        write_png(file, bitmap(&picture)).map(|()| written += 1)
    });
    if result.is_err() {
        files[..written].iter().for_each(|file| drop(std::fs::remove_file(file)));
    }
    result
}

/// Encodes an MP4 into the new file `new`, of H.264 where `program` has `libx264`. Its pictures have an even number of
/// columns and rows, the last ones white where there was none.
fn encode_mp4(
    program: &Path,
    new: &Path,
    (width, height): (u32, u32),
    mut pictures: impl Iterator<Item = io::Result<RgbaImage>>,
    per_second: u16,
    monitor: &Monitor,
) -> io::Result<()> {
    const INPUT: &str = "-protocol_whitelist pipe -f rawvideo -pixel_format rgb0";
    // What players expect of colours that are not said, for small pictures and large ones.
    const OUTPUT: &str = "-vf pad=ceil(iw/2)*2:ceil(ih/2)*2:color=white,scale=out_color_matrix=bt709:out_range=tv,\
                          format=yuv420p -colorspace bt709 -color_primaries bt709 -color_trc bt709 -color_range tv \
                          -movflags +faststart -f mp4";
    const QUIET: [&str; 3] = ["-nostdin", "-v", "error"];
    let failed = |error: Error| monitor.check().map_or_else(io::Error::other, |()| io::Error::other(error.problem));
    let mut asked = Command::new(program);
    asked.args(QUIET).arg("-encoders");
    let read = |stdin, stdout| {
        drop(stdin);
        Ok(io::read_to_string(stdout))
    };
    let listed = ran(asked, new, monitor, read).map_err(failed)?;
    let mut command = Command::new(program);
    command.args(QUIET).args(INPUT.split(' ')).args(["-video_size", &format!("{width}x{height}")]);
    command.args(["-framerate", &per_second.to_string(), "-i", "pipe:0"]).args(OUTPUT.split(' '));
    if listed.answer.is_ok_and(|text| text.is_ok_and(|text| text.contains(" libx264 "))) {
        command.args(["-c:v", "libx264", "-crf", "18"]);
    }
    command.arg(file_url(new));
    let Ran { answer, words: [_, last], is_well } = ran(command, new, monitor, |mut stdin, mut stdout| {
        let written = pictures.try_for_each(|picture| stdin.write_all(picture?.as_raw()));
        drop(stdin);
        // It says nothing there, and closes it when the file is whole or its last words are said.
        Ok(io::copy(&mut stdout, &mut io::sink()).and(written))
    })
    .map_err(failed)?;
    if !is_well {
        return Err(io::Error::other(format!("ffmpeg ends with an error, and says: {last}")));
    }
    answer.map_err(failed)?
}
