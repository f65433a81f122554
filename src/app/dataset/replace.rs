//! Question whether features of other parameters may be replaced, with what is kept of them.

use crate::app::project::datasets::Datasets;
use crate::inspect::words::counted;

/// Asks while `open`; returns whether the features may be replaced.
pub fn replace_features_ui(ctx: &egui::Context, open: &mut bool, datasets: &Datasets) -> bool {
    if !*open {
        return false;
    }
    let Some(dataset) = &datasets.open else {
        *open = false;
        return false;
    };
    let mut replace = false;
    let modal = egui::Modal::new(egui::Id::unique("replace features")).show(ctx, |ui| {
        ui.set_width(420.0);
        ui.heading("Replace features?");
        ui.add_space(4.0);
        let folder = dataset.folder.as_ref().map_or_else(String::new, |f| f.display().to_string());
        ui.label(format!("The folder {folder} has features that were found with other parameters."));
        ui.add_space(4.0);
        let bursts = counted(dataset.bursts.len(), "burst");
        ui.label(format!(
            "Detect all finds the features of {bursts} again with the parameters as they are now, and replaces \
             the old ones, burst by burst. Cancelled, it keeps the new features of the bursts that are finished. The bursts \
             themselves are not touched. To keep the old features, cancel and choose another folder."
        ));
        ui.add_space(6.0);
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            if ui.button("Replace").clicked() {
                replace = true;
            }
            if ui.button("Cancel").clicked() {
                ui.close();
            }
        });
    });
    if replace || modal.should_close() {
        *open = false;
    }
    replace
}
