//! Films, decoded by this machine's `ffmpeg` into a pipe: luma with all its bits as Y4M, or RGB colours as PPM.
//!
//! The program is started without a shell, may read this file alone and no address of a network, and is killed when the
//! work is cancelled. Its words are an error, also where it ends well. Memory holds the frames and a block of the pipe.

use super::y4m::Film as Stream;
use super::{Format, Input, Rank, Record, Start};
use crate::burst::reading::plain::{Places, Plain};
use crate::burst::reading::{Declared, RawFrame, Reading, confined::Running};
use crate::burst::{number::Number, options::OpenOptions, times::Times};
use crate::error::{Error, ErrorKind, Result};
use crate::files::{self, shell_path};
use crate::monitor::Monitor;
use std::env::consts::EXE_EXTENSION;
use std::ffi::{OsStr, OsString};
use std::io::{self, BufRead, BufReader, Read};
use std::path::{Path, PathBuf};
use std::process::{ChildStdin, ChildStdout, Command};

const KIND: &str = "film";

pub(super) struct Film;

impl Format for Film {
    fn record(&self) -> Record {
        let extensions = &["mp4", "mkv", "avi", "mov", "webm", "mpg", "gif"];
        let opens = "decoded by the `ffmpeg` in `PATH`, with all bits of grey films (FFV1, 16 bit) and at the times that frames are shown; luma as it is stored, and of RGB films and GIFs that of their colours; what `ffmpeg` says of a film is an error with its words";
        let options = "`--array 1` for the second of several tracks; without `ffmpeg` the error says the command";
        Record { name: KIND, rank: Rank::Other, extensions, opens, options }
    }

    fn begins(&self, start: &Start<'_>) -> bool {
        container(start.bytes).is_some()
    }

    fn count(&self, _input: Input, _reading: Reading<'_>) -> Result<usize> {
        Ok(2)
    }

    fn declared(&self, _input: Input, reading: Reading<'_>) -> Result<Declared> {
        let Reading { path, options, ticker, .. } = reading;
        let monitor = ticker.monitor();
        let whole = &options.of_whole();
        let (mut times, tracks) =
            run(path, (&LIST, usize::MAX), options, monitor, |reader| times(path, reader, whole))?;
        let film = run_frames(reading, 1, |reader, is_ppm| Piped::read(path, reader, is_ppm))?;
        let size = film.plain(0).size;
        let (width, height) = (size.0 as u64, size.1 as u64);
        options.limits.check_frame(path, width, height)?;
        times.seconds = options.taken(path, times.seconds, size)?;
        options.limits.check_burst(path, times.seconds.len() as u64, width, height)?;
        let plain = film.plain(times.seconds.len());
        let several = || format!("of {tracks} tracks number {} is taken; --array takes another", track(options));
        let taken = (tracks > 1).then(several).into_iter().collect();
        Ok(Declared { kind: KIND, times, taken, ..plain.declared() })
    }

    fn frames(&self, _input: Input, reading: Reading<'_>) -> Result<Vec<RawFrame>> {
        let Reading { path, options, .. } = reading;
        // `ffmpeg` decodes from the start: frames before the range are read and dropped.
        let range = options.take.map_or(0..usize::MAX, |range| range.start..range.end);
        run_frames(reading, range.end, |mut reader, is_ppm| {
            let film = Piped::read(path, reader, is_ppm)?;
            let plain = film.plain(1);
            let (width, height) = (plain.size.0 as u64, plain.size.1 as u64);
            options.limits.check_frame(path, width, height)?;
            let (mut frames, mut count) = (Vec::new(), 0);
            while count < range.end && film.next_frame(path, reader, count)? {
                let mut rest = film.rest_bytes();
                if count < range.start {
                    rest += plain.frame_bytes();
                } else {
                    options.limits.check_burst(path, frames.len() as u64 + 1, width, height)?;
                    frames.push(plain.read(reading, frames.len(), &mut reader)?);
                }
                count += 1;
                let skipped = io::copy(&mut (&mut reader).take(rest), &mut io::sink());
                if skipped.map_err(|e| Error::from_read(path, KIND, &e))? < rest {
                    return Err(Error::corrupt(path, KIND, "its last frame is not whole"));
                }
            }
            if frames.is_empty() { Err(Error::corrupt(path, KIND, "ffmpeg finds no frame in it")) } else { Ok(frames) }
        })
    }

