//! The panel: controls for everything in the window's state.

use super::chart::Chart;
use super::curve;
use super::rays::Rays;
use super::stage::Stage;
use super::state::{Show, Side, State};
use crate::consume::KEYS;
use crate::scene::{LightKind, Motion, number_of, with_number};
use crate::technique::{Key, REGISTRY, Spec, Values};
use egui::{ComboBox, DragValue, Slider, Ui};
use glam::DVec3;

/// Points.
pub const WIDTH: f32 = 340.0;

/// Pixels of the window that are the panel's.
pub fn pixels(state: &State, scale: f64) -> u32 {
    if state.panel { (f64::from(WIDTH) * scale).ceil() as u32 } else { 0 }
}

/// The picture's pixels in a window of that size.
pub fn picture(state: &State, window: [u32; 2], scale: f64) -> [u32; 2] {
    [window[0].saturating_sub(pixels(state, scale)), window[1]]
}

/// Values that the panel shows beside the state.
pub struct Told<'a> {
    pub scenes: &'a [String],
    pub stage: Option<&'a Stage>,
    pub chart: &'a Chart,
    pub rays: Option<&'a Rays>,
    /// The last error.
    pub lines: &'a [String],
    /// Milliseconds that the host takes for a frame.
    pub host_ms: f64,
}

/// Actions that were asked for by buttons.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pressed {
    Copy,
    Screenshot,
}

/// Draws the panel. What is set in it is set in `state`.
pub fn panel(ui: &mut Ui, state: &mut State, told: &Told) -> Option<Pressed> {
    let mut pressed = None;
    egui::Panel::right("panel").exact_size(WIDTH).resizable(false).show(ui, |ui| {
        egui::ScrollArea::vertical().show(ui, |ui| {
            ui.spacing_mut().slider_width = 130.0;
            ui.horizontal(|ui| {
                for (button, what) in [("copy as command (C)", Pressed::Copy), ("PNG (F12)", Pressed::Screenshot)] {
                    if ui.button(button).clicked() {
                        pressed = Some(what);
                    }
                }
            });
            lines(ui, state, told);
            scene(ui, state, told);
            shown(ui, state, told);
            under_the_pointer(ui, state, told);
            for (i, name) in ["A", "B"].into_iter().enumerate() {
                let path = told.stage.and_then(|stage| stage.path(i)).map(|path| format!(", path {path}"));
                egui::CollapsingHeader::new(format!("{name}: {}{}", state.sides[i].text(), path.unwrap_or_default()))
                    .id_salt(name)
                    .default_open(i == 0)
                    .show(ui, |ui| side(ui, &mut state.sides[i]));
            }
            egui::CollapsingHeader::new("Passes").default_open(true).show(ui, |ui| {
                told.chart.show(ui);
                ui.label(format!("the host's part of a frame {:.2} ms", told.host_ms));
            });
        });
    });
    pressed
}

/// The last error, and how far the reference is.
fn lines(ui: &mut Ui, state: &State, told: &Told) {
    let Some(stage) = told.stage else { return };
    let red = ui.visuals().error_fg_color;
    for line in stage.refused().chain(told.lines.iter().map(String::as_str)) {
        ui.colored_label(red, line);
    }
    if let Some([rows, all]) = stage.truth(state).filter(|[rows, all]| rows < all) {
        ui.add(egui::ProgressBar::new(rows as f32 / all as f32).text(format!("reference: {rows} of {all} rows")));
    }
}

