//! Axes of pages that programs of microscopes say in tags and words of their own: depths and channels are not time.

use super::FileDecoder;
use super::described::Axes;
use tiff::tags::Tag;

/// Axes of the pages, the one that changes last first; a length of 0 is as many as the pages need. `None` where none of
/// these programs wrote the file, whose first page `decoder` is at and has this `description`.
pub(super) fn axes(decoder: &mut FileDecoder, description: &str) -> Option<Axes> {
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
    let count = |names: &[&str]| value(names)?.parse::<f64>().ok().filter(|x| (1.0..65536.0).contains(x));
    let length = |names: &[&str]| count(names).map(|count| count as usize);
    let listed = value(&[".channelSave", ".channelsSave"])
        .map(|list| list.split(|c: char| !c.is_ascii_digit()).filter(|number| !number.is_empty()).count().max(1));
    let channels = listed.or_else(|| length(&[".numberOfChannelsSave"]))?;
    let is_fast = value(&[".hFastZ.enable"]).is_some_and(|on| on == "true" || on == "1")
        || value(&[".stackMode"]).is_some_and(|mode| mode.contains("fast"));
    let is_stack = is_fast || value(&[".hStackManager.enable"]).is_none_or(|on| on == "true" || on == "1");
    // What a flight back records is no depth, but lies between the volumes.
    let of_volume = if is_fast { length(&[".numFramesPerVolume"]) } else { None };
    let depths = of_volume
        .or_else(|| length(&[".actualNumSlices", ".hStackManager.numSlices", ".stackNumSlices", ".numberOfZSlices"]));
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
