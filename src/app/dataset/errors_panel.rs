//! Panel of the trajectories: their files, the settings of the comparison, the errors, and the reconstruction.

use crate::app::actions::{ActionId, Queue, button_ui};
use crate::app::dataset::cameras::{camera_label, camera_text, colour, is_missing, name};
use crate::app::document::{Action, Trajectories};
use crate::app::panel::widgets::{choice_ui, error_ui, named, only_ui, section_ui};
use crate::app::results::datasets::pairs::lost_text;
use crate::app::results::{Dataset, Read};
use crate::evaluate::poses::sparse::SparsePoint;
use crate::evaluate::poses::{Association, ErrorSummary, ModelSummary, PoseReport, Projection, SparseModel};
use crate::inspect::words::capitalised;
use crate::matching::ImageCounts;
use crate::requests::Which;
use egui::{DragValue, Grid, Label, RichText, Ui};

pub fn errors_panel_ui(ui: &mut Ui, model: Read<'_>, queue: &mut Queue) {
    section_ui(ui, "Trajectories", |ui| {
        file_ui(ui, model, queue, ActionId::OpenEstimate, Which::Estimate);
        file_ui(ui, model, queue, ActionId::OpenSecond, Which::Second);
        file_ui(ui, model, queue, ActionId::OpenTruth, Which::Truth);
        study_ui(ui, model, queue);
    });
    let (poses, set) = (&model.results.poses, &model.document.trajectories);
    for (which, problem) in poses.problems() {
        error_ui(ui, format!("{}: {problem}", name(which)));
    }
    if let Some(camera) = set.selected.filter(|camera| *camera < poses.compared.pairs.len()) {
        section_ui(ui, "Camera", |ui| camera_ui(ui, model, queue, camera));
    }
    if let Some((sparse, point)) = poses.model().and_then(|sparse| Some((sparse, sparse.points.get(set.point?)?))) {
        section_ui(ui, "3D point", |ui| point_ui(ui, queue, sparse, point));
    }
    let count = poses.reports().count();
    if count > 0 {
        section_ui(ui, "Errors", |ui| {
            for (which, report) in poses.reports() {
                if count > 1 {
                    ui.label(RichText::new(name(which)).strong().color(colour(ui, which)));
                }
                errors_ui(ui, which, report);
            }
        });
    }
    if poses.read(Which::Second).is_some() && poses.read(Which::Truth).is_none() {
        ui.weak("A second estimate is drawn beside a truth, with which both are aligned.");
    }
    section_ui(ui, "Reconstruction", |ui| reconstruction_ui(ui, model));
}

fn file_ui(ui: &mut Ui, model: Read<'_>, queue: &mut Queue, id: ActionId, which: Which) {
    let read = model.results.poses.compared.read[which as usize].as_ref();
    ui.horizontal(|ui| {
        let response = button_ui(ui, model, queue, id, Some(&format!("{}…", name(which))));
        named(&response, egui::Role::Button, id.action().label);
        if read.is_some() {
            let response = ui.small_button("×").on_hover_text("Close it; the others stay open");
            named(&response, egui::Role::Button, format!("Close {}", name(which)));
            queue.push_if(response.clicked(), Action::CloseTrajectory(which));
        }
        let text = read.map_or("none yet".to_owned(), |(path, _)| path.display().to_string());
        ui.add(Label::new(RichText::new(&text).weak()).truncate()).on_hover_text(text);
    });
    if let Some(taken) = read.and_then(|(_, read)| read.model.as_ref()?.taken()) {
        ui.weak(capitalised(&taken));
    }
}

/// A camera, its burst, and the pair by which it hangs: the burst's weakest, or the best where no estimate has it.
fn camera_ui(ui: &mut Ui, model: Read<'_>, queue: &mut Queue, camera: usize) {
    ui.label(camera_text(model, camera));
    let label = camera_label(model, camera);
    let Some(dataset) = &model.results.datasets.open else {
        return only_ui(ui, "Open the dataset to go to its burst and its pairs.");
    };
    queue.push_if(ui.button("Open its burst").clicked(), Action::OpenCamera(label.to_owned()));
    let is_missing = is_missing(model, camera);
    let pair = dataset.place_of_camera(label).and_then(|place| dataset.matches.of_burst(place, is_missing));
    let Some((pair, counts)) = pair else { return only_ui(ui, "Its burst has no matched pair in the open dataset.") };
    let (name, [a, b]) = (if is_missing { "Best pair" } else { "Weakest pair" }, [pair.0, pair.1]);
    let [a, b] = [a, b].map(|place| dataset.bursts[place].name.as_str());
    let (text, step) = lost_text(&counts, model.losses_of(pair));
    if ui.button(format!("{name}: {a}, {b}")).on_hover_text("Show it, with why its features are lost").clicked() {
        queue.push(Action::SelectPair(pair));
        queue.push(ActionId::ShowPair);
        queue.push(Action::ShowLost(step, true));
    }
    ui.label(text);
}

