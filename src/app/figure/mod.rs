//! Figures of the shown panes, with filter, faint features, colours and visible part of the image: the dialog that
//! chooses the content, and the content of the panes as panels, with the match lines between them. And films of them.

use crate::app::actions::{ActionId, Queue};
use crate::app::canvas::overlay::{ColourBy, ColourScale, MatchLine, Pane, UNKNOWN, drawn_lines};
use crate::app::canvas::{self, RectTransform, number};
use crate::app::document::export::{ONE_COLUMN_MM, TWO_COLUMNS_MM};
use crate::app::document::{Action, FigureChoice, FilmChoice, FilmContent, MethodId, Pointed, RangeClass, Side};
use crate::app::inspector::{PaneWidgets, joined_panes};
use crate::app::memo::{Itself, kept};
use crate::app::panel::picture::{PictureState, describe};
use crate::app::panel::widgets::{close_ui, error_ui, modal_ui};
use crate::app::results::{MatchRow, Read};
use crate::app::workspace::pair::lines::line_of;
use crate::app::{pane::PaneId, panel::features::FeatureLayer};
use crate::detector::{Feature, Quantity};
use crate::export::film::{FILM_RATES, estimated_film_bytes};
use crate::export::{
    ColourBar, FigureAmount, FigureFormat, FigureLink, FigureMark, FigureMatches, FigurePanel, FigureWidth,
    LegendEntry, MatchKind, motion_over,
};
use crate::inspect::words::{self, counted, slope_text};
use crate::requests::{FigurePicture, FigureRequest, PictureAnswer, titled};
use egui::{Align, ColorImage, Context, DragValue, Grid, Image, Layout, TextureOptions, Ui, Vec2, vec2};
use image::imageops::{FilterType, resize};
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

/// Matches of the panes as the choice has them. Of one pair the legend counts those drawn, and all of the panes.
fn matches_of(model: Read<'_>, widgets: &PaneWidgets, panes: &[PaneId], choice: &FigureChoice) -> FigureMatches {
    let document = model.document;
    let (is_pair, are_methods) = (document.workspace.shows_pair(), document.compares_methods());
    let of_pair = model.results.pair.matches.as_ref().filter(|_| is_pair);
    let of_pair = of_pair.map(|matches| (None, matches, model.drawn_matches()));
    let of_methods = MethodId::ALL.into_iter().filter(|_| are_methods && !is_pair).filter_map(|method| {
        let matches = model.method_matches(method)?;
        let rows = matches.rows().filter(|row| row.is_shown(&document.match_look)).map(|row| row.index);
        Some((Some(method), matches, rows.collect()))
    });
    // Panes hidden behind a tab have no neighbours.
    let place = |id: &PaneId| Some((*id, widgets.rect_ui(*id).filter(egui::Rect::is_positive)?));
    let places: Vec<_> = panes.iter().filter_map(place).collect();
    let mut links = Vec::new();
    let (mut all, mut drawn) = (Vec::new(), Vec::new());
    for (method, matches, shown) in of_pair.into_iter().chain(of_methods) {
        // Panes of A and of B that the window joins for these, with the times of their pictures from mid-burst.
        let shift = |id: PaneId, side| model.frames_from_middle(id, matches.detection(side)).unwrap_or_default();
        let pairs = joined_panes(model, &places, method).into_iter().map(|(a, b)| [places[a].0, places[b].0]);
        let joined: Vec<_> = pairs.map(|ids| (ids, [shift(ids[0], Side::A), shift(ids[1], Side::B)])).collect();
        let is_selected = |index| method.is_none() && model.document.selected_match == Some(index);
        let mut rows: Vec<MatchRow<'_>> = shown.into_iter().filter_map(|index| matches.row(index)).collect();
        // Matches with lines in the window, between the first two panes that are joined.
        let in_window = joined.first().filter(|_| choice.matches == FigureAmount::Drawn);
        let in_window = in_window.and_then(|(ids, shifts)| {
            let (ui_from_image, rect_ui) = (widgets.ui_from_image(ids[0])?, widgets.rect_ui(ids[0])?);
            let lines: Vec<MatchLine> = rows.iter().map(|row| line_of(row, *shifts, None)).collect();
            let most = (false, model.most_lines(method));
            let drawn = drawn_lines(&lines, &Pane { ui_from_image, rect_ui }, most, is_selected);
            Some(drawn.iter().map(|line| line.index).collect::<BTreeSet<usize>>())
        });
        rows.sort_by(|a, b| a.found.distance.total_cmp(&b.found.distance).then(a.index.cmp(&b.index)));
        all.extend(rows.iter().map(|row| MatchKind::of(row.inlier)));
        let mut rows = choice.matches.of(rows);
        rows.retain(|row| in_window.as_ref().is_none_or(|drawn| drawn.contains(&row.index)));
        drawn.extend(rows.iter().map(|row| MatchKind::of(row.inlier)));
        for (ids, shifts) in joined {
            let panels = ids.map(|id| panes.iter().position(|pane| *pane == id).unwrap_or(usize::MAX));
            let link = |row: &MatchRow<'_>| {
                let line = line_of(row, shifts, None);
                let link = FigureLink::of_match(panels, [line.a, line.b].map(Into::into), line.kind);
                FigureLink { weight: if is_selected(line.index) { 2.0 } else { link.weight }, ..link }
            };
            links.extend(rows.iter().map(link).filter(has_numbers));
        }
    }
    let label = |kind: MatchKind, drawn, all| match model.document.compares_methods() {
        // The title of each method has its count.
        true => kind.label().to_owned(),
        false => kind.counted(drawn, all),
    };
    let has_legend = choice.legend && !links.is_empty();
    let legend = if has_legend { MatchKind::legend(&drawn, &all, label) } else { Vec::new() };
    FigureMatches { links, legend }
}

