//! Filmstrip: a dataset's bursts in order, each with a thumbnail, its state, and whether it is A or B.

use crate::app::actions::{ActionId, Queue, button_ui};
use crate::app::document::{Action, Side};
use crate::app::inspector::copy_ui;
use crate::app::panel::widgets::{middle_elided, named, paint, progress_text};
use crate::app::results::{BurstState, Dataset, Datasets, Read};
use crate::app::style;
use crate::burst::{BurstFiles, OpenOptions};
use crate::dataset::BurstPicture;
use crate::engine::{Engine, Wanted};
use crate::inspect::words::counted;
use crate::requests::ThumbnailsRequest;
use crate::teach::Workspace;
use egui::{
    Align, Align2, Color32, ColorImage, Context, FontId, Label, Layout, Pos2, ProgressBar, Rect, Response, RichText,
    ScrollArea, Sense, Stroke, StrokeKind, TextureHandle, TextureOptions, Ui, pos2, vec2,
};
use std::collections::HashMap;

const CELL_WIDTH: f32 = 116.0;
const PICTURE_HEIGHT: f32 = 76.0;
const TEXT_HEIGHT: f32 = 17.0;
const GAP: f32 = 6.0;
const CELL_HEIGHT: f32 = PICTURE_HEIGHT + 2.0 * TEXT_HEIGHT;

pub const HEIGHT: f32 = CELL_HEIGHT + 44.0;

pub fn filmstrip_ui(ui: &mut Ui, model: Read<'_>, thumbnails: &mut Thumbnails, queue: &mut Queue) {
    ui.horizontal(|ui| header_ui(ui, model, queue));
    let shown = model.place_of(Side::A);
    let fraction = model.results.datasets.burst_fraction();
    let Some(dataset) = &model.results.datasets.open else { return };
    ui.add_space(2.0);
    let count = dataset.bursts.len();
    let scroll_id = ui.scope_id().with("shown burst");
    let scrolled_to: Option<usize> = ui.data(|d| d.get_temp(scroll_id)).flatten();
    ScrollArea::horizontal().auto_shrink(false).show_viewport(ui, |ui, viewport| {
        let step = CELL_WIDTH + GAP;
        ui.set_width(count as f32 * step);
        ui.set_height(CELL_HEIGHT);
        let origin = ui.max_rect().min;
        let cell = |place: usize| {
            Rect::from_min_size(pos2(origin.x + place as f32 * step, origin.y), vec2(CELL_WIDTH, CELL_HEIGHT))
        };
        // Scrolls to the open burst once, when it was opened elsewhere.
        if let Some(place) = shown.filter(|_| shown != scrolled_to) {
            ui.scroll_to_rect(cell(place).expand2(vec2(step, 0.0)), None);
        }
        // Only cells in view are drawn and ask for thumbnails: a dataset may be long.
        let first = (viewport.min.x / step).floor().max(0.0) as usize;
        let last = ((viewport.max.x / step).ceil().max(0.0) as usize).min(count);
        for place in first..last {
            let picture = (thumbnails.get(&dataset.bursts[place]), fraction);
            let response = cell_ui(ui, dataset, (place, cell(place)), picture, shown == Some(place));
            queue.push_if(response.clicked(), Action::OpenBurstAt(place));
            for side in Side::BOTH {
                let is_chosen = model.document.dataset.as_ref().is_some_and(|set| set.pair[side] == Some(place));
                side_ui(ui, dataset, place, side, is_chosen, cell(place), queue);
            }
            response.context_menu(|ui| menu_ui(ui, dataset, place, queue));
        }
    });
    ui.data_mut(|d| d.insert_temp(scroll_id, shown));
}

fn menu_ui(ui: &mut Ui, dataset: &Dataset, place: usize, queue: &mut Queue) {
    ui.set_min_width(150.0);
    queue.push_if(ui.button("Open").clicked(), Action::OpenBurstAt(place));
    for side in Side::BOTH {
        let button = ui.button(format!("Use as {}", side.name())).on_hover_text("Of a pair to be matched");
        queue.push_if(button.clicked(), Action::ChooseBurst(side, place));
    }
    ui.separator();
    let burst = &dataset.bursts[place];
    copy_ui(ui, "Copy name", || burst.name.clone());
    copy_ui(ui, "Copy path", || burst.paths.first().map_or_else(String::new, |path| path.display().to_string()));
    if let BurstState::Failed(why) = &dataset.states[place] {
        copy_ui(ui, "Copy why it failed", || why.clone());
    }
}

