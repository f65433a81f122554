//! Reading access to the window: places, values under the pointer, remembered settings.

use super::BurstscopeApp;
use crate::app::actions::Queue;
use crate::app::canvas::Readout;
use crate::app::inspector::PlaceValue;
use crate::app::pane::PaneId;
use crate::app::project::pair::Side;
use crate::app::settings::Settings;
use crate::app::workspace::WorkspaceParts;
use crate::dataset::DatasetSource;
use crate::requests::BurstSource;

impl BurstscopeApp {
    /// Window place (points) of an image place (pixels) in the pane in focus, as last drawn.
    pub fn ui_from_image(&self, pos_image: egui::Pos2) -> Option<egui::Pos2> {
        self.widgets.pos_ui(self.model.focus(), pos_image)
    }

    /// Window place (points) of an image place (pixels) in the pane of the burst of `side`, as last drawn.
    pub fn ui_from_image_of(&self, side: Side, pos_image: egui::Pos2) -> Option<egui::Pos2> {
        self.widgets.pos_ui(PaneId::of(side), pos_image)
    }

    /// Parts of the window that the open workspace reads and changes.
    pub(in crate::app) fn workspace_parts<'a>(&'a mut self, queue: &'a mut Queue) -> WorkspaceParts<'a> {
        WorkspaceParts {
            model: &mut self.model,
            widgets: &mut self.widgets,
            pair: &mut self.pair_panels,
            selection: &mut self.selection,
            probe: &mut self.probe,
            regions: &mut self.regions,
            lab_picture: &mut self.lab_picture,
            queue,
        }
    }

    /// The value under the pointer; with several panes those of all that are linked.
    pub(in crate::app) fn readout(&self) -> Option<String> {
        if self.model.panes.are_many() {
            let (first, rest) = self.widgets.values.split_first()?;
            let value = |v: &PlaceValue| format!("{}: {}", v.number, v.readout.short_text());
            let values: Vec<String> = std::iter::once(first).chain(rest).map(value).collect();
            return Some(format!("u {:.1}  v {:.1}   {}", first.readout.u, first.readout.v, values.join("  ")));
        }
        let readouts = self.model.visible_panes().into_iter().filter_map(|id| self.widgets.get(id)?.picture.readout);
        readouts.into_iter().next().map(|readout: Readout| readout.to_string())
    }

    /// Settings remembered from earlier runs.
    pub fn remembered(&self) -> &Settings {
        &self.settings
    }

    pub(in crate::app) fn remember_dataset(&mut self, source: &DatasetSource) {
        self.settings.remember_dataset(source);
    }

    pub(in crate::app) fn burst_length(&self) -> usize {
        self.settings.burst_length
    }

    /// Bursts that were opened before, the latest first.
    pub fn recent(&self) -> &[BurstSource] {
        &self.settings.recent
    }
}
