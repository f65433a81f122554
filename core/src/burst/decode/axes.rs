//! Axes of the pages of a TIFF, as its description tells them (ImageJ, OME, tifffile), and the pages that are frames.
//!
//! Frames follow one another in time. Channels and depths are never taken for time: a file that has more than time is
//! refused until the user says which axis is that of the frames.

use crate::burst::layout::{Axis, AxisChoice};
use std::collections::HashMap;

/// Axes of pages, the one that changes last first: a letter (T, Z, C, or another one of no meaning) and a length.
type Axes = Vec<(char, usize)>;

/// Axes of `pages` pages with this description; `None` where it tells none, or others than the pages have.
fn axes_of(description: &str, pages: usize) -> Option<Axes> {
    let axes = if description.starts_with("ImageJ=") {
        of_imagej(description)
    } else if description.contains("<OME") {
        of_ome(description, pages)?
    } else if description.starts_with('{') {
        of_tifffile(description)?
    } else {
        return None;
    };
    let count = axes.iter().fold(1usize, |product, (_, length)| product.saturating_mul(*length));
    (count == pages).then_some(axes)
}

fn of_imagej(description: &str) -> Axes {
    let length = |name: &str| {
        let value = description.lines().find_map(|line| line.strip_prefix(name)?.strip_prefix('='));
        value.and_then(|value| value.trim().parse().ok()).unwrap_or(1)
    };
    vec![('T', length("frames")), ('Z', length("slices")), ('C', length("channels"))]
}

fn of_ome(description: &str, pages: usize) -> Option<Axes> {
    let element = description.split_once("<Pixels")?.1.split('>').next()?;
    let attribute = |name: &str| {
        let text = element.split_once(&format!(" {name}=\""))?.1;
        text.split('"').next()
    };
    let order = attribute("DimensionOrder")?.strip_prefix("XY")?;
    let length = |axis: char| attribute(&format!("Size{axis}")).and_then(|text| text.parse::<usize>().ok());
    let mut axes = order.chars().rev().map(|axis| Some((axis, length(axis)?))).collect::<Option<Axes>>()?;
    let count = axes.iter().fold(1usize, |product, (_, length)| product.saturating_mul(*length));
    // The colours of a page are counted as channels too.
    let colours = if pages > 0 && count.is_multiple_of(pages) { count / pages } else { 1 };
    for (_, length) in axes.iter_mut().filter(|(axis, length)| *axis == 'C' && length.is_multiple_of(colours)) {
        *length /= colours;
    }
    Some(axes)
}

fn of_tifffile(description: &str) -> Option<Axes> {
    let record: HashMap<String, serde_json::Value> = serde_json::from_str(description).ok()?;
    let shape = record.get("shape")?.as_array()?;
    let shape = shape.iter().map(|length| usize::try_from(length.as_u64()?).ok()).collect::<Option<Vec<_>>>()?;
    let named = record.get("axes").and_then(|axes| axes.as_str()).filter(|axes| axes.len() == shape.len());
    Some(match named {
        Some(axes) => axes.chars().zip(shape).filter(|(axis, _)| !"YXS".contains(*axis)).collect(),
        // Rows and columns are the last two, and colours may follow.
        None => shape.iter().take(shape.len().saturating_sub(2)).map(|length| ('Q', *length)).collect(),
    })
}

