//! What the user did, as a text: one line for each action. It is a report of what went wrong, a demonstration and a
//! test, for it can be read and done again.
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
const MAX_STEPS: usize = 3000;

/// Longest file of steps that is read.
pub const MAX_STEPS_BYTES: u64 = 64 << 20;

/// Steps that a saved session has.
const LAST_STEPS: usize = 100;

/// Steps to undo, or parts of none: each a list of actions, of which a drag has many.
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
    steps: Steps,
    goes_on: bool,
}

impl Playback {
    pub fn new(steps: Steps) -> Self {
        Self { steps, goes_on: false }
    }

    pub fn is_over(&self) -> bool {
        self.steps.is_empty()
    }

    /// Whether the step of the last action goes on.
    pub fn goes_on(&self) -> bool {
        self.goes_on
    }

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
    pub fn take(&mut self, action: &Action) {
        if !is_taken_down(action) {
            return;
        }
        match self.steps.back_mut().filter(|_| self.is_open) {
            Some(step) => {
                if step.last().is_some_and(|last| replaces(action, last)) {
                    step.pop();
                }
                step.push(action.clone());
            }
            None => self.steps.push_back(vec![action.clone()]),
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

    pub fn len(&self) -> usize {
        self.steps.iter().map(Vec::len).sum()
    }

    pub fn to_toml(&self) -> String {
        let how = "# What was done, a line for each action. To do it again without a display:\n\
                   # burstscope render --play THIS_FILE --out picture.png\n";
        let left_out = if self.left_out > 0 { format!("left_out = {}\n", self.left_out) } else { String::new() };
        format!("{}{how}version = {VERSION}\n{left_out}{}", written_by(), listed(self.steps.iter()))
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
/// What is wrong, with its line.
pub fn read_steps(text: &str) -> Result<Steps, String> {
    let wrong = |error: &str| explained(text, &format!("this is not a list of what was done: {error}"));
    let written: Written = toml::from_str(text).map_err(|error| wrong(error.to_string().trim_end()))?;
    if written.version != VERSION {
        let version = written.version;
        let problem = format!("its version is {version}, this program reads {VERSION}; give version = {VERSION}");
        return Err(wrong(&problem));
    }
    let sessions = written.did.iter().flatten().filter_map(|action| match action {
        Action::Restore(session) => Some(session),
        _ => None,
    });
    for session in sessions {
        session.check().map_err(|error| wrong(&format!("restore: {error}")))?;
    }
    Ok(written.did)
}

fn is_taken_down(action: &Action) -> bool {
    use ActionId as A;
    match action {
        Action::Point(_) | Action::Note(_) | Action::DismissMessage(_) => false,
        Action::MoveView { before, after, .. } => before != after,
        // Its place is taken down.
        Action::Do(A::ProbePlace) => false,
        Action::Do(A::Quit | A::CopyRow | A::CopyCommand | A::CopyPicture | A::CopyActions | A::LeaveLesson) => false,
        Action::Do(id) => !id.action().label.ends_with('…'),
        _ => true,
    }
}

/// Whether `action` makes the one before it in the same step needless: of a drag, the value at its end is enough.
fn replaces(action: &Action, before: &Action) -> bool {
    use Action as A;
    let sets_all = matches!(
        action,
        A::SetSearch(_)
            | A::SetMatching(_)
            | A::SetFilter(_)
            | A::SetSetUp(_)
            | A::SetLab(_)
            | A::SetMeasure(_)
            | A::SetFigure(_)
            | A::SetFilm(_)
            | A::SetMatchLook(_)
            | A::MoveCameras(_)
    );
    let sets_one = match (action, before) {
        (A::SetDisplay(of, _), A::SetDisplay(last, _)) => of == last,
        (A::NameKept(of, _), A::NameKept(last, _)) => of == last,
        _ => false,
    };
    (sets_all && discriminant(action) == discriminant(before)) || sets_one
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::pane::PaneId;
    use crate::detector::{SearchParams, Slope};

    fn taken(passes: &[(Action, bool)]) -> Journal {
        let mut journal = Journal::default();
        for (action, goes_on) in passes {
            journal.take(action);
            journal.close(*goes_on);
        }
        journal
    }

    fn search(levels: u32) -> Action {
        let mut params = SearchParams::default();
        params.detector.levels = levels;
        Action::SetSearch(Box::new(params))
    }

    #[test]
    fn a_drag_is_one_step_that_keeps_its_last_value() {
        let slope = |u| Action::SetSlope(PaneId(1), Slope::new(u, 0.0));
        let journal = taken(&[
            (search(3), true),
            (search(4), true),
            (search(5), false),
            (search(6), false),
            (slope(1.0), true),
            (slope(1.5), false),
            (Action::Note("seen".into()), false),
            (ActionId::SaveSession.into(), false),
        ]);
        let steps = [vec![search(5)], vec![search(6)], vec![slope(1.0), slope(1.5)]];
        assert_eq!(journal.steps, steps);
        assert_eq!(read_steps(&journal.to_toml()), Ok(Steps::from(steps)), "{}", journal.to_toml());
    }

    #[test]
    fn of_very_many_the_last_are_kept_and_it_is_said() {
        let journal = taken(&vec![(ActionId::ZoomIn.into(), false); MAX_STEPS + 3]);
        let text = journal.to_toml();
        assert!(text.contains("left_out = 3\n"), "{}", &text[..300]);
        assert_eq!(read_steps(&text).map(|steps| steps.len()), Ok(MAX_STEPS));
        assert_eq!(journal.last_lines().matches("zoom_in").count(), LAST_STEPS);
    }

    #[test]
    fn mistakes_are_named_with_their_lines() {
        let wrong = |did: &str| read_steps(&format!("version = 1\ndid = [\n  [{did}],\n]\n")).expect_err(did);
        for (did, words) in [
            ("{ set_slop = [0, 1] }", vec!["line 3", "set_slop", "set_slope"]),
            ("{ do = \"zoom\" }", vec!["line 3", "zoom_in"]),
            ("{ set_frame = [0, \"last\"] }", vec!["line 3", "string \"last\"", "usize"]),
            ("{ select = [1] }", vec!["line 3", "none"]),
        ] {
            let error = wrong(did);
            assert!(words.iter().all(|word| error.contains(word)), "{words:?}: {error}");
        }
        let other = read_steps("version = 9\ndid = []").expect_err("another version");
        assert!(other.contains("version is 9") && other.contains("version = 1"), "{other}");
    }
}
