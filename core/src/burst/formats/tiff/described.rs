//! Axes of a TIFF's pages: from its description (OME's XML, ImageJ's lines, tifffile's JSON), or as programs of
//! microscopes say them. Places without a page are reported; a description that cannot be understood is an error.

use super::FileDecoder;
use crate::files::read_text;
use roxmltree::{Document, Node, ParsingOptions};
use serde_json::Value;
use std::collections::{BTreeSet, HashMap};
use std::path::Path;
use tiff::tags::Tag;

/// Axes of pages, the one that changes last first: a letter (T, Z, C, or another one of no meaning) and a length.
pub(super) type Axes = Vec<(char, usize)>;

/// Rows, columns and samples of a page.
pub(super) type PageShape = [usize; 3];

/// Place of a frame: the number of a page, and the name of the file of a set that has it, unless it is this one.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Page {
    pub file: Option<String>,
    pub number: usize,
}

#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Described {
    pub axes: Axes,
    /// Page of each place, the last axis running fastest; `None` where the file says that none has been written.
    pub pages: Vec<Option<Page>>,
    pub said: Vec<String>,
}

impl Described {
    /// Pages in file order; the sizes of the axes should multiply to their number.
    pub(super) fn in_order(axes: Axes, pages: usize) -> Self {
        let count = product(&axes);
        let page = |number| (number < pages).then_some(Page { file: None, number });
        // The announced number may be absurd: places beyond twice the pages take no memory.
        Self { axes, pages: (0..count.min(pages.saturating_mul(2))).map(page).collect(), said: Vec::new() }
    }
}

/// Number of places along `axes`, as far as it can be counted.
pub(super) fn product(axes: &[(char, usize)]) -> usize {
    axes.iter().fold(1, |product, (_, length)| product.saturating_mul(*length))
}

/// Axes and pages as the description gives them; `None` if it is silent. `array` names an image. Errors with remedy.
pub(super) fn described(
    description: &str,
    path: &Path,
    (pages, shape): (usize, PageShape),
    array: Option<&str>,
) -> Result<Option<Described>, (String, String)> {
    let text = description.trim_start_matches(['\u{feff}', ' ', '\r', '\n', '\t']);
    let found = if text.starts_with("ImageJ=") {
        of_imagej(text)
    } else if text.starts_with('<') && text.contains("OME") {
        return of_ome(text, path, pages, array);
    } else if text.starts_with('{') {
        of_tifffile(text, shape)
    } else {
        None
    };
    found.map_or(Ok(None), |axes| fitting(axes, pages))
}

/// Pages in file order along `axes`. A length of 0 is as many as the pages need.
pub(super) fn fitting(mut axes: Axes, pages: usize) -> Result<Option<Described>, (String, String)> {
    let known = product(&axes.iter().copied().filter(|(_, length)| *length > 0).collect::<Axes>());
    axes.iter_mut().filter(|(_, length)| *length == 0).for_each(|(_, length)| *length = pages.div_ceil(known));
    // A description of one page is silent about the others, which may have their own.
    if product(&axes) <= 1 {
        return Ok(None);
    }
    if product(&axes) < pages {
        let problem = format!("the description of this file tells of {}, and it has {pages} pages", words(&axes));
        return Err((problem, String::new()));
    }
    Ok(Some(Described::in_order(axes, pages)))
}

/// Axes in words, such as `5 times (T) × 2 channels (C)`.
pub(super) fn words(axes: &Axes) -> String {
    let word = |(axis, length): &(char, usize)| format!("{length} {}", name_of(*axis));
    axes.iter().map(word).collect::<Vec<_>>().join(" × ")
}

fn name_of(axis: char) -> &'static str {
    match axis {
        'T' => "times (T)",
        'Z' => "depths (Z)",
        'C' => "channels (C)",
        _ => "pages without a meaning",
    }
}

fn of_imagej(description: &str) -> Option<Axes> {
    let length = |name: &str| {
        let value = description.lines().find_map(|line| line.strip_prefix(name)?.strip_prefix('='));
        value.and_then(|value| value.trim().parse().ok()).filter(|length| *length > 0)
    };
    // In ImageJ's order of pages channels change first, and times last.
    let lengths = [('T', length("frames")), ('Z', length("slices")), ('C', length("channels"))];
    let is_said = lengths.iter().any(|(_, length)| length.is_some());
    is_said.then(|| lengths.map(|(axis, length)| (axis, length.unwrap_or(1))).to_vec())
}

