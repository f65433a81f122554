//! The "about" box.

/// Draws the box if it is open.
pub fn about_ui(ctx: &egui::Context, open: &mut bool) {
    if !*open {
        return;
    }
    let modal = egui::Modal::new(egui::Id::unique("about")).show(ctx, |ui| {
        ui.set_width(420.0);
        ui.heading(format!("Burstscope {}", env!("CARGO_PKG_VERSION")));
        ui.label(env!("CARGO_PKG_DESCRIPTION"));
        ui.add_space(6.0);
        ui.label("The method is that of A. Ravendran, M. Bryson and D. G. Dansereau, “BuFF: Burst Feature Finder for Light-Constrained 3D Reconstruction”.");
        ui.hyperlink_to("arXiv 2209.09470", "https://arxiv.org/abs/2209.09470");
        if let Some(gpu) = crate::app::gpu::Gpu::of(ui.ctx()) {
            ui.add_space(6.0);
            ui.weak(format!("Graphics adapter: {}", gpu.adapter_name));
        }
        ui.add_space(6.0);
        if ui.button("Close").clicked() {
            ui.close();
        }
    });
    if modal.should_close() {
        *open = false;
    }
}