    fn only(&self, _input: Input, reading: Reading<'_>) -> Result<RawFrame> {
        Err(Error::stack_among_frames(reading.path, 2))
    }
}

/// Name in `ffmpeg` of the container that begins with `start`; none for HEIF, a picture in MP4's container.
fn container(start: &[u8]) -> Option<&'static str> {
    let at = |place: usize, magic: &[u8]| start.get(place..).is_some_and(|rest| rest.starts_with(magic));
    let is_picture = [&b"hei"[..], b"hev", b"mif1", b"msf1", b"avi"].iter().any(|brand| at(8, brand));
    let magics: [(usize, &[u8], &str); 10] = [
        (4, b"moov", "mov"),
        (4, b"mdat", "mov"),
        (4, b"wide", "mov"),
        (8, b"AVI ", "avi"),
        (0, b"\x1a\x45\xdf\xa3", "matroska"),
        (0, b"\0\0\x01\xba", "mpeg"),
        (0, b"\0\0\x01\xb3", "mpegvideo"),
        (0, b"FLV\x01", "flv"),
        (0, b"\x30\x26\xb2\x75\x8e\x66\xcf\x11", "asf"),
        (0, b"GIF8", "gif"),
    ];
    if at(4, b"ftyp") && !is_picture {
        return Some("mov");
    }
    let found = magics.into_iter().find(|(place, magic, _)| at(*place, magic)).map(|(.., name)| name);
    found.filter(|name| *name != "avi" || at(0, b"RIFF"))
}

/// Formats of pixels that Y4M holds: frames in these keep their bits, others (GIF, RGB) are converted to the nearest.
const PIXELS: &str = "format=gray|gray9le|gray10le|gray12le|gray16le|yuv411p|yuv420p|yuv422p|yuv444p|yuvj420p|yuvj422p|\
    yuvj444p|yuv420p9le|yuv422p9le|yuv444p9le|yuv420p10le|yuv422p10le|yuv444p10le|yuv420p12le|yuv422p12le|yuv444p12le|\
    yuv420p14le|yuv422p14le|yuv444p14le|yuv420p16le|yuv422p16le|yuv444p16le";
const COLOURS: &str = "rgb24|rgb48be";
/// Arguments that decode each frame once, without pixel formats; `ffmpeg` before 5.1 knows the first by another name.
const FRAMES: [&str; 3] = ["-fps_mode", "passthrough", "-vf"];
const AS_Y4M: [&str; 5] = ["-strict", "-1", "-f", "yuv4mpegpipe", "pipe:1"];
const AS_PPM: [&str; 5] = ["-c:v", "ppm", "-f", "image2pipe", "pipe:1"];
/// Arguments that list the packets of the track taken, and behind it those of all tracks that are no covers.
const LIST: [&str; 7] = ["-map", "0:V?", "-c", "copy", "-f", "framecrc", "pipe:1"];

/// Number of the track of pictures that the user asks for, as cameras of depth record several.
fn track(options: &OpenOptions) -> &str {
    options.array.as_deref().unwrap_or("0")
}

/// The `ffmpeg` that is found first in `PATH`.
pub(crate) fn ffmpeg() -> Option<PathBuf> {
    let folders = std::env::var_os("PATH").unwrap_or_default();
    // A relative folder in `PATH` could run a program that lies beside the film.
    let absolute = std::env::split_paths(&folders).filter(|folder| folder.is_absolute());
    absolute.map(|folder| folder.join("ffmpeg").with_extension(EXE_EXTENSION)).find(|program| program.is_file())
}

/// Error for a film without `ffmpeg`, with the command that keeps its bits.
fn missing(path: &Path) -> Error {
    let remedy = format!(
        "ffmpeg decodes it and is not in PATH: install it, or convert the film elsewhere, with all its bits: \
         ffmpeg -i {} -fps_mode passthrough -vf '{PIXELS}' -strict -1 {}",
        shell_path(path),
        shell_path(&path.with_extension("y4m"))
    );
    Error::new(ErrorKind::Unsupported, "this is a film", remedy)
}

