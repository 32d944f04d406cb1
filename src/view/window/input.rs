//! Keys and mouse, from a person or from a script.

use super::super::camera;
use super::super::panel;
use super::super::script::{Input, key_name};
use super::super::state::Show;
use super::{Open, View};
use winit::event::{DeviceId, ElementState, MouseButton, MouseScrollDelta, TouchPhase, WindowEvent};
use winit::keyboard::ModifiersState;

impl View {
    /// Performs the action of a key.
    pub(super) fn key(&mut self, key: &str, open: &mut Open) {
        let shown =
            key.strip_prefix('f').and_then(|n| n.parse::<usize>().ok()).and_then(|n| Show::ALL.get(n.wrapping_sub(1)));
        if let Some((_, show)) = shown {
            self.state.show = *show;
        }
        if let (Some(way), Some(stage)) = (camera::way(key), &open.stage) {
            camera::fly(&mut self.state, &stage.base().camera, way);
        }
        match key {
            "f12" => self.files.shoot(None),
            "c" => self.copy(open),
            "x" => self.state.sides.swap(0, 1),
            "v" => self.state.curve = !self.state.curve,
            "r" => (self.state.eye, self.state.target) = (None, None),
            "space" => self.state.runs = !self.state.runs,
            "h" => self.state.panel = !self.state.panel,
            "escape" => self.is_over = true,
            _ => {}
        }
    }

    /// Whether the pointer is over the picture, not the panel.
    fn is_over_picture(&self, open: &Open) -> bool {
        self.pointer[0] < f64::from(panel::picture(&self.state, open.size, open.window.scale_factor())[0])
    }

    /// Moves the camera or the attractor with the mouse.
    fn mouse(&mut self, [x, y]: [f64; 2], open: &Open) {
        let (right, down) = (x - self.pointer[0], y - self.pointer[1]);
        self.pointer = [x, y];
        let (Some(button), Some(stage)) = (self.dragged, &open.stage) else { return };
        let (camera, share) = (&stage.base().camera, 1.0 / f64::from(stage.size()[1]));
        match button {
            MouseButton::Left
                if self.control
                    && camera::pull(&mut self.state, stage.animated(), stage.size(), stage.place([x, y])) => {}
            MouseButton::Left => camera::orbit(&mut self.state, camera, -right * share * 4.0, down * share * 4.0),
            _ => camera::fly(&mut self.state, camera, [-right * share, down * share, 0.0]),
        }
    }

    /// Handles an event, from a person or from a script.
    pub(super) fn event(&mut self, event: &WindowEvent, open: &mut Open) {
        let taken = open.input.on_window_event(&open.window, event);
        // The panel does not show changes that only turn the picture.
        let turns = matches!(event, WindowEvent::CursorMoved { .. }) && self.dragged.is_some();
        self.touched |= !turns || self.state.attractor.is_some() || self.control;
        self.wants |= taken.repaint;
        match event {
            WindowEvent::CloseRequested => self.is_over = true,
            WindowEvent::Resized(_) | WindowEvent::ScaleFactorChanged { .. } => {
                (open.size, self.wants) = (open.window.inner_size().into(), true);
            }
            WindowEvent::DroppedFile(path) => {
                self.state.choose(&path.to_string_lossy());
                self.wants = true;
            }
            WindowEvent::KeyboardInput { event, .. } if event.state == ElementState::Pressed && !taken.consumed => {
                self.key(&key_name(&event.logical_key), open);
                self.wants = true;
            }
            WindowEvent::MouseInput { state, button, .. } => {
                let is_ours = *state == ElementState::Pressed && self.is_over_picture(open);
                self.dragged = is_ours.then_some(*button);
            }
            WindowEvent::ModifiersChanged(modifiers) => self.control = modifiers.state().control_key(),
            WindowEvent::CursorMoved { position, .. } => {
                self.mouse([position.x, position.y], open);
                // A script moves its own pointer.
                if self.state.curve && self.script.is_none() && self.is_over_picture(open) {
                    let at = [position.x, position.y].map(|at| at.max(0.0));
                    self.state.pointer =
                        Some(open.stage.as_ref().map_or(at, |stage| stage.place(at)).map(|at| at as u32));
                    self.wants = true;
                }
                self.wants |= self.dragged.is_some();
            }
            WindowEvent::MouseWheel { delta, .. } if self.is_over_picture(open) => {
                let lines = match delta {
                    MouseScrollDelta::LineDelta(_, y) => f64::from(*y),
                    MouseScrollDelta::PixelDelta(pixels) => pixels.y / 40.0,
                };
                if let Some(stage) = &open.stage {
                    camera::zoom(&mut self.state, &stage.base().camera, 0.9f64.powf(lines));
                }
                self.wants = true;
            }
            _ => {}
        }
    }
}

/// Returns the window event for a script's input.
pub(super) fn event_of(input: Input) -> WindowEvent {
    let device_id = DeviceId::dummy();
    match input {
        Input::Move([x, y]) => WindowEvent::CursorMoved { device_id, position: (x, y).into() },
        Input::Button(is_down, button) => {
            let state = if is_down { ElementState::Pressed } else { ElementState::Released };
            WindowEvent::MouseInput { device_id, state, button }
        }
        Input::Wheel(lines) => {
            let delta = MouseScrollDelta::LineDelta(0.0, lines as f32);
            WindowEvent::MouseWheel { device_id, delta, phase: TouchPhase::Moved }
        }
        Input::Control(is_down) => {
            let held = if is_down { ModifiersState::CONTROL } else { ModifiersState::empty() };
            WindowEvent::ModifiersChanged(held.into())
        }
    }
}