pub fn figure_of(model: Read<'_>, widgets: &PaneWidgets, choice: &FigureChoice) -> Result<FigureRequest, String> {
    let rows = if choice.all_panes && model.document.workspace.needs_burst() {
        model.document.panes.arrangement().in_rows()
    } else {
        vec![vec![model.document.focus()]]
    };
    let panel = |id: &PaneId| Some((*id, panel_of(model, widgets, *id, choice)?));
    let rows = rows.iter().map(|row| row.iter().filter_map(panel).unzip());
    let (panes, rows): (Vec<Vec<PaneId>>, Vec<Vec<FigurePicture>>) = rows.unzip();
    if rows.iter().all(Vec::is_empty) {
        return Err("there is no picture; open a burst first".to_owned());
    }
    let matches = matches_of(model, widgets, &panes.concat(), choice);
    Ok(FigureRequest { rows, matches, options: choice.options(), format: choice.format })
}

/// Whether no number of it is NaN, with which it would not even equal itself. What lacks a number is not drawn.
fn has_numbers<T: PartialEq>(value: &T) -> bool {
    let same = value;
    value == same
}

fn panel_of(model: Read<'_>, widgets: &PaneWidgets, id: PaneId, choice: &FigureChoice) -> Option<FigurePicture> {
    let picture = model.picture_in(id)?;
    let shown = crate::app::panel::picture::canvas_picture(picture);
    let visible = widgets.get(id).and_then(|widget| part_in_view(&widget.picture)).filter(|_| !choice.whole_picture);
    let region = shown.region(visible.unwrap_or_else(|| shown.rect_image()));
    if region.is_empty() {
        return None;
    }
    let display = model.display_of(id);
    let step = shown.image_from_picture_scale;
    let layer = FeatureLayer::of(model, id);
    let view = widgets.ui_from_image(id).zip(Some(visible.unwrap_or_else(|| shown.rect_image())));
    let drawn = layer.as_ref().map_or_else(Vec::new, |layer| drawn_in(layer, choice.features, view));
    let legend = match &layer {
        Some(layer) if choice.legend && !drawn.is_empty() => legend(&layer.scale(model), layer, &drawn),
        _ => Vec::new(),
    };
    let of = if model.range_class(id) == RangeClass::Share { "the frames" } else { "full scale" };
    let ends = || [number(display.min, 3), format!("{} of {of}", number(display.max, 3))];
    let bar = (choice.colour_bar && picture.motion.is_none()).then(ends);
    let panel = FigurePanel {
        size: (region.columns.len(), region.rows.len()),
        rgba: Arc::default(),
        origin_image: [(region.columns.start as f32 - 0.5) * step, (region.rows.start as f32 - 0.5) * step],
        image_px_per_px: step,
        marks: layer.map(|layer| marks(model, &layer, &drawn)).unwrap_or_default(),
        title: choice.titles.then(|| title_of(model, id, picture)),
        legend,
        bar: bar.map(|[min, max]| ColourBar::of(&display, min, max)),
    };
    let features = model.features_of_motion(id).iter().copied().filter(has_numbers).collect();
    Some(FigurePicture { picture: picture.clone(), region, display, features, panel })
}

