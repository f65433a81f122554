//! Number formats of explanations.

use crate::detector::Slope;

/// `text` with a capital at its start.
pub fn capitalised(text: &str) -> String {
    let mut chars = text.chars();
    chars.next().map_or_else(String::new, |first| first.to_uppercase().chain(chars).collect())
}

/// A count as text, with a space between groups of three digits: 12345678 becomes "12 345 678".
pub fn grouped(number: u64) -> String {
    let digits = number.to_string();
    let mut text = String::with_capacity(digits.len() * 4 / 3);
    for (k, digit) in digits.chars().enumerate() {
        if k > 0 && (digits.len() - k).is_multiple_of(3) {
            text.push(' ');
        }
        text.push(digit);
    }
    text
}

/// A slope in px/frame as short text: one number where it is horizontal, two otherwise.
pub fn slope_text(slope: Slope) -> String {
    if slope.v == 0.0 { number(slope.u, 2) } else { format!("({}, {})", number(slope.u, 2), number(slope.v, 2)) }
}

/// A number as text with at most `digits` decimals and no trailing zeros.
pub fn number(x: f32, digits: usize) -> String {
    let text = format!("{x:.digits$}");
    let short = if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
    if short == "-0" { "0".to_owned() } else { short.replace('-', "−") }
}

/// A number as short text, for any magnitude.
pub fn value_text(x: f64) -> String {
    match x.abs() {
        a if !a.is_finite() => "∞".to_owned(),
        a if a >= 1000.0 => number(x as f32, 0),
        a if a >= 0.01 || a == 0.0 => number(x as f32, 2),
        _ => format!("{x:.1e}").replace('-', "−"),
    }
}

/// A ratio to the noise as short text: with one decimal, ∞ without noise.
pub fn snr_text(snr: f32) -> String {
    if snr.is_finite() { number(snr, 1) } else { "∞".to_owned() }
}

/// `template` with what `word` gives for each name in braces.
pub(crate) fn filled(template: &str, word: impl Fn(&str) -> String) -> String {
    let mut parts = template.split('{');
    let start = parts.next().unwrap_or_default().to_owned();
    parts.fold(start, |text, part| match part.split_once('}') {
        Some((name, rest)) => text + &word(name) + rest,
        None => text + part,
    })
}

/// A sentence: `clause` with a capital at its start and a full stop at its end.
pub fn sentence(clause: &str) -> String {
    capitalised(clause) + "."
}

/// The largest number with `significant` digits that is at most `x`; 0 where `x` is not above 0.
pub fn rounded_down(x: f64, significant: i32) -> f64 {
    rounded(x, significant, f64::floor)
}

/// The smallest number with `significant` digits that is at least `x`.
pub fn rounded_up(x: f64, significant: i32) -> f64 {
    rounded(x, significant, f64::ceil)
}

fn rounded(x: f64, significant: i32, round: fn(f64) -> f64) -> f64 {
    if x <= 0.0 || !x.is_finite() {
        return 0.0;
    }
    let digits = significant - 1 - x.log10().floor() as i32;
    // Through text, so that 0.0031 is not 0.0031000000000000003.
    let power = 10f64.powi(digits);
    let value = round(x * power) / power;
    format!("{value:.*}", digits.max(0) as usize).parse().unwrap_or(value)
}

/// A count with its noun: “1 feature”, “2 features”, “2 matches”.
pub fn counted(count: usize, what: &str) -> String {
    let grouped = grouped(count as u64);
    let ending = if what.ends_with("ch") { "es" } else { "s" };
    if count == 1 { format!("1 {what}") } else { format!("{grouped} {what}{ending}") }
}

/// Some of these names, and how many more there are: “a, b, c and 2 more”.
pub fn some_of<S: AsRef<str>>(names: &[S]) -> String {
    const NAMED: usize = 3;
    let some: Vec<&str> = names.iter().take(NAMED).map(S::as_ref).collect();
    let more = names.len() - some.len();
    some.join(", ") + &if more == 0 { String::new() } else { format!(" and {more} more") }
}
