//! Pages of a TIFF that are frames. Frames follow one another in time; channels and depths are never taken for time: a
//! file that has more than time, or whose description does not fit its pages, is refused until the user says which
//! axis is that of the frames. `--axis first` takes all pages in their order where the description is of no use.

use super::described::{Axes, Described, Page, product, words};
use crate::burst::layout::{Axis, AxisChoice};

/// Pages that are frames, in their order, and words about what was chosen.
#[derive(Debug, PartialEq)]
pub(super) struct Chosen {
    pub pages: Vec<Page>,
    pub said: Vec<String>,
}

pub(super) type Refusal = (String, String);

pub(super) fn frames_of(
    described: Result<Option<Described>, Refusal>,
    pages: usize,
    choice: Option<&AxisChoice>,
) -> Result<Chosen, Refusal> {
    let all =
        |said: Vec<String>| Ok(Chosen { pages: (0..pages).map(|number| Page { file: None, number }).collect(), said });
    let is_first = choice.is_some_and(|choice| choice.along == Axis::First && choice.at.is_empty());
    let found = match described {
        Ok(Some(found)) => found,
        // Without a description pages are frames, and there is no axis to choose.
        Ok(None) if pages == 1 => return all(Vec::new()),
        Ok(None) => match choice {
            Some(choice) if !matches!(choice.along, Axis::T | Axis::First | Axis::Last) || !choice.at.is_empty() => {
                return Err((
                    format!("this file says nothing of axes of its {pages} pages"),
                    "leave --axis out, or take them in their order with --axis first".to_owned(),
                ));
            }
            _ => return all(Vec::new()),
        },
        // The user's choice overrides a description that does not fit.
        Err(_) if is_first => {
            return all(vec!["all pages are taken in their order, whatever the description says".to_owned()]);
        }
        Err((problem, remedy)) => {
            let way = format!("--axis first takes all {pages} pages in their order");
            return Err((problem, if remedy.is_empty() { way } else { format!("{remedy}; {way}") }));
        }
    };
    Along::of(&found, choice)?.taken(&found)
}

struct Along {
    along: usize,
    at: Vec<usize>,
}

impl Along {
    fn of(found: &Described, choice: Option<&AxisChoice>) -> Result<Self, Refusal> {
        let axes = &found.axes;
        // An axis of length 1 leaves nothing to choose.
        let long: Vec<usize> = (0..axes.len()).filter(|index| axes[*index].1 > 1).collect();
        let named: Axes = long.iter().map(|index| axes[*index]).collect();
        let at = vec![0; axes.len()];
        let usual = long.first().copied().unwrap_or(0);
        let Some(choice) = choice else {
            // One long axis is time unless it is named depth or channel; of several the user has to choose.
            if named.len() < 2 && !named.first().is_some_and(|(axis, _)| matches!(axis, 'Z' | 'C')) {
                return Ok(Self { along: usual, at });
            }
            let example = named.iter().find(|(axis, _)| *axis == 'T').unwrap_or(&named[0]).0;
            let other = named.iter().find(|(axis, _)| *axis != example && "TZC".contains(*axis));
            let others = other.map_or(String::new(), |(axis, _)| {
                format!(", with {axis}=1 for another place on {axis}: --axis {example},{axis}=1")
            });
            let word = if "TZC".contains(example) { example.to_string() } else { "first".to_owned() };
            let written = found.pages.iter().flatten().count();
            let is_whole = written == product(&found.axes);
            let written = if is_whole { String::new() } else { format!(" ({written} pages are written)") };
            return Err((
                format!("the pages of this file are {}{written}, of which only time makes frames", words(&named)),
                format!("say along which axis the frames lie: --axis {word}{others}"),
            ));
        };
        let find = |letter: char| {
            let missing = || {
                let problem = format!("the pages of this file are {}, and {letter} is not among them", words(&named));
                (problem, "choose another with --axis".to_owned())
            };
            axes.iter()
                .position(|(axis, length)| *axis == letter && (*length > 1 || axes.len() == 1))
                .ok_or_else(missing)
        };
        let letter = |axis: Axis| axis.name().chars().next().unwrap_or('T');
        let along = match choice.along {
            Axis::First => usual,
            Axis::Last => long.last().copied().unwrap_or(0),
            Axis::T if named.is_empty() => usual,
            axis => find(letter(axis))?,
        };
        let mut chosen = Self { along, at };
        for (axis, place) in &choice.at {
            let index = find(letter(*axis))?;
            let length = axes[index].1;
            if index == along || *place >= length {
                let problem = format!("--axis names place {place} on {}, which has {length}", axis.name());
                return Err((problem, "places begin at 0, and the axis of the frames has none".to_owned()));
            }
            chosen.at[index] = *place;
        }
        Ok(chosen)
    }

    fn taken(&self, found: &Described) -> Result<Chosen, Refusal> {
        let (Self { along, at }, axes) = (self, &found.axes);
        let (letter, announced) = axes[*along];
        let step = product(&axes[along + 1..]);
        let of_all = |place: usize| place / step % announced;
        let others = (0..axes.len()).filter(|index| index != along);
        let start: usize = others.map(|index| product(&axes[index + 1..]) * at[index]).sum();
        // A stopped recording ends within a time, which counts only if whole. Along other axes only taken places count.
        let is_first = axes[..*along].iter().all(|(_, length)| *length == 1);
        let chosen = |place: usize| {
            is_first || place >= start && (place - start).is_multiple_of(step) && (place - start) / step < announced
        };
        let full = if is_first { product(axes) / announced.max(1) } else { 1 };
        let mut counts = vec![0; announced.min(found.pages.len())];
        for (place, _) in found.pages.iter().enumerate().filter(|(place, page)| page.is_some() && chosen(*place)) {
            counts[of_all(place)] += 1;
        }
        let whole = counts.iter().take_while(|count| **count == full).count();
        // A stopped recording lacks pages at its end alone; a hole before other pages is an error.
        if whole == 0 || counts[whole..].iter().skip(1).any(|count| *count > 0) {
            let problem = format!(
                "this file announces {}, and pages of it are missing from {letter}={whole} on, with others behind them",
                words(axes)
            );
            return Err((problem, "--axis first takes all pages in their order".to_owned()));
        }
        let pages = (0..whole).filter_map(|t| found.pages[start + t * step].clone()).collect();
        let others = axes.iter().enumerate().filter(|(index, (_, length))| index != along && *length > 1);
        let others: Vec<String> = others.map(|(index, (axis, _))| format!("{axis}={}", at[index])).collect();
        let mut said = found.said.clone();
        if !others.is_empty() {
            let long: Axes = axes.iter().copied().filter(|(_, length)| *length > 1).collect();
            said.push(format!("of pages of {} those along {letter} are taken at {}", words(&long), others.join(", ")));
        }
        if whole < announced {
            said.push(format!(
                "the description announces {announced} along {letter}, of which {whole} are written whole"
            ));
        }
        Ok(Chosen { pages, said })
    }
}