fn scene(ui: &mut Ui, state: &mut State, told: &Told) {
    ui.separator();
    let mut chosen = state.scene.clone();
    ComboBox::from_label("scene").selected_text(&state.scene).width(200.0).show_ui(ui, |ui| {
        for scene in told.scenes {
            ui.selectable_value(&mut chosen, scene.clone(), scene);
        }
    });
    if chosen != state.scene {
        state.choose(&chosen);
    }
    scene_number(ui, state);
    let Some(stage) = told.stage else { return };
    let direction = stage.base().lights.iter().find_map(|light| match light.kind {
        LightKind::Directional { direction } | LightKind::Spot { direction, .. } => Some(direction),
        LightKind::Point { .. } | LightKind::Virtual { .. } => None,
    });
    if let Some(direction) = direction {
        light(ui, state, direction);
    }
    let kinds = stage.base().kinds();
    if kinds.particles || kinds.strands || kinds.splats {
        ui.add(Slider::new(&mut state.extinction, 0.01..=100.0).logarithmic(true).text("extinction ×"));
    }
    if matches!(stage.base().motion, Motion::Fountain(_)) {
        ui.horizontal(|ui| {
            ui.add(Slider::new(&mut state.gravity, 0.0..=3.0).text("gravity ×"));
            if state.attractor.is_some() && ui.button("wander").clicked() {
                state.attractor = None;
            }
        });
        ui.label("ctrl and drag: the attractor");
    }
    if stage.base().motion != Motion::Still {
        ui.horizontal(|ui| {
            ui.add(Slider::new(&mut state.time_s, 0.0..=60.0).text("time, s"));
            ui.checkbox(&mut state.runs, "runs");
        });
    }
}

/// How many particles, lights, … a scene has that can have another number: made once the slider is let go.
fn scene_number(ui: &mut Ui, state: &mut State) {
    let Some((key, now, most)) = number_of(&state.scene) else { return };
    let id = ui.id().with(key);
    let mut number = ui.data(|data| data.get_temp(id)).unwrap_or(now);
    let slider = ui.add(Slider::new(&mut number, 1..=most).logarithmic(true).text(key));
    if slider.dragged() {
        ui.data_mut(|data| data.insert_temp(id, number));
    } else {
        ui.data_mut(|data| data.remove::<u32>(id));
        if number != now {
            state.scene = with_number(&state.scene, number);
        }
    }
}

/// The way that the light travels, as the place where it stands in the sky.
fn light(ui: &mut Ui, state: &mut State, of_scene: DVec3) {
    let to = -state.direction.unwrap_or(of_scene).normalize();
    let (mut azimuth, mut elevation) = (to.y.atan2(to.x).to_degrees(), to.z.asin().to_degrees());
    let turned = ui.add(Slider::new(&mut azimuth, -180.0..=180.0).text("light's azimuth, °")).changed();
    let raised = ui.add(Slider::new(&mut elevation, -89.0..=89.0).text("elevation, °")).changed();
    if turned || raised {
        let (azimuth, elevation) = (azimuth.to_radians(), elevation.to_radians());
        let flat = elevation.cos();
        state.direction = Some(-DVec3::new(flat * azimuth.cos(), flat * azimuth.sin(), elevation.sin()));
    }
}

fn shown(ui: &mut Ui, state: &mut State, told: &Told) {
    ui.separator();
    ui.horizontal_wrapped(|ui| {
        for (word, show) in Show::ALL {
            ui.selectable_value(&mut state.show, show, word);
        }
    });
    ui.horizontal(|ui| {
        ui.checkbox(&mut state.full, "as render shows it");
        if state.full {
            ui.add(Slider::new(&mut state.exposure, -4.0..=4.0).text("stops"));
        }
    });
    match state.show {
        Show::Wipe => drop(ui.add(Slider::new(&mut state.wipe, 0.0..=1.0).text("wipe"))),
        Show::Difference => drop(ui.add(Slider::new(&mut state.gain, 1..=64).text("difference ×"))),
        Show::Slice => drop(ui.add(Slider::new(&mut state.depth, 0.0..=1.0).text("depth in light 0's range"))),
        Show::Steps => {
            if let Some(steps) = told.stage.and_then(Stage::steps) {
                ui.label(steps.to_string());
            }
        }
        Show::A | Show::B | Show::Wireframe => {}
    }
}

/// Rings in the picture: where the attractor is held, and in `script`s, which have no pointer to be seen, what the curve is of.
pub fn rings(ui: &Ui, state: &State, stage: &Stage, script: bool) {
    let painter = ui.ctx().layer_painter(egui::LayerId::background());
    let scale = ui.ctx().pixels_per_point();
    let ring = |at: [f64; 2], radius: f32, colour: egui::Color32| {
        let at = egui::pos2(at[0] as f32, at[1] as f32) / scale;
        painter.circle_stroke(at, radius, egui::Stroke::new(4.0, egui::Color32::BLACK));
        painter.circle_stroke(at, radius, egui::Stroke::new(2.0, colour));
    };
    let size = stage.size();
    if let (Some(at), Ok((.., view))) = (state.attractor, stage.seen()) {
        let (at, depth) = view.project(at);
        if depth > 0.0 {
            ring(at.into(), 9.0, egui::Color32::from_rgb(0xe6, 0x9f, 0x00));
        }
    }
    if state.curve && script {
        let at = state.pointer.unwrap_or(size.map(|side| side / 2));
        ring(at.map(|at| f64::from(at) + 0.5), 5.0, egui::Color32::WHITE);
    }
}

