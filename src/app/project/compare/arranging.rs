//! The panes of *Methods*: at first one for each method that is compared.

use crate::app::pane::MethodsPreset;
use crate::app::project::Model;
use crate::app::project::side::Side;
use crate::app::project::workspace::Workspace;

impl Model {
    /// Updates the panes on the screen for the open workspace, and in *Methods* for the methods that are compared:
    /// methods that were switched on get a pane, those that were switched off lose theirs. The rest of the arrangement
    /// stays.
    pub fn refresh_workspace(&mut self) {
        self.panes.turn_to(self.workspace);
        if self.workspace != Workspace::Methods || self.slots.a.burst.is_none() {
            return;
        }
        let now = self.contenders();
        if now == self.compare.arranged {
            return;
        }
        let before = std::mem::replace(&mut self.compare.arranged, now.clone());
        let shown = self.panes.shown();
        let has_pane =
            |method| shown.iter().filter_map(|id| self.panes.get(*id)).any(|pane| pane.method == Some(method));
        if before.is_empty() && !now.iter().any(|method| has_pane(*method)) {
            self.lay_out_methods(MethodsPreset::Panes);
            return;
        }
        let both = self.burst_of(Side::B).is_some();
        now.iter().for_each(|method| self.panes.add_method(*method, both));
        before.iter().filter(|method| !now.contains(method)).for_each(|method| self.panes.remove_method(*method));
    }

    /// Takes the panes of a session as those of the methods that are compared now.
    pub fn keep_methods_arranged(&mut self) {
        let shown = self.panes.shown_in(Workspace::Methods);
        let is_laid_out = shown.iter().filter_map(|id| self.panes.get(*id)).any(|pane| pane.method.is_some());
        self.compare.arranged = if is_laid_out { self.contenders() } else { Vec::new() };
    }

    /// Lays out the methods that are compared.
    pub fn lay_out_methods(&mut self, preset: MethodsPreset) {
        let (methods, both) = (self.contenders(), self.burst_of(Side::B).is_some());
        self.panes.lay_out_methods(preset, &methods, both);
    }
}