fn header_ui(ui: &mut Ui, model: Read<'_>, queue: &mut Queue) {
    let Some(dataset) = &model.results.datasets.open else { return };
    ui.label(RichText::new(dataset.source.label()).strong()).on_hover_ui(|ui| {
        for path in &dataset.source.paths {
            ui.label(path.display().to_string());
        }
    });
    ui.weak(summary(dataset));
    ui.separator();
    if model.results.datasets.work.is_some() {
        working_ui(ui, &model.results.datasets);
        button_ui(ui, model, queue, ActionId::CancelDataset, Some("Cancel all"));
    } else {
        button_ui(ui, model, queue, ActionId::DetectAll, None);
        notice_ui(ui, model, dataset, queue);
    }
    if !dataset.matches.counts.is_empty() && model.document.workspace != Workspace::Matches {
        button_ui(ui, model, queue, ActionId::WorkspaceMatches, None);
    }
    if model.document.dataset.as_ref().is_some_and(|set| set.selected().is_some()) {
        button_ui(ui, model, queue, ActionId::ShowPair, Some("A | B"));
    }
    // From the right, so that a full line cuts the path and not a button.
    ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
        short_button_ui(ui, model, queue, ActionId::CloseDataset, "✖");
        let place = dataset.folder.as_ref().map_or("no folder".to_owned(), |f| f.display().to_string());
        short_button_ui(ui, model, queue, ActionId::FeatureFolder, "Folder…");
        ui.add(Label::new(RichText::new(&place).weak()).truncate())
            .on_hover_text(format!("Features, pictures and what is finished are kept in this folder: {place}"));
    });
}

/// Draws a button whose text is shorter than its label for screen readers.
fn short_button_ui(ui: &mut Ui, model: Read<'_>, queue: &mut Queue, id: ActionId, text: &str) {
    named(&button_ui(ui, model, queue, id, Some(text)), egui::Role::Button, id.action().label);
}

fn notice_ui(ui: &mut Ui, model: Read<'_>, dataset: &Dataset, queue: &mut Queue) {
    let warning = |text: &str| RichText::new(text).color(style::warning(ui));
    if let Some(error) = &dataset.folder_error {
        ui.label(RichText::new("Features cannot be kept here").color(ui.visuals().error_fg_color)).on_hover_text(error);
    } else if dataset.folder.is_none() {
        ui.label(warning("Choose a folder for the features"));
    } else if dataset.params != model.asked() {
        ui.label(warning("The parameters changed"))
            .on_hover_text("These features were found with earlier parameters. Detect all finds all features again.");
    } else if dataset.other_params.is_some() {
        ui.label(warning("The folder has features found with other parameters"))
            .on_hover_text("Detect all replaces them by features found with the present parameters.");
        button_ui(ui, model, queue, ActionId::UseFolderParams, Some("Use those"));
    }
}

fn summary(dataset: &Dataset) -> String {
    let (count, counts) = (dataset.bursts.len(), dataset.counts());
    let failed = if counts.failed > 0 { format!(", {} failed", counts.failed) } else { String::new() };
    let found = if counts.features > 0 { format!(", {}", counted(counts.features, "feature")) } else { String::new() };
    format!("{}, {} done{failed}{found}", counted(count, "burst"), counts.done)
}

pub fn working_ui(ui: &mut Ui, datasets: &Datasets) {
    let Some(work) = datasets.work else { return };
    let running = datasets.wanted.running;
    let fraction = running.and_then(|r| r.progress).map_or(0.0, |p| p.fraction);
    let text = running.as_ref().map_or_else(|| work.title().to_owned(), progress_text);
    let bar = ui.add(ProgressBar::new(fraction).desired_width(280.0).text(text));
    named(&bar, egui::Role::ProgressIndicator, work.title());
}