/// The curve of light 0's ray, where it is asked for.
fn under_the_pointer(ui: &mut Ui, state: &mut State, told: &Told) {
    ui.checkbox(&mut state.curve, "curve under the pointer (V)");
    match told.rays.filter(|_| state.curve).map(Rays::last) {
        Some(Some(Ok(found))) => curve::plot(ui, &found),
        Some(Some(Err(error))) => drop(ui.label(error)),
        Some(None) => drop(ui.spinner()),
        None => {}
    }
}

/// What lights a side, and a control for each key of its spec.
fn side(ui: &mut Ui, side: &mut Side) {
    let name = |side: &Side| match side {
        Side::Reference => "reference",
        Side::Technique(spec) => spec.entry.name,
    };
    let is = name(side);
    let mut chosen = is;
    ComboBox::from_label("technique").selected_text(is).show_ui(ui, |ui| {
        ui.selectable_value(&mut chosen, "reference", "reference");
        for entry in REGISTRY {
            ui.selectable_value(&mut chosen, entry.name, entry.name);
        }
    });
    if chosen != is {
        let entry = REGISTRY.iter().find(|entry| entry.name == chosen);
        *side = entry.map_or(Side::Reference, |entry| Side::Technique(Spec::new(entry, KEYS)));
    }
    let Side::Technique(spec) = side else { return };
    let keys: Vec<&'static Key> = spec.keys().filter(|key| !spec.text(*key).is_empty()).collect();
    for key in keys {
        control(ui, spec, key);
    }
}

/// A control for the values of a key.
fn control(ui: &mut Ui, spec: &mut Spec, key: &'static Key) {
    let is = spec.text(key).to_owned();
    let mut value = is.clone();
    ui.horizontal(|ui| {
        match key.values {
            Values::OneOf(words) => {
                let default = Some(&key.default).filter(|default| !words.contains(default));
                ComboBox::from_id_salt(key.name).selected_text(&value).width(110.0).show_ui(ui, |ui| {
                    for word in default.into_iter().chain(words) {
                        ui.selectable_value(&mut value, (*word).to_owned(), *word);
                    }
                });
            }
            Values::Number(low, high) => number(ui, key, &mut value, (low, high), 1),
            Values::Multiple(step, low, high) => number(ui, key, &mut value, (low, high), step),
            Values::Path(_) => {
                let mut text = value.clone();
                // A file is looked for once its name is complete.
                if ui.add(egui::TextEdit::singleline(&mut text).desired_width(110.0)).lost_focus() {
                    value = text;
                }
            }
        }
        ui.label(key.name).on_hover_text(key.about);
    });
    if value != is {
        spec.set(key, &value);
    }
}

/// A number, or the word in its place.
fn number(ui: &mut Ui, key: &Key, value: &mut String, (low, high): (u32, u32), step: u32) {
    let is_word = key.default.parse::<u32>().is_err();
    let mut number = value.parse::<u32>().unwrap_or(low);
    if is_word {
        let mut auto = *value == key.default;
        if ui.checkbox(&mut auto, key.default).changed() {
            *value = if auto { key.default.to_owned() } else { number.to_string() };
        }
        if auto {
            return;
        }
    }
    // While it is dragged nothing is opened anew: that is for the number where it is let go.
    let id = ui.id().with(key.name);
    if let Some(dragged) = ui.data(|data| data.get_temp(id)) {
        number = dragged;
    }
    let speed = f64::from(step).max(f64::from(number) / 64.0);
    let drag = DragValue::new(&mut number).range(low..=high).speed(speed);
    let response = ui.add(drag.update_while_editing(false));
    if response.dragged() {
        ui.data_mut(|data| data.insert_temp(id, number));
    } else if response.changed() || response.drag_stopped() {
        ui.data_mut(|data| data.remove::<u32>(id));
        *value = (number / step * step).max(low).to_string();
    }
}