/// Title of a picture: the method with its count of inliers, or in *Two bursts* the burst, then what is shown.
fn title_of(model: Read<'_>, id: PaneId, picture: &PictureAnswer) -> String {
    let shown = describe(picture);
    let Some(pane) = model.pane(id) else { return shown };
    match (pane.method, model.burst_of(pane.side)) {
        (Some(method), _) => {
            let counts = model.method_matches(method).and_then(|matches| matches.result.counts.inliers);
            let inliers = counts.map_or_else(String::new, |count| format!(" · {}", counted(count, "inlier")));
            format!("{}{inliers} · {shown}", method.label())
        }
        (None, Some(burst)) if model.document.workspace.shows_pair() => {
            titled(pane.side.name(), &burst.burst.name, &shown)
        }
        _ => shown,
    }
}

/// Shortest side of what is seen of a picture, in points of the window, below which its pane counts as squeezed.
const SQUEEZED: f32 = 48.0;

/// Image pixels; `None` where the pane is squeezed so much that the whole picture is drawn instead.
fn part_in_view(state: &PictureState) -> Option<egui::Rect> {
    let (visible, picture) = (state.visible_image?, state.shown.as_ref()?.rect_image());
    let seen = state.ui_from_image?.rect(visible.intersect(picture));
    (seen.size().min_elem() >= SQUEEZED).then_some(visible)
}

/// Features that the figure shows, in the order in which they are drawn; `view` is that of the pane on the window, and
/// the part of the image that is drawn.
fn drawn_in(layer: &FeatureLayer, amount: FigureAmount, view: Option<(RectTransform, egui::Rect)>) -> Vec<usize> {
    let in_full = view.filter(|_| amount == FigureAmount::Drawn).map(|(ui, rect)| layer.in_full(ui, rect).flags);
    let is_shown = |i: &usize| in_full.as_ref().map_or(layer.shown[*i], |flags| flags[*i]);
    let mut order: Vec<usize> = amount.of((0..layer.placed().len()).filter(is_shown).collect());
    order.sort_by_key(|&i| (layer.selected == Some(i), !layer.is_faint(i)));
    order
}

fn marks(model: Read<'_>, layer: &FeatureLayer, drawn: &[usize]) -> Vec<FigureMark> {
    let scale = layer.scale(model);
    let positions = &layer.detection.positions;
    let mark = |&i: &usize| {
        let (placed, own) = (&layer.placed()[i], &layer.detection.features[i]);
        let faint = layer.is_faint(i);
        let mark = FigureMark::of(placed, positions, rgb(scale.colour(i, placed)));
        FigureMark {
            orientation: (layer.orientations && !faint).then_some(placed.orientation),
            // The motion over the whole burst is the same in every frame.
            motion: (layer.motions && !faint).then(|| motion_over(own, positions)),
            motion_sigma: if layer.stale { 0.0 } else { mark.motion_sigma.max(0.0) },
            opacity: if faint || layer.stale { 0.35 } else { mark.opacity },
            weight: if layer.selected == Some(i) { 2.0 } else { 1.0 },
            ..mark
        }
    };
    drawn.iter().map(mark).filter(has_numbers).collect()
}