/// Draws the cell of the burst at a place, with its thumbnail, and the fraction of the work on it that is done.
fn cell_ui(
    ui: &Ui,
    dataset: &Dataset,
    (place, rect): (usize, Rect),
    (picture, fraction): (Option<&ThumbnailState>, f32),
    open: bool,
) -> Response {
    let burst = &dataset.bursts[place];
    let state = &dataset.states[place];
    let response = ui.interact(rect, ui.scope_id().with(("burst", place)), Sense::click());
    let label = format!("Burst {}: {}", burst.name, state.text());
    response.widget_info(|| egui::WidgetInfo::selected(egui::Role::Button, true, open, &label));
    let visuals = ui.visuals();
    let painter = ui.painter_at(rect);
    let fill = if response.hovered() { visuals.widgets.hovered.weak_bg_fill } else { visuals.faint_bg_color };
    painter.rect_filled(rect, 4.0, fill);
    let area = Rect::from_min_size(rect.min + vec2(0.0, TEXT_HEIGHT), vec2(CELL_WIDTH, PICTURE_HEIGHT));
    picture_ui(ui, area, picture);
    state_ui(ui, state, area, rect, fraction);
    // The right end of the line is left to the squares of A and B.
    let name_room = Rect::from_min_max(rect.min + vec2(4.0, 0.0), rect.min + vec2(CELL_WIDTH - 36.0, TEXT_HEIGHT));
    let font = FontId::proportional(11.0);
    let name = middle_elided(ui.painter(), &burst.name, &font, visuals.text_color(), name_room.width());
    let room = painter.with_clip_rect(name_room);
    room.galley(pos2(name_room.left(), name_room.center().y - 0.5 * name.size().y), name, visuals.text_color());
    let stroke = if open { Stroke::new(2.0, style::ACCENT) } else { visuals.widgets.noninteractive.bg_stroke };
    painter.rect_stroke(rect, 4.0, stroke, StrokeKind::Inside);
    response.on_hover_text(format!("{}\n{}\nClick to open it", burst.name, state.sentence()))
}

fn side_ui(ui: &Ui, dataset: &Dataset, place: usize, side: Side, on: bool, rect: Rect, queue: &mut Queue) {
    let corner = rect.right_top() + vec2(-33.0 + 16.0 * f32::from(side as u8), 1.5);
    let square = Rect::from_min_size(corner, vec2(14.0, 14.0));
    let response = ui.interact(square, ui.scope_id().with(("side", place, side)), Sense::click());
    let label = format!("Use {} as {}", dataset.bursts[place].name, side.name());
    response.widget_info(|| egui::WidgetInfo::selected(egui::Role::Button, true, on, &label));
    let visuals = ui.visuals();
    let fill = if on { side_colour(side) } else { visuals.extreme_bg_color };
    let text = if on { Color32::BLACK } else { visuals.weak_text_color() };
    let painter = ui.painter_at(rect);
    painter.rect_filled(square, 3.0, fill);
    if response.hovered() {
        painter.rect_stroke(square, 3.0, visuals.widgets.hovered.fg_stroke, StrokeKind::Inside);
    }
    painter.text(square.center(), Align2::CENTER_CENTER, side.name(), FontId::proportional(10.0), text);
    let response = response.on_hover_text(format!("{label} of a pair to be matched"));
    queue.push_if(response.clicked(), Action::ChooseBurst(side, place));
}

/// Colour of A or B; the two can be told apart without colour vision, on dark and light backgrounds.
pub fn side_colour(side: Side) -> Color32 {
    [Color32::from_rgb(0xf2, 0xb1, 0x4b), Color32::from_rgb(0x6c, 0xb8, 0xf2)][side as usize]
}

fn picture_ui(ui: &Ui, area: Rect, picture: Option<&ThumbnailState>) {
    let painter = ui.painter_at(area);
    painter.rect_filled(area, 0.0, ui.visuals().extreme_bg_color);
    let say = |text: &str, colour: Color32| {
        painter.text(area.center(), Align2::CENTER_CENTER, text, FontId::proportional(11.0), colour);
    };
    match picture {
        Some(ThumbnailState::Picture(texture)) => {
            let size = texture.size_vec2();
            let size = size * (area.width() / size.x).min(area.height() / size.y);
            paint(&painter, texture.id(), Rect::from_center_size(area.center(), size));
        }
        Some(ThumbnailState::Failed(_)) => say("no picture", ui.visuals().error_fg_color),
        Some(ThumbnailState::Asked) | None => say("…", ui.visuals().weak_text_color()),
    }
}