/// The path as an argument that `ffmpeg` takes for no option, pattern or address, whatever the name is.
pub(crate) fn file_url(path: &Path) -> OsString {
    [OsStr::new("file:"), path.as_os_str()].into_iter().collect()
}

/// Runs `ffmpeg` as [`run_once`] does, and again with the names of options that old versions know.
fn run<T>(
    path: &Path,
    (arguments, most): (&[&str], usize),
    options: &OpenOptions,
    monitor: &Monitor,
    read: impl Fn(&mut dyn BufRead) -> Result<T>,
) -> Result<T> {
    let answer = run_once(path, (arguments, most), options, monitor, &read);
    if !answer.as_ref().is_err_and(|error| error.problem.contains("fps_mode")) {
        return answer;
    }
    let arguments: Vec<&str> =
        arguments.iter().map(|word| if *word == "-fps_mode" { "-vsync" } else { *word }).collect();
    run_once(path, (&arguments, most), options, monitor, &read)
}

/// Runs `ffmpeg` on the first `most` frames of `path`. The container is named: a file's name may look like a pattern.
fn run_once<T>(
    path: &Path,
    (arguments, most): (&[&str], usize),
    options: &OpenOptions,
    monitor: &Monitor,
    read: impl FnOnce(&mut dyn BufRead) -> Result<T>,
) -> Result<T> {
    monitor.check()?;
    let start = files::open(path).and_then(|file| files::next_bytes(file, 32)).map_err(|e| Error::from_io(path, &e))?;
    let container = container(&start).ok_or_else(|| Error::corrupt(path, KIND, "its first bytes have changed"))?;
    let mut command = Command::new(ffmpeg().ok_or_else(|| missing(path))?);
    let input = file_url(path);
    command.args(["-nostdin", "-v", "error", "-protocol_whitelist", "file"]);
    if !options.accept_damaged {
        command.arg("-xerror");
    }
    command.args(["-format_whitelist", container, "-f", container, "-i"]).arg(input);
    if track(options).parse::<u8>().is_err() {
        let problem = format!("this film has no track '{:.200}'", track(options));
        return Err(Error::new(ErrorKind::Mismatch, problem, "say its number from 0 on with --array").about(path));
    }
    // A capital V leaves covers out.
    command.args(["-map", &format!("0:V:{}", track(options))]);
    if most < usize::MAX {
        command.args(["-frames:v", &most.to_string()]);
    }
    command.args(arguments);
    let Ran { answer, words: [words, _], is_well } = ran(command, path, monitor, |stdin, stdout| {
        drop(stdin);
        let mut reader = BufReader::with_capacity(1 << 16, stdout);
        let answer = read(&mut reader)?;
        // Read to the end: a closed pipe would look like a failure of the program.
        io::copy(&mut reader, &mut io::sink()).map_err(|e| Error::from_read(path, KIND, &e))?;
        Ok(answer)
    })?;
    match answer {
        // A limit, or a value that is not finite, is not the program's failure.
        Err(error) if words.is_empty() || error.kind != ErrorKind::Damaged => Err(error),
        // `ffmpeg` goes on after damage, and ends well.
        Ok(answer) if is_well && (words.is_empty() || options.accept_damaged) => Ok(answer),
        Ok(_) if is_well => Err(said(path, &words, "--accept-damaged takes the frames that it decodes all the same")),
        _ => Err(said(path, &words, "try ffmpeg on it by itself; what is damaged, copy again")),
    }
}

/// End of a run of `ffmpeg`: what the work on its pipes gave, and the first and the last line of its words.
pub(crate) struct Ran<T> {
    pub answer: Result<T>,
    pub words: [String; 2],
    pub is_well: bool,
}

/// Runs `command`, an `ffmpeg` for the file `path`, with `work` on its input and output, until both have ended.
///
/// # Errors
/// A program that cannot be started, and cancellation, which kills it.
pub(crate) fn ran<T>(
    command: Command,
    path: &Path,
    monitor: &Monitor,
    work: impl FnOnce(ChildStdin, ChildStdout) -> Result<T>,
) -> Result<Ran<T>> {
    let mut running = Running::spawn(command, path)?;
    let (stdin, stdout, stderr) = running.pipes();
    // All pipes are used at once: a full one would stop the program.
    let (answer, words) = std::thread::scope(|scope| {
        let words = scope.spawn(move || lines_of(stderr));
        let answer = running.watched(path, monitor, None, || work(stdin, stdout)).flatten();
        if answer.is_err() {
            running.kill();
        }
        (answer, words.join().unwrap_or_default())
    });
    monitor.check()?;
    Ok(Ran { answer, words, is_well: running.ends_well() })
}