/// Indices of those of `pages` pages that are frames, and a word about what was chosen. The error has a problem and a
/// remedy.
pub(super) fn frames_of(
    description: Option<&str>,
    pages: usize,
    choice: Option<&AxisChoice>,
) -> Result<(Vec<usize>, Option<String>), (String, String)> {
    let axes = description.and_then(|text| axes_of(text, pages));
    let mut axes: Axes =
        axes.unwrap_or_else(|| vec![('T', pages)]).into_iter().filter(|(_, length)| *length > 1).collect();
    if axes.is_empty() {
        axes.push(('T', pages));
    }
    let words: Vec<String> = axes.iter().map(|(axis, length)| format!("{length} {}", name_of(*axis))).collect();
    let words = words.join(" × ");
    let Some(choice) = choice else {
        if axes.len() == 1 && !matches!(axes[0].0, 'Z' | 'C') {
            return Ok(((0..pages).collect(), None));
        }
        let example = axes.iter().find(|(axis, _)| *axis == 'T').unwrap_or(&axes[0]).0;
        let other = axes.iter().find(|(axis, _)| *axis != example && "TZC".contains(*axis));
        let others = other.map_or(String::new(), |(axis, _)| {
            format!(", with {axis}=1 for another place on {axis}: --axis {example},{axis}=1")
        });
        let word = if "TZC".contains(example) { example.to_string() } else { "first".to_owned() };
        return Err((
            format!("the pages of this file are {words}, of which only time makes frames"),
            format!("say which axis is that of the frames: --axis {word}{others}"),
        ));
    };
    let letter = |axis: Axis| match axis {
        Axis::First => axes[0].0,
        Axis::Last => axes[axes.len() - 1].0,
        named => named.name().chars().next().unwrap_or('T'),
    };
    let missing = |axis: char| {
        (
            format!("the pages of this file are {words}, and {axis} is none of these axes"),
            "choose another with --axis".to_owned(),
        )
    };
    let find = |letter: char| axes.iter().position(|(axis, _)| *axis == letter).ok_or_else(|| missing(letter));
    let along = match choice.along {
        Axis::First => 0,
        Axis::Last => axes.len() - 1,
        named => find(letter(named))?,
    };
    let mut at = vec![0; axes.len()];
    for (axis, place) in &choice.at {
        let index = find(letter(*axis))?;
        let length = axes[index].1;
        if index == along || *place >= length {
            let problem = format!("--axis names place {place} on {}, which has {length}", axis.name());
            return Err((problem, "places begin at 0, and the axis of the frames has none".to_owned()));
        }
        at[index] = *place;
    }
    let page = |t: usize| {
        axes.iter()
            .enumerate()
            .fold(0, |page, (index, (_, length))| page * length + if index == along { t } else { at[index] })
    };
    let chosen = (0..axes[along].1).map(page).collect();
    let others = axes.iter().enumerate().filter(|(index, _)| *index != along);
    let others: Vec<String> = others.map(|(index, (axis, _))| format!("{axis}={}", at[index])).collect();
    let taken = if others.is_empty() { String::new() } else { format!(" at {}", others.join(", ")) };
    Ok((chosen, Some(format!("of pages of {words} those along {} are taken{taken}", axes[along].0))))
}

fn name_of(axis: char) -> String {
    match axis {
        'T' => "times (T)".to_owned(),
        'Z' => "depths (Z)".to_owned(),
        'C' => "channels (C)".to_owned(),
        _ => "pages without a meaning".to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn chosen(description: &str, pages: usize, axis: &str) -> Result<Vec<usize>, String> {
        let axis = (!axis.is_empty()).then(|| axis.parse::<AxisChoice>().expect("an axis"));
        frames_of(Some(description), pages, axis.as_ref()).map(|found| found.0).map_err(|(problem, _)| problem)
    }

    #[test]
    fn time_is_time_and_other_axes_are_chosen() {
        let imagej = "ImageJ=1.11a\nimages=6\nchannels=3\nframes=2\nhyperstack=true\n";
        let ome = "<?xml version=\"1.0\"?><OME><Image><Pixels ID=\"P\" DimensionOrder=\"XYCZT\" SizeX=\"4\" SizeY=\"4\" SizeC=\"3\" SizeZ=\"1\" SizeT=\"2\">";
        let tifffile = "{\"shape\": [2, 3, 4, 4], \"axes\": \"TCYX\"}";
        for description in [imagej, ome, tifffile] {
            assert!(
                chosen(description, 6, "").is_err_and(|p| p.contains("2 times (T) × 3 channels (C)")),
                "{description}"
            );
            assert_eq!(chosen(description, 6, "T"), Ok(vec![0, 3]));
            assert_eq!(chosen(description, 6, "T,C=2"), Ok(vec![2, 5]));
            assert_eq!(chosen(description, 6, "C,T=1"), Ok(vec![3, 4, 5]));
            assert!(chosen(description, 6, "Z").is_err() && chosen(description, 6, "T,C=3").is_err());
        }
        assert_eq!(chosen("{\"shape\": [6, 4, 4]}", 6, ""), Ok((0..6).collect()));
        assert_eq!(chosen("{\"shape\": [6, 4, 4], \"axes\": \"TYX\"}", 6, ""), Ok((0..6).collect()));
        assert!(chosen("{\"shape\": [2, 3, 4, 4]}", 6, "").is_err());
        assert_eq!(chosen("{\"shape\": [2, 3, 4, 4]}", 6, "first"), Ok(vec![0, 3]));
        assert!(chosen("ImageJ=1.11a\nimages=6\nslices=6\n", 6, "").is_err_and(|p| p.contains("6 depths")));
        // In OME, the colours of a page are channels.
        let colours = ome.replace("SizeC=\"3\" SizeZ=\"1\" SizeT=\"2\"", "SizeC=\"3\" SizeZ=\"1\" SizeT=\"6\"");
        assert_eq!(chosen(&colours, 6, ""), Ok((0..6).collect()));
        for plain in ["", "words", "{", "{\"shape\": 3}", "<OME><Pixels", "ImageJ=1.11a\nimages=7\nframes=7\n"] {
            assert_eq!(chosen(plain, 6, ""), Ok((0..6).collect()), "{plain}");
        }
    }
}