fn state_ui(ui: &Ui, state: &BurstState, area: Rect, rect: Rect, fraction: f32) {
    let (painter, visuals) = (ui.painter_at(rect), ui.visuals());
    let text_colour = if *state == BurstState::Waiting { visuals.weak_text_color() } else { visuals.text_color() };
    let y = rect.bottom() - 0.5 * TEXT_HEIGHT;
    mark_ui(ui, state, pos2(rect.left() + 9.0, y));
    let font = FontId::proportional(11.0);
    painter.text(pos2(rect.left() + 18.0, y), Align2::LEFT_CENTER, state.text(), font, text_colour);
    if *state == BurstState::Running {
        let bar = Rect::from_min_max(area.left_bottom() - vec2(0.0, 4.0), area.right_bottom());
        painter.rect_filled(bar, 0.0, visuals.extreme_bg_color);
        painter.rect_filled(bar.with_max_x(egui::lerp(bar.x_range(), fraction)), 0.0, style::ACCENT);
    }
}

/// Draws a sign for the state that needs no colours to be told apart: a ring, a ring with a point, a disc, a cross.
fn mark_ui(ui: &Ui, state: &BurstState, centre: Pos2) {
    const RADIUS: f32 = 4.0;
    let (painter, visuals) = (ui.painter(), ui.visuals());
    match state {
        BurstState::Waiting => _ = painter.circle_stroke(centre, RADIUS, Stroke::new(1.0, visuals.weak_text_color())),
        BurstState::Running => {
            painter.circle_stroke(centre, RADIUS, Stroke::new(1.5, style::warning(ui)));
            painter.circle_filled(centre, 0.4 * RADIUS, style::warning(ui));
        }
        // Searched, but without features to continue with.
        BurstState::Done(done) if done.features == 0 => {
            painter.circle_stroke(centre, RADIUS, Stroke::new(2.0, style::warning(ui)));
        }
        BurstState::Done(_) => _ = painter.circle_filled(centre, RADIUS, style::good(ui)),
        BurstState::Failed(_) => {
            let arm = 0.8 * RADIUS;
            for arm in [vec2(arm, arm), vec2(arm, -arm)] {
                painter.line_segment([centre - arm, centre + arm], Stroke::new(2.0, visuals.error_fg_color));
            }
        }
    }
}

pub const SIDE_PX: usize = 160;
const MAX_KEPT: usize = 400;
/// Maximum number of thumbnails in a request, so that those that come into view soon need not wait long.
const MAX_ASKED: usize = 8;

pub enum ThumbnailState {
    Asked,
    Picture(TextureHandle),
    Failed(String),
}

#[derive(Default)]
pub struct Thumbnails {
    shown: HashMap<String, ThumbnailState>,
    in_view: Vec<BurstFiles>,
    wanted: Wanted<ThumbnailsRequest>,
}

impl Thumbnails {
    /// State of the thumbnail of `burst`; an unknown one is requested next.
    pub fn get(&mut self, burst: &BurstFiles) -> Option<&ThumbnailState> {
        if !self.shown.contains_key(&burst.name) {
            self.in_view.push(burst.clone());
        }
        self.shown.get(&burst.name)
    }

    pub fn is_waiting(&self) -> bool {
        !self.in_view.is_empty() || self.shown.values().any(|s| matches!(s, ThumbnailState::Asked))
    }

    /// Requests the thumbnails that came into view in this pass from the workers; bursts are opened with `open`.
    pub fn request(&mut self, engine: &Engine, open: &OpenOptions) {
        let mut bursts = std::mem::take(&mut self.in_view);
        // One request at a time: a burst that leaves the view meanwhile is never asked for.
        if bursts.is_empty() || self.wanted.is_pending() {
            return;
        }
        if self.shown.len() + bursts.len() > MAX_KEPT {
            // Simpler than tracking which were seen last: thumbnails in view are made again soon.
            self.shown.clear();
        }
        bursts.truncate(MAX_ASKED);
        self.shown.extend(bursts.iter().map(|b| (b.name.clone(), ThumbnailState::Asked)));
        self.wanted.ask(engine, ThumbnailsRequest { bursts, max_side_px: SIDE_PX, open: open.clone() });
    }

    pub fn take_made(&mut self, ctx: &Context, bursts: &[BurstFiles]) {
        // Pictures of a dataset that was closed meanwhile are dropped.
        for (source, picture) in self.wanted.take_partial().into_iter().filter(|(source, _)| bursts.contains(source)) {
            let shown = match picture {
                Ok(BurstPicture { size, rgb }) => {
                    let image = ColorImage::from_rgb(size.into(), &rgb);
                    ThumbnailState::Picture(ctx.load_texture(&source.name, image, TextureOptions::LINEAR))
                }
                Err(error) => ThumbnailState::Failed(error),
            };
            self.shown.insert(source.name.clone(), shown);
        }
        self.wanted.take();
    }
}