/// Error with the words of `ffmpeg`, which are no verdict on the file.
fn said(path: &Path, words: &str, remedy: &str) -> Error {
    let words = if words.is_empty() { "nothing" } else { words };
    Error::new(ErrorKind::Damaged, format!("ffmpeg does not decode this film, and says: {words}"), remedy).about(path)
}

/// First and last line written to `stderr`, 2000 bytes of each; all is read, so that the writer never waits.
fn lines_of(stderr: impl Read) -> [String; 2] {
    const MAX_LINE_BYTES: u64 = 2000;
    let (mut reader, mut lines, mut line) = (BufReader::new(stderr), Vec::new(), Vec::new());
    while (&mut reader).take(MAX_LINE_BYTES).read_until(b'\n', &mut line).is_ok_and(|bytes| bytes > 0) {
        let text = String::from_utf8_lossy(&std::mem::take(&mut line)).trim().to_owned();
        // A summary without a reason.
        if !text.is_empty() && text != "Conversion failed!" {
            lines.truncate(1);
            lines.push(text);
        }
    }
    [lines.first(), lines.last()].map(|line| line.cloned().unwrap_or_default())
}

/// Reads the first `most` frames as Y4M, or as PPM (`read` gets true) where Y4M has no pixel format near the film's.
fn run_frames<T>(reading: Reading<'_>, most: usize, read: impl Fn(&mut dyn BufRead, bool) -> Result<T>) -> Result<T> {
    let Reading { path, options, ticker, .. } = reading;
    let [nearest, colours] = [format!("{PIXELS}|{COLOURS}"), format!("format={COLOURS}")];
    let as_y4m = [&FRAMES[..], &[&nearest], &AS_Y4M].concat();
    let answer = run(path, (&as_y4m, most), options, ticker.monitor(), |reader| read(reader, false));
    if !answer.as_ref().is_err_and(|error| error.problem.contains("yuv4mpeg can only handle")) {
        return answer;
    }
    let as_ppm = [&FRAMES[..], &[&colours], &AS_PPM].concat();
    run(path, (&as_ppm, most), options, ticker.monitor(), |reader| read(reader, true))
}

enum Piped {
    Y4m(Stream),
    Ppm(PpmHeader),
}

/// Columns, rows and largest value.
type PpmHeader = [u64; 3];

fn ppm_header(path: &Path, reader: &mut dyn BufRead) -> Result<PpmHeader> {
    let mut text = String::new();
    for _ in 0..3 {
        reader.take(64).read_line(&mut text).map_err(|e| Error::from_read(path, KIND, &e))?;
    }
    let numbers = text.strip_prefix("P6").map(|rest| rest.split_whitespace().filter_map(|word| word.parse().ok()));
    numbers.and_then(|numbers| numbers.collect::<Vec<_>>().try_into().ok()).ok_or_else(|| {
        let what = "ffmpeg writes what is no picture";
        Error::corrupt(path, KIND, if text.is_empty() { "ffmpeg finds no frame in it" } else { what })
    })
}

impl Piped {
    fn read(path: &Path, mut reader: &mut dyn BufRead, is_ppm: bool) -> Result<Self> {
        if is_ppm { ppm_header(path, reader).map(Self::Ppm) } else { Stream::read(path, &mut reader).map(Self::Y4m) }
    }

    /// Reads up to the numbers of frame `frame`; false at the end of the film.
    fn next_frame(&self, path: &Path, mut reader: &mut dyn BufRead, frame: usize) -> Result<bool> {
        match self {
            Self::Y4m(_) => Stream::next_frame(path, &mut reader),
            Self::Ppm(_) if frame == 0 => Ok(true),
            Self::Ppm(_) if reader.fill_buf().map_err(|e| Error::from_read(path, KIND, &e))?.is_empty() => Ok(false),
            Self::Ppm(first) if ppm_header(path, reader)? == *first => Ok(true),
            Self::Ppm(_) => Err(Error::corrupt(path, KIND, "its frames differ in size")),
        }
    }

