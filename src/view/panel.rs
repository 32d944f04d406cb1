//! The panel: controls for everything in the window's state.

use super::chart::Chart;
use super::curve;
use super::rays::Rays;
use super::stage::Stage;
use super::state::{Show, Side, State};
use crate::scene::{LightKind, number_of, with_number};
use crate::shading::KEYS;
use crate::technique::{Key, REGISTRY, Spec, Values};
use egui::{ComboBox, DragValue, Slider, Ui};
use glam::DVec3;

/// Width of the panel, in points.
pub const WIDTH: f32 = 340.0;

/// Returns the width that the panel takes from the window, in pixels.
pub fn pixels(state: &State, scale: f64) -> u32 {
    if state.panel { (f64::from(WIDTH) * scale).ceil() as u32 } else { 0 }
}

/// Returns the size of the picture in a window of size `window`, in pixels.
pub fn picture(state: &State, window: [u32; 2], scale: f64) -> [u32; 2] {
    [window[0].saturating_sub(pixels(state, scale)), window[1]]
}

/// Values that the panel shows in addition to the state.
pub struct PanelText<'a> {
    pub scenes: &'a [String],
    pub stage: Option<&'a Stage>,
    pub chart: &'a Chart,
    pub rays: Option<&'a Rays>,
    /// Lines with the latest errors.
    pub lines: &'a [String],
    /// Milliseconds of host time per frame.
    pub host_ms: f64,
}

/// Actions requested by buttons.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PanelAction {
    Copy,
    Screenshot,
}