/// A point with its keypoints, which are the features of their bursts where the model was made from the dataset's.
fn point_ui(ui: &mut Ui, queue: &mut Queue, sparse: &SparseModel, point: &SparsePoint) {
    ui.label(format!("seen {} times, {:.2} px off in the mean", point.track.len(), point.reprojection_error_px));
    for (image, keypoint) in sparse.seen_by(point) {
        let name = &sparse.images[image].name;
        let response = ui.link(format!("{name}, keypoint {keypoint}"));
        let response = response.on_hover_text("Open the burst with the feature of this number, if the dataset is open");
        queue.push_if(response.clicked(), Action::OpenFeature(name.clone(), keypoint));
    }
}

fn study_ui(ui: &mut Ui, model: Read<'_>, queue: &mut Queue) {
    let trajectories: &Trajectories = &model.document.trajectories;
    let (mut projection, mut study) = (trajectories.projection, trajectories.study);
    Grid::new("study").num_columns(2).show(ui, |ui| {
        let help = "The plane in which the cameras are drawn, or a free view that dragging turns";
        let label = ui.label("Seen from").on_hover_text(help);
        choice_ui(ui, "projection", label.id, None, &mut projection, Projection::ALL, Projection::name);
        ui.end_row();
        if model.results.poses.model().is_some() {
            let label = ui.label("3D points").on_hover_text("Draw the points of the estimate that the cameras saw");
            let mut points = trajectories.points;
            ui.checkbox(&mut points, "").labelled_by(label.id);
            queue.set(&trajectories.points, points, Action::ShowPoints);
            ui.end_row();
        }
        let label = ui.label("Paired").on_hover_text("How estimated and true cameras are paired");
        let name = |by: Option<Association>| by.map_or("as it fits", Association::phrase);
        let rules = [None, Some(Association::Name), Some(Association::Time), Some(Association::Order)];
        choice_ui(ui, "associate", label.id, None, &mut study.associate, rules, name);
        ui.end_row();
        let difference = DragValue::new(&mut study.max_time_difference).range(0.0..=f64::MAX).speed(0.01);
        let step = DragValue::new(&mut study.step).range(1..=10_000).suffix(" poses");
        for (label, help, field) in [
            ("Time difference", "Max difference of the times of a pair, in the files' unit", difference),
            ("Step", "Poses between the start and the end of each motion of the relative pose error", step),
        ] {
            let label = ui.label(label).on_hover_text(help);
            ui.add(field).labelled_by(label.id);
            ui.end_row();
        }
    });
    queue.edit(model.document, Action::SetProjection(projection));
    queue.set(&trajectories.study, study, Action::SetPoseStudy);
}