    fn rest_bytes(&self) -> u64 {
        if let Self::Y4m(film) = self { film.rest_bytes() } else { 0 }
    }

    fn plain(&self, count: usize) -> Plain {
        match self {
            Self::Y4m(film) => film.plain(vec![0; count]),
            Self::Ppm([width, height, largest]) => {
                let number = if *largest > 255 { Number::U16 } else { Number::U8 };
                let plain =
                    Plain::new(KIND, (*width as usize, *height as usize), Places::Listed(vec![0; count]), number);
                Plain { big_endian: true, channels: 3, white: Some(*largest as f32), is_encoded: true, ..plain }
            }
        }
    }
}

/// Times in a list of frames, each a line: number of the stream, two times, duration, length and checksum; and the
/// number of tracks of pictures.
fn times(path: &Path, reader: &mut dyn BufRead, options: &OpenOptions) -> Result<(Times, usize)> {
    let (mut unit_s, mut seconds, mut streams) = (1.0, Vec::new(), 0);
    for line in reader.take(1 << 26).lines() {
        let line = line.map_err(|e| Error::from_read(path, KIND, &e))?;
        streams += usize::from(line.starts_with("#tb "));
        if let Some(unit) = line.strip_prefix("#tb 0:") {
            let parts =
                unit.trim().split_once('/').and_then(|(a, b)| Some((a.parse::<f64>().ok()?, b.parse::<f64>().ok()?)));
            unit_s = parts.filter(|(_, b)| *b > 0.0).map_or(1.0, |(a, b)| a / b);
        } else if !line.starts_with('#') && line.split(',').next().is_some_and(|stream| stream.trim() == "0") {
            // What an edit list cuts off is decoded for the rest, and not shown.
            const DISCARDED: u32 = 4;
            let flags = line.rsplit_once("F=0x").and_then(|(_, flags)| u32::from_str_radix(flags.trim(), 16).ok());
            if flags.is_some_and(|flags| flags & DISCARDED > 0) {
                continue;
            }
            let shown = line.split(',').nth(2).and_then(|field| field.trim().parse::<f64>().ok());
            seconds.push(shown.ok_or_else(|| Error::corrupt(path, KIND, "a frame has no time"))? * unit_s);
            options.limits.check_burst(path, seconds.len() as u64, 1, 1)?;
        }
    }
    // Packets come in the order of decoding, not of display.
    seconds.sort_by(f64::total_cmp);
    let first = *seconds.first().ok_or_else(|| Error::corrupt(path, KIND, "ffmpeg finds no frame in it"))?;
    seconds.iter_mut().for_each(|time| *time -= first);
    Ok((Times { seconds, is_absolute: false }, streams.saturating_sub(1)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn without_ffmpeg_the_error_says_the_command() {
        let words = missing(Path::new("it's.mp4")).to_string();
        assert!(words.contains(r"-i 'it'\''s.mp4'") && words.ends_with(r"-strict -1 'it'\''s.y4m'"), "{words}");
    }

    #[test]
    fn lists_of_frames_are_in_the_order_of_their_times() {
        let list = "#software: Lavf\n#tb 0: 1/25\n#media_type 0: video\n#tb 1: 1/25\n#tb 2: 1/9\n0, 0, 2, 1, 90, 0x1\n2, 0, 0, 1, 8, 0x0\n0, 1, 4, 1, 90, 0x2\n0, 2, 3, 1, 9, 0x3\n";
        let read = |text: &str| times(Path::new("a.mp4"), &mut text.as_bytes(), &OpenOptions::default());
        let (Times { seconds, .. }, tracks) = read(list).expect("times");
        assert_eq!(tracks, 2);
        assert!(
            seconds.iter().zip([0.0, 0.04, 0.08]).all(|(found, expected)| (found - expected).abs() < 1e-12),
            "{seconds:?}"
        );
        for bad in ["", "#tb 0: 1/25\n", "0, 1\n", "words\n"] {
            assert!(read(bad).expect_err(bad).to_string().contains("a.mp4"));
        }
    }
}