fn of_tifffile(description: &str, [rows, columns, samples]: PageShape) -> Option<Axes> {
    let record: HashMap<String, Value> = serde_json::from_str(description).ok()?;
    let shape = record.get("shape")?.as_array()?;
    let shape = shape.iter().map(|length| usize::try_from(length.as_u64()?).ok()).collect::<Option<Vec<_>>>()?;
    let named = record.get("axes").and_then(|axes| axes.as_str()).filter(|axes| axes.len() == shape.len());
    Some(match named {
        Some(axes) => axes.chars().zip(shape).filter(|(axis, _)| !"YXS".contains(*axis)).collect(),
        None => {
            // Without names, the end of the shape that fits a page is the page; the axes before have no meaning.
            let of_page = [&[rows, columns, samples][..], &[samples, rows, columns], &[rows, columns]];
            let own = of_page.into_iter().find(|page| shape.ends_with(page)).map_or(2, |page| page.len());
            shape.iter().take(shape.len().saturating_sub(own)).map(|length| ('Q', *length)).collect()
        }
    })
}

/// Images of the description, from which the caller takes one: name and pixels.
type Images<'a> = Vec<(&'a str, Node<'a, 'a>)>;

const MAX_XML_BYTES: u64 = 1 << 28;
/// Largest number of pages of a set of files that is listed.
const MAX_PLANES: usize = 1 << 20;

fn of_ome(text: &str, path: &Path, pages: usize, array: Option<&str>) -> Result<Option<Described>, (String, String)> {
    let wrong = |what: String| (format!("the OME description of this file {what}"), String::new());
    // Against hostile XML: no entities that expand, and a limit on nodes.
    let options = ParsingOptions { allow_dtd: false, nodes_limit: 1 << 22, ..ParsingOptions::default() };
    let document = Document::parse_with_options(text, options);
    let document = document.map_err(|e| wrong(format!("cannot be understood: {e}")))?;
    let root = document.root_element();
    if root.tag_name().name() != "OME" {
        return Ok(None);
    }
    if let Some(elsewhere) = child(root, "BinaryOnly") {
        // Only a file beside this one is read; one that refers to yet another would lead on without end.
        let name = elsewhere.attribute("MetadataFile").unwrap_or_default();
        let beside = Path::new(name).file_name().map(|name| path.with_file_name(name));
        let companion = beside.as_deref().and_then(|beside| read_text(beside, MAX_XML_BYTES).ok());
        return match companion.filter(|text| !text.contains("BinaryOnly")) {
            Some(text) => of_ome(&text, path, pages, array),
            None => Err(wrong(format!("is in the file '{name:.200}', which does not lie beside it or says nothing"))),
        };
    }
    let images: Images<'_> = children(root, "Image")
        .filter_map(|image| {
            let name = image.attribute("Name").or_else(|| image.attribute("ID")).unwrap_or_default();
            child(image, "Pixels").map(|pixels| (name, pixels))
        })
        .collect();
    let chosen = match (array, &images[..]) {
        (_, []) => return Err(wrong("has no pixels".to_owned())),
        (None, [only]) => only,
        (None, all) => {
            let names: Vec<&str> = all.iter().take(8).map(|(name, _)| *name).collect();
            let problem = format!("this file holds {} images, of which one can be the burst", all.len());
            return Err((problem, format!("say with --array its name, or its number from 0 on: {}", names.join(", "))));
        }
        (Some(array), all) => {
            let named = all.iter().find(|(name, _)| *name == array);
            let numbered = || all.get(array.parse::<usize>().ok()?);
            let missing = || (format!("this file has no image '{array}'"), "choose another with --array".to_owned());
            named.or_else(numbered).ok_or_else(missing)?
        }
    };
    let mut found = planes(chosen.1, (path, root.attribute("UUID")), pages).map_err(wrong)?;
    found.said.extend((images.len() > 1).then(|| format!("of {} images '{:.200}' is taken", images.len(), chosen.0)));
    Ok(Some(found))
}