/// Draws the panel. Its controls change `state`.
pub fn panel(ui: &mut Ui, state: &mut State, told: &PanelText) -> Option<PanelAction> {
    let mut pressed = None;
    egui::Panel::right("panel").exact_size(WIDTH).resizable(false).show(ui, |ui| {
        egui::ScrollArea::vertical().show(ui, |ui| {
            ui.spacing_mut().slider_width = 130.0;
            ui.horizontal(|ui| {
                for (button, what) in
                    [("copy as command (C)", PanelAction::Copy), ("PNG (F12)", PanelAction::Screenshot)]
                {
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

/// Shows the latest errors, and the progress of the reference in rows.
fn lines(ui: &mut Ui, state: &State, told: &PanelText) {
    let Some(stage) = told.stage else { return };
    let red = ui.visuals().error_fg_color;
    for line in stage.refused().chain(told.lines.iter().map(String::as_str)) {
        ui.colored_label(red, line);
    }
    if let Some([rows, all]) = stage.truth(state).filter(|[rows, all]| rows < all) {
        ui.add(egui::ProgressBar::new(rows as f32 / all as f32).text(format!("reference: {rows} of {all} rows")));
    }
}

fn scene(ui: &mut Ui, state: &mut State, told: &PanelText) {
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
    if stage.animated().fountain().is_some() {
        ui.horizontal(|ui| {
            ui.add(Slider::new(&mut state.gravity, 0.0..=3.0).text("gravity ×"));
            if state.attractor.is_some() && ui.button("wander").clicked() {
                state.attractor = None;
            }
        });
        ui.label("ctrl and drag: the attractor");
    }
    if stage.animated().moves() {
        ui.horizontal(|ui| {
            ui.add(Slider::new(&mut state.time_s, 0.0..=60.0).text("time, s"));
            ui.checkbox(&mut state.runs, "runs");
        });
    }
}

/// Shows a slider for the number of particles, lights and so on, if the scene has such a number. The scene is loaded when the slider is
/// released.
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

/// Shows sliders for the direction of the light, as the light's position in the sky.
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

fn shown(ui: &mut Ui, state: &mut State, told: &PanelText) {
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
        Show::Difference | Show::Beside => drop(ui.add(Slider::new(&mut state.gain, 1..=64).text("difference ×"))),
        Show::Slice => {
            let lights = told.stage.map_or(1, |stage| stage.base().lights.len());
            if lights > 1 {
                let names = told.stage.map(|stage| stage.base()).filter(|scene| scene.colors() > 1);
                let color =
                    names.map_or("", |scene| [" in red", " in green", " in blue"][scene.color_of_light(state.light)]);
                ui.add(Slider::new(&mut state.light, 0..=lights - 1).text(format!("light{color}")));
            }
            ui.add(Slider::new(&mut state.depth, 0.0..=1.0).text("depth in the light's range"));
        }
        Show::Steps => {
            if let Some(steps) = told.stage.and_then(Stage::steps) {
                ui.label(steps.to_string());
            }
        }
        Show::A | Show::B | Show::Wireframe => {}
    }
}

/// Draws rings in the picture: one at the attractor while it is held and, under a `script`, where no pointer is visible, one at the pixel
/// whose curve is shown.
pub fn rings(ui: &Ui, state: &State, stage: &Stage, script: bool) {
    let painter = ui.ctx().layer_painter(egui::LayerId::background());
    let scale = ui.ctx().pixels_per_point();
    let ring = |at: [f64; 2], radius: f32, color: egui::Color32| {
        let at = egui::pos2(at[0] as f32, at[1] as f32) / scale;
        painter.circle_stroke(at, radius, egui::Stroke::new(4.0, egui::Color32::BLACK));
        painter.circle_stroke(at, radius, egui::Stroke::new(2.0, color));
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

/// Draws the names of the pictures that stand side by side.
pub fn labels(ui: &Ui, state: &State, stage: &Stage) {
    if state.show != Show::Beside {
        return;
    }
    let painter = ui.ctx().layer_painter(egui::LayerId::background());
    let [a, b] = [0, 1].map(|i| state.sides[i].text());
    let reference = match stage.truth(state) {
        Some([rows, all]) if rows < all => format!("reference: {rows} of {all} rows"),
        _ => "reference".into(),
    };
    let gain = state.gain;
    let texts = [
        [format!("A: {a}"), reference, format!("B: {b}")],
        [format!("error of A × {gain}"), format!("A and B apart × {gain}"), format!("error of B × {gain}")],
    ];
    let size = stage.size().map(|side| side as f32 / ui.ctx().pixels_per_point());
    for (y, texts) in (0..).zip(texts) {
        for (x, text) in (0..).zip(texts) {
            let (color, width) = (egui::Color32::WHITE, size[0] - 8.0);
            let galley = painter.layout(text, egui::FontId::proportional(13.0), color, width);
            let at = egui::pos2(x as f32 * size[0] + 4.0, y as f32 * size[1] + 4.0);
            let behind = egui::Rect::from_min_size(at, galley.size()).expand(2.0);
            painter.rect_filled(behind, 2.0, egui::Color32::from_black_alpha(160));
            painter.galley(at, galley, color);
        }
    }
}

/// Shows the curve of light 0's ray and the seen errors, if requested.
fn under_the_pointer(ui: &mut Ui, state: &mut State, told: &PanelText) {
    ui.checkbox(&mut state.curve, "curve under the pointer (V)");
    match told.rays.filter(|_| state.curve).map(Rays::last) {
        Some(Some(Ok(found))) => curve::plot(ui, &found),
        Some(Some(Err(error))) => drop(ui.label(error)),
        Some(None) => drop(ui.spinner()),
        None => {}
    }
    for (name, seen) in told.rays.filter(|_| state.curve).map(Rays::seen).iter().flat_map(|seen| seen.iter()) {
        ui.label(format!("{name}: {}", seen.words()));
    }
}

/// Shows the technique or the reference of a side, with a control for each key of its spec.
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

/// Shows a control that sets a key of a spec.
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
                // The file is opened once its name is complete.
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

/// Shows a field for a number, with a check box for the word that the key may have instead.
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
    // No technique is opened while the number is being dragged, only once it is released.
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

#[cfg(test)]
mod tests {
    use super::*;
    use egui::{Event, Modifiers, PointerButton, Pos2, RawInput, Rect, Shape, pos2, vec2};

    /// A panel without a window, and a simulated hand that uses it.
    struct Hand {
        context: egui::Context,
        state: State,
        chart: Chart,
        pressed: Option<PanelAction>,
    }

    impl Hand {
        fn new() -> Self {
            let mut state = State::new("plume_8k", 20.0, None);
            for (key, value) in [("a", "avsm:size=256"), ("show", "wipe")] {
                state.set(key, value).expect(key);
            }
            let mut hand = Self { context: egui::Context::default(), state, chart: Chart::default(), pressed: None };
            // The first frames determine the sizes of all widgets, then their positions.
            (0..3).for_each(|_| drop(hand.frame(Vec::new())));
            hand
        }

        /// Draws a frame with these input events. Returns the texts in the frame, with their rectangles.
        fn frame(&mut self, events: Vec<Event>) -> Vec<(String, Rect)> {
            let screen = Rect::from_min_size(Pos2::ZERO, vec2(800.0, 1400.0));
            let input = RawInput { screen_rect: Some(screen), events, ..RawInput::default() };
            let (state, pressed, scenes) = (&mut self.state, &mut self.pressed, ["plume_8k".to_owned()]);
            let told =
                PanelText { scenes: &scenes, stage: None, chart: &self.chart, rays: None, lines: &[], host_ms: 0.0 };
            let output = self.context.run_ui(input, |ui| *pressed = pressed.or(panel(ui, state, &told)));
            fn texts(shape: &Shape, into: &mut Vec<(String, Rect)>) {
                match shape {
                    Shape::Text(text) => into.push((text.galley.text().to_owned(), text.visual_bounding_rect())),
                    Shape::Vec(shapes) => shapes.iter().for_each(|shape| texts(shape, into)),
                    _ => {}
                }
            }
            let mut all = Vec::new();
            output.shapes.iter().for_each(|clipped| texts(&clipped.shape, &mut all));
            all
        }

        /// Returns the position of the last occurrence of `text`.
        #[track_caller]
        fn find(&mut self, text: &str) -> Pos2 {
            let all = self.frame(Vec::new());
            let found = all.iter().rfind(|(is, _)| is == text).map(|(_, place)| place.center());
            found.unwrap_or_else(|| panic!("no {text} in {all:?}"))
        }

        /// Returns the centre of the rail of the slider with that name. The name and the slider's number are in one row, and the rail is to
        /// the left of the number.
        #[track_caller]
        fn rail(&mut self, name: &str) -> Pos2 {
            let at = self.find(name);
            let in_row = |place: &Rect| (place.center().y - at.y).abs() < 5.0;
            let all = self.frame(Vec::new());
            let mut numbers = all.iter().filter(|(text, place)| text.parse::<f64>().is_ok() && in_row(place));
            let number = numbers.next_back().unwrap_or_else(|| panic!("no number by {name} in {all:?}")).1;
            pos2(number.left() - 85.0, at.y)
        }

        fn button(&mut self, pos: Pos2, pressed: bool) {
            let (button, modifiers) = (PointerButton::Primary, Modifiers::NONE);
            self.frame(vec![Event::PointerMoved(pos), Event::PointerButton { pos, button, pressed, modifiers }]);
        }

        #[track_caller]
        fn click(&mut self, text: &str) {
            let at = self.find(text);
            self.button(at, true);
            self.button(at, false);
            // An opened list appears one frame later.
            self.frame(Vec::new());
        }

        fn drag(&mut self, from: Pos2, by: f32) {
            self.button(from, true);
            for share in [0.25, 0.5, 0.75, 1.0] {
                self.frame(vec![Event::PointerMoved(pos2(from.x + share * by, from.y))]);
            }
            self.button(pos2(from.x + by, from.y), false);
        }

        fn spec(&self, side: usize) -> String {
            self.state.sides[side].text()
        }
    }

    /// A widget of each kind, used with a pointer, must set the value that it names, and nothing else may change.
    #[test]
    fn widgets_set_what_they_say() {
        let mut hand = Hand::new();
        let before = (hand.state.full, hand.state.wipe, hand.spec(0));
        hand.frame(vec![Event::PointerMoved(pos2(5.0, 5.0))]);
        assert_eq!((hand.state.full, hand.state.wipe, hand.spec(0)), before, "a pointer elsewhere sets nothing");
        // A check box.
        hand.click("as render shows it");
        assert!(hand.state.full);
        hand.click("as render shows it");
        assert!(!hand.state.full);
        // A slider, dragged by its rail.
        let rail = hand.rail("wipe");
        hand.drag(rail, -50.0);
        let low = hand.state.wipe;
        assert!(low < 0.35, "{low}");
        hand.drag(rail, 30.0);
        assert!(hand.state.wipe > low + 0.2, "{} {low}", hand.state.wipe);
        // One of several words.
        hand.click("difference");
        assert_eq!(hand.state.show, Show::Difference);
        // A list.
        hand.click("avsm");
        let listed = hand.frame(Vec::new());
        let is_listed = |name: &&str| *name != "avsm" && listed.iter().any(|(text, _)| text == name);
        let other = REGISTRY.iter().map(|entry| entry.name).find(is_listed).expect("a list");
        hand.click(other);
        assert_eq!(hand.spec(0), other);
        // A number that is dragged: it is set on release.
        hand.state.set("a", "psm:size=300").expect("known");
        let size = hand.find("300");
        hand.drag(size, 30.0);
        let text = hand.spec(0);
        let dragged: u32 =
            text.split("size=").nth(1).and_then(|s| s.split(',').next()).and_then(|n| n.parse().ok()).expect(&text);
        assert!(dragged > 300, "{text}");
        // Buttons.
        assert_eq!(hand.pressed, None);
        hand.click("copy as command (C)");
        assert_eq!(hand.pressed.take(), Some(PanelAction::Copy));
        hand.click("PNG (F12)");
        assert_eq!(hand.pressed, Some(PanelAction::Screenshot));
    }
}