const FEW: usize = 6;
const MOST: usize = 12;

/// Meanings of the colours of the `drawn` features: their slopes ([`MOST`]), or where there are more than [`FEW`] the
/// wheel of directions, whose rim is a length in px/frame; the words that they have; or five steps through the range.
fn legend(scale: &ColourScale, layer: &FeatureLayer, drawn: &[usize]) -> Vec<LegendEntry> {
    let features = || drawn.iter().map(|&i| (i, &layer.detection.features[i]));
    let grid = &layer.detection.slopes;
    match scale.by {
        ColourBy::SlopeDirection => {
            let used: BTreeSet<usize> = features().map(|(_, f)| grid.nearest(f.motion().0)).collect();
            if let Some(rim) = scale.has_wheel().then_some(scale.max).filter(|_| used.len() > FEW) {
                return vec![LegendEntry::wheel(format!("slope up to {} px/frame", words::number(rim, 2)))];
            }
            let every = used.len().div_ceil(MOST).max(1);
            let entry = |index: usize| {
                let slope = grid.slope(index);
                LegendEntry::square(rgb(scale.of_slope(slope)), format!("{} px/frame", slope_text(slope)))
            };
            return used.into_iter().step_by(every).map(entry).collect();
        }
        ColourBy::Of(Quantity::AtSlopeLimit | Quantity::Layer | Quantity::Moves) => {
            let of = |(i, f): (usize, &Feature)| {
                let (order, word) = match scale.by {
                    ColourBy::Of(Quantity::AtSlopeLimit) if f.at_slope_limit => (1, "at their limit".to_owned()),
                    ColourBy::Of(Quantity::AtSlopeLimit) => (0, "inside the searched slopes".to_owned()),
                    ColourBy::Of(Quantity::Layer) if f.layer <= 0 => (0, "in no layer".to_owned()),
                    ColourBy::Of(Quantity::Layer) => (f.layer, format!("layer {}", f.layer)),
                    _ => (f.moves as i32, f.moves.words().to_owned()),
                };
                (order, LegendEntry::square(rgb(scale.colour(i, f)), word))
            };
            return features().map(of).collect::<BTreeMap<i32, LegendEntry>>().into_values().collect();
        }
        _ => {}
    }
    let step = |step: usize| {
        let x = scale.min + (scale.max - scale.min) * step as f32 / 4.0;
        let label = format!("{} {}", canvas::number(x, 3), scale.by.unit());
        LegendEntry::square(rgb(scale.along(x)), label.trim_end().to_owned())
    };
    let has_grey = features().any(|(i, feature)| scale.colour(i, feature) == UNKNOWN);
    let grey = LegendEntry::square(rgb(UNKNOWN), "not known".to_owned());
    (0..5).map(step).chain(has_grey.then_some(grey)).collect()
}

fn rgb(colour: egui::Color32) -> [u8; 3] {
    [colour.r(), colour.g(), colour.b()]
}

/// Width of the choices, points.
const CHOICES: f32 = 380.0;

