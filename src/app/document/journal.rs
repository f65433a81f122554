//! Actions of the user as a text, a line for each. It is a report of what went wrong, a demonstration and a test, for
//! it can be read and done again.
//!
//! Actions that leave the document as it is (what is pointed at, dialogs, copies, written files) are not taken down.
//! Files that were read are there with their content, bursts with their paths.

use super::Action;
use crate::app::actions::registry::ActionId;
use crate::files::{explained, written_by};
use serde::{Deserialize, Serialize};
use std::collections::VecDeque;
use std::fmt::Write;
use std::mem::discriminant;

const VERSION: u32 = 1;

/// The oldest are forgotten beyond these.
pub const MAX_STEPS: usize = 3000;

/// Steps that a saved session has.
pub const LAST_STEPS: usize = 100;

/// Steps to undo, or parts of no step: each a list of actions; a drag has many.
pub type Steps = VecDeque<Vec<Action>>;

#[derive(Debug, Default)]
pub struct Journal {
    steps: Steps,
    left_out: usize,
    /// Whether the last step goes on.
    is_open: bool,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Written {
    version: u32,
    #[serde(default)]
    left_out: usize,
    did: Steps,
}

/// Steps that are done again, an action a pass.
#[derive(Debug, Default)]
pub struct Playback {
    pub steps: Steps,
    pub goes_on: bool,
}

impl Playback {
    /// The next action. A step begins when all that was wanted before it is there: then `rests`.
    pub fn next(&mut self, rests: bool) -> Option<Action> {
        if !self.goes_on && !rests {
            return None;
        }
        let step = self.steps.front_mut()?;
        let action = (!step.is_empty()).then(|| step.remove(0));
        self.goes_on = !step.is_empty();
        if !self.goes_on {
            self.steps.pop_front();
        }
        action
    }
}

impl Journal {
    /// A lesson has a project of its own, of which nothing is left: what is done `in_lesson` is not taken down.
    pub fn take(&mut self, action: &Action, in_lesson: bool) {
        if in_lesson || !is_taken_down(action) {
            return;
        }
        let action = action.clone().with_absolute_paths();
        match self.steps.back_mut().filter(|_| self.is_open) {
            Some(step) => {
                if step.last().is_some_and(|last| replaces(&action, last)) {
                    step.pop();
                }
                step.push(action);
            }
            None => self.steps.push_back(vec![action]),
        }
        self.is_open = true;
        if self.steps.len() > MAX_STEPS {
            self.steps.pop_front();
            self.left_out += 1;
        }
    }

    /// Ends a pass. The step ends with it, unless it `goes_on`.
    pub fn close(&mut self, goes_on: bool) {
        self.is_open &= goes_on;
    }

    pub fn to_toml(&self) -> String {
        let how = "# What was done, a line for each action. To do it again without a display:\n\
                   # burstscope render --play THIS_FILE --out picture.png\n";
        let Self { steps, left_out, .. } = self;
        format!("{}{how}version = {VERSION}\nleft_out = {left_out}\n{}", written_by(), listed(steps.iter()))
    }

    /// The last steps, as lines of a session. A session that was restored is there without its own.
    pub fn last_lines(&self) -> String {
        let mut last: Steps = self.steps.iter().rev().take(LAST_STEPS).rev().cloned().collect();
        for action in last.iter_mut().flatten() {
            if let Action::Restore(session) = action {
                session.did.clear();
            }
        }
        if last.is_empty() { String::new() } else { listed(last.iter()) }
    }
}

fn listed<'a>(steps: impl Iterator<Item = &'a Vec<Action>>) -> String {
    let mut text = "did = [\n".to_owned();
    for step in steps {
        let lines: Vec<String> = step.iter().map(line).collect();
        let _ = writeln!(text, "  [{}],", lines.join(",\n   "));
    }
    text + "]\n"
}

fn line(action: &Action) -> String {
    let mut text = String::new();
    match serde::Serialize::serialize(action, toml::ser::ValueSerializer::new(&mut text)) {
        Ok(_) => text,
        // TOML has no numbers beyond those of 64 bits with a sign, and a seed may be one.
        Err(error) => format!("# left out, because it cannot be written ({error})\n   "),
    }
}

/// Reads steps to do again.
///
/// # Errors
/// The first fault of the text, with its line.
pub fn read_steps(text: &str) -> Result<Steps, String> {
    let wrong = |error: &str| explained(text, &format!("this is not a list of what was done: {error}"));
    let written: Written = toml::from_str(text).map_err(|error| wrong(&nearest(error.to_string().trim_end())))?;
    if written.version != VERSION {
        let version = written.version;
        return Err(wrong(&format!(
            "its version is {version}, this program reads {VERSION}; give version = {VERSION}"
        )));
    }
    for action in written.did.iter().flatten() {
        if let Action::Restore(session) = action {
            session.check().map_err(|error| wrong(&format!("restore: {error}")))?;
        }
    }
    Ok(written.did)
}

/// An error of the reader that lists all the names there are, with those alone that begin like the unknown one.
fn nearest(error: &str) -> String {
    let Some((unknown, names)) = error.split_once(", expected one of ") else { return error.to_owned() };
    let word = unknown.rsplit('`').nth(1).unwrap_or_default();
    let alike = |name: &&str| word.bytes().zip(name.bytes()).take_while(|(a, b)| a == b).count();
    let mut names: Vec<&str> = names.split(", ").collect();
    names.sort_by_key(|name| std::cmp::Reverse(alike(&name.trim_matches('`'))));
    names.truncate(5);
    format!("{unknown}; the nearest names are {}", names.join(", "))
}

fn is_taken_down(action: &Action) -> bool {
    use ActionId as A;
    match action {
        Action::Point(_) | Action::Stage(_) | Action::Note(_) | Action::DismissMessage(_) => false,
        // A picture that comes into a fitted view is fitted without an action.
        Action::MoveView { before, after, .. } => before != after && !(before.is_fit() && after.is_fit()),
        // The place that is probed is taken down.
        Action::Do(
            A::ProbePlace | A::Quit | A::CopyRow | A::CopyCommand | A::CopyPicture | A::CopyActions | A::LeaveLesson,
        ) => false,
        Action::Do(id) => !id.action().label.ends_with('…'),
        _ => true,
    }
}

/// Whether `action` makes the one before it in the same step needless: of a drag, the value at its end is enough.
fn replaces(action: &Action, before: &Action) -> bool {
    use Action as A;
    match (action, before) {
        (A::Change(of), A::Change(last)) => of.iter().map(|one| one.parameter).eq(last.iter().map(|one| one.parameter)),
        (A::SetDisplay(of, _), A::SetDisplay(last, _)) => of == last,
        (A::NameKept(of, _), A::NameKept(last, _)) | (A::NamePlace(of, _), A::NamePlace(last, _)) => of == last,
        _ => action.sets_field() && discriminant(action) == discriminant(before),
    }
}