/// Pages of an image. The error goes on a sentence about the description.
fn planes(pixels: Node<'_, '_>, (path, uuid): (&Path, Option<&str>), pages: usize) -> Result<Described, String> {
    let number = |node: Node<'_, '_>, name: &str, usual: Option<usize>| match node.attribute(name) {
        None => usual.ok_or_else(|| format!("has no {name}")),
        Some(text) => text.trim().parse().map_err(|_| format!("says {name}=\"{text:.40}\", which is no number")),
    };
    let order = pixels.attribute("DimensionOrder").and_then(|order| order.strip_prefix("XY"));
    let order = order.filter(|order| order.len() == 3).ok_or("has no DimensionOrder that is one")?;
    let samples = |channel| number(channel, "SamplesPerPixel", Some(1));
    let channels = children(pixels, "Channel").map(samples).collect::<Result<Vec<usize>, _>>()?;
    let mut axes = Axes::new();
    // The order names the fastest axis first; here the slowest comes first.
    for axis in order.chars().rev() {
        let length = number(pixels, &format!("Size{axis}"), None)?;
        // The colours of a page are counted as channels too.
        let colours = channels.iter().sum::<usize>() == length && channels.iter().all(|colours| *colours > 1);
        axes.push((axis, if axis == 'C' && colours { channels.len() } else { length }));
    }
    let count = product(&axes);
    if axes.iter().any(|(_, length)| *length == 0) || count > MAX_PLANES {
        return Err(format!("tells of {}", words(&axes)));
    }
    // Without channels, what is more than the pages are the colours of each.
    if channels.is_empty() && pages > 0 && count > pages && count.is_multiple_of(pages) {
        let colours = count / pages;
        let of_colours = axes.iter_mut().find(|(axis, length)| *axis == 'C' && *length == colours);
        of_colours.into_iter().for_each(|(_, length)| *length = 1);
    }
    let data: Vec<Node<'_, '_>> = children(pixels, "TiffData").collect();
    let mut found = Described { pages: vec![None; product(&axes)], axes, said: Vec::new() };
    if data.is_empty() {
        return Ok(Described::in_order(found.axes, pages));
    }
    for node in data {
        let first = number(node, "IFD", Some(0))?;
        // By OME's rules an element without IFD covers all planes, and one with IFD a single plane.
        let usual = if node.attribute("IFD").is_some() { 1 } else { usize::MAX };
        let most = number(node, "PlaneCount", Some(usual))?;
        let mut place = 0;
        for (axis, length) in &found.axes {
            let at = number(node, &format!("First{axis}"), Some(0))?;
            if at >= *length {
                return Err(format!("has a page at {axis}={at}, and {length} {}", name_of(*axis)));
            }
            place = place * length + at;
        }
        // A foreign UUID under a foreign name points to another file of the set.
        let name = child(node, "UUID").filter(|of| of.text().map(str::trim) != uuid || uuid.is_none());
        let own = path.file_name().map(|name| name.to_string_lossy().into_owned());
        let file =
            name.and_then(|of| of.attribute("FileName")).map(str::to_owned).filter(|name| Some(name) != own.as_ref());
        let is_here = |number: usize| file.is_some() || number < pages;
        for (number, page) in (first..).zip(found.pages.iter_mut().skip(place)).take(most) {
            *page = is_here(number).then(|| Page { file: file.clone(), number });
        }
    }
    let files: BTreeSet<&str> = found.pages.iter().flatten().filter_map(|page| page.file.as_deref()).collect();
    found.said.extend((!files.is_empty()).then(|| format!("the file is one of a set of {}", files.len() + 1)));
    Ok(found)
}

fn children<'a>(node: Node<'a, 'a>, name: &str) -> impl Iterator<Item = Node<'a, 'a>> {
    node.children().filter(move |node| node.is_element() && node.tag_name().name() == name)
}

fn child<'a>(node: Node<'a, 'a>, name: &str) -> Option<Node<'a, 'a>> {
    children(node, name).next()
}

/// Axes of the pages, the one that changes last first; a length of 0 is as many as the pages need. `None` where none of
/// these programs wrote the file, whose first page `decoder` is at and has this `description`.
pub(super) fn of_microscope(decoder: &mut FileDecoder, description: &str) -> Option<Axes> {
    let software = decoder.find_tag(Tag::Software).ok().flatten().and_then(|text| text.into_string().ok());
    let bytes = |decoder: &mut FileDecoder, tag: u16| decoder.find_tag(Tag::Unknown(tag)).ok()??.into_u8_vec().ok();
    // Programs that write one channel a page name each in that page's description.
    let are_channels = ["<PerkinElmer-QPI", "<indica"].iter().any(|of| description.contains(of));
    are_channels
        .then(|| vec![('C', 0)])
        .or_else(|| of_lsm(&bytes(decoder, 34412)?))
        .or_else(|| of_fluoview(&bytes(decoder, 34361)?))
        .or_else(|| of_scanimage(&[software.as_deref().unwrap_or_default(), description]))
}

/// Number of four bytes, in either order: the one that is less than 2¹⁶, as no axis is longer.
fn number(bytes: &[u8], at: usize) -> Option<usize> {
    let bytes: [u8; 4] = bytes.get(at..at + 4)?.try_into().ok()?;
    usize::try_from(u32::from_le_bytes(bytes).min(u32::from_be_bytes(bytes))).ok().filter(|length| *length > 0)
}

/// Times and depths of Zeiss's LSM. Its channels are samples of a pixel.
fn of_lsm(bytes: &[u8]) -> Option<Axes> {
    Some(vec![('T', number(bytes, 24)?), ('Z', number(bytes, 16)?)])
}