/// Draws the form of a figure, with a preview of the file beside the choices.
pub fn figure_ui(ctx: &Context, is_open: &mut bool, (model, widgets): (Read<'_>, &PaneWidgets), queue: &mut Queue) {
    // What a small window has beside the choices.
    let room = ctx.content_rect().size() - vec2(CHOICES + 90.0, 200.0);
    let room = room.clamp(Vec2::splat(120.0), Vec2::splat(400.0));
    let (mut choice, mut asked) = (model.document.figure, None);
    modal_ui(ctx, is_open, ("figure", CHOICES + room.x + 12.0, "Figure of what is shown"), |ui| {
        ui.weak("Features, filter, colours and part of the picture as in the panes");
        ui.add_space(6.0);
        ui.horizontal_top(|ui| {
            ui.vertical(|ui| {
                ui.set_width(CHOICES);
                let document = model.document;
                size_ui(ui, &mut choice, document.workspace.shows_pair() || document.compares_methods());
                ui.add_space(4.0);
                switches_ui(ui, &mut choice);
                export_row_ui(ui, ActionId::ExportFigure, queue, |ui| {
                    if ui.button("Reset").on_hover_text("Give every choice its default").clicked() {
                        choice = FigureChoice::default();
                    }
                });
            });
            let figure = figure_of(model, widgets, &choice);
            ui.allocate_ui_with_layout(room, Layout::top_down(Align::Center), |ui| preview_ui(ui, model, &figure));
            asked = figure.ok();
        });
    });
    queue.edit(model.document, Action::SetFigure(choice));
    let asked = asked.filter(|_| *is_open);
    queue.set(&model.results.preview.asked, asked, |asked| Pointed::Figure(asked.map(Box::new)).into());
}

/// Draws the last preview that was made, until that of `figure` is there, or why there is none.
fn preview_ui(ui: &mut Ui, model: Read<'_>, figure: &Result<FigureRequest, String>) {
    ui.set_min_size(ui.available_size());
    match model.results.preview.on_show(figure) {
        Err(why) => _ = error_ui(ui, why),
        Ok(None) => _ = ui.weak("Drawing…"),
        Ok(Some(made)) => {
            let texture = kept(ui.ctx(), "preview of a figure", Itself::from(made), || {
                let size = [made.image.width(), made.image.height()].map(|side| side as usize);
                let image = ColorImage::from_rgba_unmultiplied(size, made.image.as_raw());
                ui.ctx().load_texture("preview of the figure", image, TextureOptions::LINEAR)
            });
            // Fewer pixels than there is room for are not enlarged.
            let image = Image::new(&texture).fit_to_original_size(1.0 / ui.ctx().pixels_per_point());
            ui.add(image.max_size(ui.available_size()).alt_text(&made.words)).on_hover_text(&made.words);
        }
    }
}

/// Draws the last row of a form: a button that exports, others, and one that closes it.
fn export_row_ui(ui: &mut Ui, export: ActionId, queue: &mut Queue, others_ui: impl FnOnce(&mut Ui)) {
    ui.add_space(8.0);
    ui.horizontal(|ui| {
        if ui.button("Export…").on_hover_text(export.action().help).clicked() {
            queue.push(export);
            ui.close();
        }
        others_ui(ui);
        close_ui(ui, "Close");
    });
}

fn switches_ui(ui: &mut Ui, choice: &mut FigureChoice) {
    let switches = [
        (&mut choice.all_panes, "All panes", "All panes on the screen, as they are arranged; else the one in focus"),
        (&mut choice.whole_picture, "Whole picture", "Else the part of it that can be seen"),
        (&mut choice.titles, "Titles", "What each picture is, above it"),
        (&mut choice.letters, "Letters", "(a), (b), … where there are several pictures"),
        (&mut choice.legend, "Legend of features", "What their colours mean, below the picture"),
        (&mut choice.colour_bar, "Colour bar", "The picture's colours and values, below it"),
        (&mut choice.scale_bar, "Scale bar", "A bar of a round number of pixels, in the picture's corner"),
    ];
    for (on, label, tip) in switches {
        ui.checkbox(on, label).on_hover_text(tip);
    }
}

fn size_ui(ui: &mut Ui, choice: &mut FigureChoice, has_matches: bool) {
    egui::Grid::new("figure numbers").num_columns(2).spacing([12.0, 6.0]).show(ui, |ui| {
        ui.label("Format");
        ui.horizontal(|ui| {
            for format in FigureFormat::DRAWN {
                let label = format.extension().to_uppercase();
                ui.selectable_value(&mut choice.format, format, label).on_hover_text(format.help());
            }
        });
        ui.end_row();
        let name = ui.label("Width");
        ui.horizontal(|ui| {
            let mut width = choice.width;
            for (mm, label, tip) in [
                (ONE_COLUMN_MM, "88 mm", "One column of a journal"),
                (TWO_COLUMNS_MM, "181 mm", "Two columns of a journal"),
            ] {
                ui.selectable_value(&mut width, FigureWidth::Millimetres(mm), label).on_hover_text(tip);
            }
            let in_px = matches!(width, FigureWidth::PxPerPx(_));
            let tip = "Figure pixels for each pixel of the image, instead of a width on paper";
            if ui.selectable_label(in_px, "Pixels").on_hover_text(tip).clicked() && !in_px {
                width = FigureWidth::PxPerPx(2.0);
            }
            let value = match &mut width {
                FigureWidth::Millimetres(mm) => DragValue::new(mm).range(10.0..=2000.0).speed(1.0).suffix(" mm"),
                FigureWidth::PxPerPx(scale) => {
                    DragValue::new(scale).range(0.1..=32.0).speed(0.02).suffix(" px per image pixel")
                }
            };
            ui.add(value.max_decimals(2)).labelled_by(name.id);
            *choice = choice.with_width(width);
        });
        ui.end_row();
        let unit = if matches!(choice.width, FigureWidth::PxPerPx(_)) { " px" } else { " pt" };
        for (value, label, range, speed) in [
            (&mut choice.font_size, "Letter height", 4.0..=100.0, 0.1),
            (&mut choice.stroke_width, "Line width", 0.1..=20.0, 0.02),
        ] {
            let name = ui.label(label);
            ui.add(DragValue::new(value).range(range).speed(speed).suffix(unit).max_decimals(2)).labelled_by(name.id);
            ui.end_row();
        }
        let rows = [(&mut choice.features, "Features", true), (&mut choice.matches, "Matches", has_matches)];
        for (amount, label, _) in rows.into_iter().filter(|(.., is_there)| *is_there) {
            let name = ui.label(label);
            ui.horizontal(|ui| amount_ui(ui, amount, name.id));
            ui.end_row();
        }
    });
}

fn amount_ui(ui: &mut Ui, amount: &mut FigureAmount, label: egui::Id) {
    let kinds = [
        (FigureAmount::Drawn, "as drawn", "What the window draws: circles of features without dots, lines of matches"),
        (FigureAmount::All, "all", "All that are shown"),
        (FigureAmount::Strongest(100), "strongest", "The strongest features, and the matches of the smallest distance"),
        (FigureAmount::OneOf(10), "one of", "Every so many-th, along the order of strength"),
    ];
    for (kind, name, tip) in kinds {
        let is_on = std::mem::discriminant(amount) == std::mem::discriminant(&kind);
        if ui.selectable_label(is_on, name).on_hover_text(tip).clicked() && !is_on {
            *amount = kind;
        }
    }
    if let FigureAmount::Strongest(number) | FigureAmount::OneOf(number) = amount {
        ui.add(DragValue::new(number).range(1..=1_000_000)).labelled_by(label);
    }
}

/// Longest side, pixels, of the picture in which the bytes of a pixel are measured.
const MEASURED_PX: u32 = 320;

pub fn film_ui(ctx: &egui::Context, is_open: &mut bool, model: Read<'_>, queue: &mut Queue) {
    modal_ui(ctx, is_open, ("film", 380.0, "Film"), |ui| {
        ui.weak("Each picture with its features, numbers, colours, and the response over all of them");
        ui.add_space(6.0);
        let mut film = model.document.film;
        choice_ui(ui, &mut film);
        queue.edit(model.document, Action::SetFilm(film));
        ui.add_space(4.0);
        let picture = model.picture().map(|picture| Itself::from(&picture.plane));
        let found = model.found_of(model.active_side()).map(|found| Itself::from(&found.detection));
        ui.label(kept(ctx, "words of a film", (model.document.film, picture, found), || tell(model)));
        ui.weak("GIF has 256 colours; MP4 is made by the ffmpeg in PATH; PNG is a file for each picture");
        export_row_ui(ui, ActionId::ExportFilmGif, queue, |_| {});
    });
}

fn tell(model: Read<'_>) -> String {
    let Some(film) = model.film_to_export() else {
        return "There is nothing to film: open a burst".to_owned();
    };
    let (count, (width, height)) = (film.steps().len(), film.size());
    let rate = model.document.film.rate;
    let bytes = bytes_per_pixel(model) * count as f64 * f64::from(width * height);
    let (pictures, secs, mb) = (counted(count, "picture"), count as f64 / f64::from(rate), 1e-6 * bytes);
    format!("{pictures} of {width} × {height}, {rate} a second: {secs:.1} s; about {mb:.1} MB as GIF")
}

fn bytes_per_pixel(model: Read<'_>) -> f64 {
    let Some(picture) = model.picture() else { return 0.5 };
    let rgba = crate::plane::display::to_rgba8(&picture.plane, &model.display_of(model.document.focus()));
    let (width, height) = rgba.dimensions();
    let shrink = width.max(height).div_ceil(MEASURED_PX).max(1);
    let small = resize(&rgba, (width / shrink).max(1), (height / shrink).max(1), FilterType::Nearest);
    let bytes = estimated_film_bytes("a.gif".as_ref(), [&small, &small], 1).unwrap_or_default();
    bytes as f64 / f64::from(small.width() * small.height())
}

fn choice_ui(ui: &mut Ui, choice: &mut FilmChoice) {
    for content in FilmContent::ALL {
        let [label, help] = content.words();
        ui.radio_value(&mut choice.content, content, label).on_hover_text(help);
    }
    Grid::new("film numbers").num_columns(2).spacing([12.0, 6.0]).show(ui, |ui| {
        let name = ui.label("Rate");
        ui.add(DragValue::new(&mut choice.rate).range(FILM_RATES).suffix(" a second")).labelled_by(name.id);
        ui.end_row();
        let name = ui.label("Longest side");
        let side = DragValue::new(&mut choice.max_side_px).range(64..=8192).suffix(" px");
        ui.add(side).on_hover_text("Larger pictures are made smaller by a whole number").labelled_by(name.id);
        ui.end_row();
    });
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::apply::bench::open;
    use crate::requests::{PictureKind, PictureRequest};
    use egui::{Rect, pos2};

    #[test]
    fn a_squeezed_pane_is_drawn_with_its_whole_picture() {
        let plane = Arc::new(crate::plane::Plane::from_fn(200, 100, |u, _| u as f32));
        let request = PictureRequest::new(open((200, 100), 3), PictureKind::Frame(0), Default::default());
        let picture = PictureAnswer { request, drawn: plane.clone(), plane, motion: None, preview: None };
        let mut state = PictureState::default();
        state.refresh([Some(&picture), None]);
        assert_eq!(part_in_view(&state), None, "never drawn");
        for (width, is_drawn) in [(400.0, true), (50.0, true), (5.0, false)] {
            // Two points a pixel.
            let visible = Rect::from_min_size(pos2(20.0, 10.0), vec2(0.5 * width, 60.0));
            state.visible_image = Some(visible);
            let pane = Rect::from_min_size(pos2(300.0, 40.0), vec2(width, 120.0));
            state.ui_from_image = Some(crate::app::canvas::RectTransform::new(visible.min, pane.min, 2.0));
            assert_eq!(part_in_view(&state), is_drawn.then_some(visible), "{width}");
        }
    }
}