fn errors_ui(ui: &mut Ui, which: Which, report: &PoseReport) {
    let PoseReport { absolute, relative, scale, .. } = report;
    ui.weak(format!("{} poses paired {}, scale {scale:.5}", absolute.count, report.associated.phrase())).on_hover_text("The estimate is aligned with the truth by the similarity that minimises the squared distances of the camera centres (Umeyama 1991)");
    let right = "Within 3 % of the way's extent and 3° of the truth, aligned by two cameras or by all, as most are right; the errors are aligned by all";
    ui.label(format!("{} of {} cameras right", report.right, report.images)).on_hover_text(right);
    if report.absolute.count <= 2 {
        ui.weak("Two poses always fit: their errors say nothing.");
    }
    if report.straight {
        ui.weak("The cameras stand on a line; their directions fixed the rotation about it.");
    }
    Grid::new(("errors", name(which))).num_columns(5).striped(true).show(ui, |ui| {
        for heading in ["", "RMSE", "mean", "median", "max"] {
            ui.label(RichText::new(heading).small());
        }
        ui.end_row();
        let rows: [(&str, &str, &ErrorSummary, usize); 4] = [
            ("ATE", "distances of the camera centres, in the truth's unit", &absolute.translation, 4),
            ("ATE °", "angles between the cameras' directions, degrees", &absolute.rotation_deg, 3),
            ("RPE", "difference between estimated and true motions, in the truth's unit", &relative.translation, 4),
            ("RPE °", "difference between estimated and true motions, degrees", &relative.rotation_deg, 3),
        ];
        for (name, help, errors, digits) in rows {
            let whose = if name.starts_with('A') { "Absolute trajectory" } else { "Relative pose" };
            ui.label(name).on_hover_text(format!("{whose} error: {help}"));
            for value in [errors.rmse, errors.mean, errors.median, errors.max] {
                let text = if value.is_nan() { "–".to_owned() } else { format!("{value:.digits$}") };
                ui.label(RichText::new(text).monospace());
            }
            ui.end_row();
        }
    });
}

fn reconstruction_ui(ui: &mut Ui, model: Read<'_>) {
    let summary = model.results.poses.model().map(SparseModel::summary);
    let matched = model.results.datasets.open.as_ref().and_then(Dataset::image_counts);
    // Without a truth the number of images is unknown, and with it the share.
    let registered = match (model.results.poses.report(Which::Estimate), &summary) {
        (Some(r), _) => Some(format!("{} of {} ({:.0} %)", r.registered, r.images, r.images_pass_percent())),
        (None, summary) => summary.as_ref().map(|s| s.registered_images.to_string()),
    };
    let of_matches = |decimals: usize, number: fn(&ImageCounts) -> f64| {
        matched.as_ref().map(|counts| format!("{:.decimals$}", number(counts)))
    };
    let inlier_ratio = matched.as_ref().and_then(|m| m.inlier_ratio).map(|p| format!("{p:.3}"));
    let points = |text: fn(&ModelSummary) -> String| summary.as_ref().map(text);
    let by_descriptors = "Matches of a burst with all others by descriptors alone; each counts for both of its bursts";
    let inliers = "Matches of a burst with all others that a geometry explains; each counts for both of its bursts";
    let matches = [
        ("Keypoints an image", "Features of a burst", of_matches(1, |m| m.keypoints_per_image)),
        ("Putative an image", by_descriptors, of_matches(1, |m| m.putative_per_image)),
        ("Inliers an image", inliers, of_matches(1, |m| m.inliers_per_image)),
        ("Putative a keypoint", "Putative matches with all others over keypoints", of_matches(3, |m| m.match_ratio)),
        ("Inliers a keypoint", "Inliers with all others over keypoints", of_matches(3, |m| m.match_score)),
        ("Inlier ratio", "Inliers over putative matches", inlier_ratio),
    ];
    let seen = "Points that an image sees, mean over the registered images";
    let track = "Images in which a point is seen, mean over the points";
    let distance = "Mean distance of a point's projections from its keypoints";
    let model = [
        ("Registered images", "Images whose camera was found, of all images", registered),
        ("3D points", "Points of the sparse model", points(|s| s.points.to_string())),
        ("3D points an image", seen, points(|s| format!("{:.1}", s.points_per_image))),
        ("Track length", track, points(|s| format!("{:.2}", s.mean_track_length))),
        ("Reprojection error", distance, points(|s| format!("{:.3} px", s.mean_reprojection_error_px))),
    ];
    // The model may have been made from other features than those of the dataset that is open.
    let of_matches = "Once its pairs are matched; a model of other features has others";
    for (title, about, rows) in [
        ("Opened model", "Sparse model that was opened", &model[..]),
        ("Matches of the open dataset", of_matches, &matches[..]),
    ] {
        ui.label(RichText::new(title).strong()).on_hover_text(about);
        Grid::new(title).num_columns(2).striped(true).min_col_width(130.0).show(ui, |ui| {
            for (name, help, value) in rows {
                ui.label(RichText::new(*name).weak()).on_hover_text(*help);
                ui.label(RichText::new(value.as_deref().unwrap_or("–")).monospace());
                ui.end_row();
            }
        });
    }
}