/// Dimensions of Olympus's FluoView: ten names of 16 bytes with their lengths, the fastest first.
fn of_fluoview(bytes: &[u8]) -> Option<Axes> {
    const FIRST: usize = 284;
    const LENGTH: usize = 100;
    let axis = |at: usize| {
        let name = String::from_utf8_lossy(bytes.get(at..at + 16)?).to_uppercase();
        let axis = match name.trim_end_matches(['\0', ' ']) {
            "X" | "Y" | "" => return None,
            "T" | "TIME" => 'T',
            "Z" => 'Z',
            "CH" | "WAVELENGTH" => 'C',
            _ => 'Q',
        };
        Some((axis, number(bytes, at + 16)?))
    };
    let axes: Axes = (0..10).rev().filter_map(|index| axis(FIRST + index * LENGTH)).collect();
    (!axes.is_empty()).then_some(axes)
}

/// Channels and depths of ScanImage: lines `name = value` in the `texts`, the names by version. Channels change first;
/// a fast stack has its depths in each time, a slow one its times at each depth.
fn of_scanimage(texts: &[&str]) -> Option<Axes> {
    let value = |names: &[&str]| {
        let lines = texts.iter().flat_map(|text| text.split(['\n', '\r']));
        let mut pairs = lines.filter_map(|line| line.split_once('='));
        // Names of other programs must not pass for ScanImage's.
        let is_named = |name: &str| {
            ["SI.", "scanimage.", "state."].iter().any(|of| name.starts_with(of))
                && names.iter().any(|wanted| name.ends_with(wanted))
        };
        pairs.find_map(|(name, value)| is_named(name.trim()).then(|| value.trim()))
    };
    // A recording without an end has `Inf` frames.
    let length = |names: &[&str]| value(names)?.parse().ok().filter(|length| (1..1 << 16).contains(length));
    let listed = value(&[".channelSave", ".channelsSave"])
        .map(|list| list.split(|c: char| !c.is_ascii_digit()).filter(|number| !number.is_empty()).count().max(1));
    let channels = listed.or_else(|| length(&[".numberOfChannelsSave"]))?;
    let is_on = |on: &str| on == "true" || on == "1";
    let is_fast = value(&[".hFastZ.enable"]).is_some_and(is_on)
        || value(&[".stackMode"]).is_some_and(|mode| mode.contains("fast"));
    let is_stack = is_fast || value(&[".hStackManager.enable"]).is_none_or(is_on);
    // Frames on the way back to the first depth lie between the volumes, and count as depths.
    let of_stack = || length(&[".actualNumSlices", ".hStackManager.numSlices", ".stackNumSlices", ".numberOfZSlices"]);
    let depths = length(&[".numFramesPerVolume"]).filter(|_| is_fast).or_else(of_stack);
    let depths = depths.filter(|_| is_stack).unwrap_or(1);
    let times = length(&[".framesPerSlice", ".acqNumFrames", ".numberOfFrames"]).unwrap_or(0);
    Some(match (depths, is_fast) {
        (1, _) => vec![('T', 0), ('C', channels)],
        (_, true) => vec![('T', 0), ('Z', depths), ('C', channels)],
        (_, false) => vec![('Z', depths), ('T', times), ('C', channels)],
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn versions_of_scanimage_say_channels_and_depths_in_their_own_words() {
        for (text, expected) in [
            ("SI.hChannels.channelSave = 1\nSI.hStackManager.enable = false", Some(vec![('T', 0), ('C', 1)])),
            (
                "SI.hChannels.channelSave = [1;2]\nSI.hStackManager.numSlices = 30\nSI.hStackManager.enable = 0",
                Some(vec![('T', 0), ('C', 2)]),
            ),
            (
                "SI.hChannels.channelSave = [1 3]\nSI.hStackManager.enable = true\nSI.hStackManager.numSlices = 5\n\
              SI.hStackManager.stackMode = 'slow'\nSI.hStackManager.framesPerSlice = 4",
                Some(vec![('Z', 5), ('T', 4), ('C', 2)]),
            ),
            (
                "SI.hChannels.channelSave = [1;2;4]\nSI.hFastZ.enable = 1\nSI.hFastZ.numFramesPerVolume = 6",
                Some(vec![('T', 0), ('Z', 6), ('C', 3)]),
            ),
            ("scanimage.SI5.channelsSave = [1;2]\nscanimage.SI5.stackNumSlices = 1", Some(vec![('T', 0), ('C', 2)])),
            ("state.acq.numberOfChannelsSave=2\rstate.acq.numberOfZSlices=1", Some(vec![('T', 0), ('C', 2)])),
            ("my.channelSave = [1;2]", None),
            ("", None),
        ] {
            assert_eq!(of_scanimage(&["", text]), expected, "{text}");
        }
    }
}
