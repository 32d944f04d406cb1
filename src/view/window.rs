//! The window: its frames, and the actions of keys, mouse and script lines.

use super::chart::Chart;
use super::files::Files;
use super::host::{Host, Said, Ui};
use super::pace::Pace;
use super::panel::{self, Pressed, Told};
use super::rays::{self, Rays};
use super::script::{Script, Step, key_name};
use super::stage::{Stage, is_lost};
use super::state::{Show, State};
use super::{Options, camera, no_display};
use crate::gpu;
use crate::{Error, Result};
use std::sync::Arc;
use std::time::{Duration, Instant};
use winit::application::ApplicationHandler;
use winit::dpi::PhysicalSize;
use winit::event::{ElementState, MouseButton, MouseScrollDelta, WindowEvent};
use winit::event_loop::{ActiveEventLoop, ControlFlow};
use winit::window::{Window, WindowId};

/// How often the window looks whether the reference has got on.
const LOOK: Duration = Duration::from_millis(100);

/// Seconds of a frame under a script.
const FRAME_S: f64 = 1.0 / 30.0;

/// How long a script waits for the window to take on its size.
const GRACE: Duration = Duration::from_secs(3);

/// Everything that exists once the window is open. Fields are dropped in this order.
struct Open {
    stage: Option<Stage>,
    rays: Rays,
    host: Host,
    input: egui_winit::State,
    window: Arc<Window>,
}

pub struct View {
    options: Options,
    state: State,
    /// The last that could be shown.
    good: State,
    script: Option<Script>,
    /// The condition that the script waits for.
    until: Option<Instant>,
    frames_left: u64,
    said: Said,
    open: Option<Open>,
    chart: Chart,
    lines: Vec<String>,
    files: Files,
    /// Drawn since the window opened.
    frames: u64,
    host_ms: f64,
    /// The frames since the last report.
    pace: Pace,
    last: Instant,
    began: Instant,
    /// The window's size as a script has it: none where it is the window's own.
    forced: Option<[u32; 2]>,
    dragged: Option<MouseButton>,
    /// The control key is down.
    control: bool,
    pointer: [f64; 2],
    /// Something is to be drawn.
    wants: bool,
    is_over: bool,
    outcome: Result<()>,
}

impl View {
    pub fn new(options: Options, state: State, script: Option<Script>, said: Said) -> Self {
        Self {
            options,
            good: state.clone(),
            state,
            script,
            until: None,
            frames_left: 0,
            said,
            open: None,
            chart: Chart::default(),
            lines: Vec::new(),
            files: Files::default(),
            frames: 0,
            host_ms: 0.0,
            pace: Pace::default(),
            last: Instant::now(),
            began: Instant::now(),
            forced: None,
            dragged: None,
            control: false,
            pointer: [0.0; 2],
            wants: true,
            is_over: false,
            outcome: Ok(()),
        }
    }

    /// Closes the device, and says how it went.
    pub fn close(mut self) -> Result<()> {
        self.open = None;
        self.outcome
    }

    fn start(&mut self, events: &ActiveEventLoop) -> Result<Open> {
        let [width, height] = self.options.size;
        let size = |scale: f64| PhysicalSize::new(width + panel::pixels(&self.state, scale), height);
        let attributes = Window::default_attributes().with_title("gobo view").with_inner_size(size(1.0));
        let window = Arc::new(events.create_window(attributes).map_err(no_display)?);
        if window.scale_factor() != 1.0 {
            let _ = window.request_inner_size(size(window.scale_factor()));
        }
        let Options { device, validation, messages, .. } = &self.options;
        let host = Host::open(&window, device.as_deref(), *validation, &self.said, messages)?;
        let egui = egui::Context::default();
        let limit = host.context().features().max_image_dimension_2d as usize;
        let scale = Some(window.scale_factor() as f32);
        let input = egui_winit::State::new(egui, egui::ViewportId::ROOT, &window, scale, None, Some(limit));
        // The same device, opened once more.
        let wanted = Some(host.context().features().name.clone());
        let rays = Rays::new(gpu::Options { device: wanted, validation: *validation, messages: messages.clone() });
        Ok(Open { stage: None, rays, host, input, window })
    }

    /// Draws a frame.
    fn frame(&mut self) -> Result<()> {
        let Some(mut open) = self.open.take() else { return Ok(()) };
        let outcome = self.frame_of(&mut open);
        self.open = Some(open);
        outcome
    }

    fn frame_of(&mut self, open: &mut Open) -> Result<()> {
        let start = Instant::now();
        let seconds = if self.script.is_some() { FRAME_S } else { (start - self.last).as_secs_f64().min(0.1) };
        let since = start - self.last;
        self.last = start;
        if self.state.runs {
            self.state.time_s += seconds;
        }
        let window: [u32; 2] = self.forced.unwrap_or_else(|| open.window.inner_size().into());
        let size = panel::picture(&self.state, window, open.window.scale_factor());
        self.load(open, size)?;
        let ui = self.panel(open);
        open.host.resize(window);
        if let Some(stage) = open.stage.as_mut().filter(|_| !window.contains(&0)) {
            stage.resize(size);
        }
        let waited = Instant::now();
        let frame = open.host.begin()?;
        let waited = waited.elapsed();
        if let Some(over) = frame.number.checked_sub(open.host.frames_in_flight()) {
            let passes = open.host.context().times(over);
            self.chart.add(&passes);
            self.pace.passes(&passes);
            match self.files.save(over, open.host.is_blue_first()) {
                // A script's next line may need it.
                Err(error @ Error::Output { .. }) if self.script.is_none() => self.tell(error.to_string()),
                outcome => outcome?,
            }
        }
        if let Some(stage) = &mut open.stage {
            let (host, state) = (&open.host, &self.state);
            match host.record(&frame, |commands| stage.record(host, commands, state)) {
                Ok(()) => self.good = self.state.clone(),
                Err(error @ Error::Input { .. }) => {
                    self.tell(error.to_string());
                    self.state.go_back_to(&self.good);
                }
                Err(error) => return Err(error),
            }
            self.files.read(&self.state, stage, &open.host, &frame)?;
            self.ask(stage, &mut open.rays)?;
        }
        let picture = open.stage.as_ref().and_then(|stage| Some((stage.bytes()?, stage.size())));
        let is_whole = open.stage.as_ref().is_some_and(|stage| stage.is_whole(&self.state));
        let film = self.files.wanted(&open.host, is_whole && !open.rays.is_waiting())?;
        let waited = waited + open.host.end(frame, picture, ui, film.as_ref())?;
        let host = start.elapsed().saturating_sub(waited);
        self.pace.frame(host, since);
        let host_ms = host.as_secs_f64() * 1e3;
        self.host_ms = if self.frames == 0 { host_ms } else { 0.9 * self.host_ms + 0.1 * host_ms };
        if let Some(film) = film {
            open.host.wait();
            self.files.add(&film, open.host.window_size(), open.host.is_blue_first())?;
        }
        self.frames += 1;
        self.frames_left = self.frames_left.saturating_sub(1);
        let (is_drawn, is_whole) = open
            .stage
            .as_ref()
            .map_or((false, false), |stage| (stage.is_drawn(&self.state), stage.is_whole(&self.state)));
        let shoots = self.files.need_frames(is_whole);
        self.wants |= !is_drawn || self.state.runs || shoots || self.frames_left > 0;
        Ok(())
    }

    /// Loads the scene that the state names, where it is another. One that cannot be is a line, and the one before stays.
    fn load(&mut self, open: &mut Open, size: [u32; 2]) -> Result<()> {
        if open.stage.as_ref().is_some_and(|stage| stage.is_of(&self.state)) {
            return Ok(());
        }
        match Stage::new(open.host.context(), &self.state, size) {
            Ok(stage) => {
                open.stage = Some(stage);
                if !self.options.scenes.contains(&self.state.scene) {
                    self.options.scenes.push(self.state.scene.clone());
                }
            }
            Err(error) if open.stage.is_none() || is_lost(&error) => return Err(error),
            Err(error) => {
                self.tell(error.to_string());
                self.state.go_back_to(&self.good);
            }
        }
        Ok(())
    }

    fn panel(&mut self, open: &mut Open) -> Ui {
        let input = open.input.take_egui_input(&open.window);
        let (context, mut pressed) = (open.input.egui_ctx().clone(), None);
        let (state, stage, script) = (&mut self.state, open.stage.as_ref(), self.script.is_some());
        let told = Told {
            scenes: &self.options.scenes,
            stage,
            chart: &self.chart,
            rays: Some(&open.rays),
            lines: &self.lines,
            host_ms: self.host_ms,
        };
        let output = context.run_ui(input, |ui| {
            if let Some(stage) = stage {
                panel::rings(ui, state, stage, script);
            }
            if state.panel {
                pressed = panel::panel(ui, state, &told);
            }
        });
        open.input.handle_platform_output(&open.window, output.platform_output);
        let delay = output.viewport_output.get(&egui::ViewportId::ROOT).map(|viewport| viewport.repaint_delay);
        self.wants |= delay.is_some_and(|delay| delay.is_zero());
        match pressed {
            Some(Pressed::Copy) => self.copy(open),
            Some(Pressed::Screenshot) => self.files.shoot(None),
            None => {}
        }
        let pixels_per_point = output.pixels_per_point;
        let primitives = context.tessellate(output.shapes, pixels_per_point);
        Ui { textures: output.textures_delta, primitives, pixels_per_point }
    }

    /// Prints a line to the panel, and to standard error.
    fn tell(&mut self, line: String) {
        eprintln!("gobo view: {line}");
        self.lines.push(line);
        if self.lines.len() > 3 {
            self.lines.remove(0);
        }
    }

    /// Copies the command, and prints it.
    fn copy(&self, open: &mut Open) {
        let size = open.stage.as_ref().map_or(self.options.size, Stage::size);
        let faces = open.stage.as_ref().is_some_and(|stage| stage.base().lights[0].map_count() > 1);
        let mut lines = self.state.commands(size, faces);
        if let Some(Ok(found)) = open.rays.answer() {
            lines.push(self.state.curve_command(found.texel, found.face, &rays::specs(&self.state)));
        }
        let text = lines.join("\n");
        println!("{text}");
        open.input.egui_ctx().copy_text(text);
    }

    /// Asks for the curve under the pointer where it is shown, and writes it where that is wanted.
    fn ask(&mut self, stage: &Stage, rays: &mut Rays) -> Result<()> {
        if !self.state.curve {
            rays.rest();
            return Ok(());
        }
        let (version, scene, camera) = stage.seen()?;
        rays.ask(&self.state, version, scene, camera);
        self.files.save_plot(rays)
    }

    /// Does the action of a key.
    fn key(&mut self, key: &str, open: &mut Open) {
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

    /// Does the script's next lines, as far as nothing has to be waited for.
    fn script(&mut self) -> Result<()> {
        let Some(mut open) = self.open.take() else { return Ok(()) };
        let outcome = self.script_on(&mut open);
        self.open = Some(open);
        outcome
    }

    fn script_on(&mut self, open: &mut Open) -> Result<()> {
        loop {
            let window: [u32; 2] = open.window.inner_size().into();
            let wants = self.options.size;
            let fits =
                self.forced.is_some() || panel::picture(&self.state, window, open.window.scale_factor()) == wants;
            if !fits && self.began.elapsed() < GRACE
                || self.frames_left > 0
                || self.files.are_due()
                || self.frames == 0
                || self.until.is_some_and(|until| Instant::now() < until)
            {
                return Ok(());
            }
            let Some(step) = self.script.as_mut().and_then(Script::next) else { return Ok(()) };
            self.until = None;
            match step {
                Step::Set(key, value) => self.state.set(&key, &value)?,
                Step::Key(key) => self.key(&key, open),
                Step::Orbit(right, up) => {
                    if let Some(stage) = &open.stage {
                        camera::orbit(&mut self.state, &stage.base().camera, right, up);
                    }
                }
                Step::Wait(time) => self.until = Some(Instant::now() + time),
                Step::Frames(count) => self.frames_left = count,
                Step::Screenshot(path) => self.files.shoot(Some(path)),
                Step::Gif(path, ms) => self.files.film(&path, ms),
                Step::Curve(path) => {
                    self.state.curve = true;
                    self.files.plot(path);
                }
                Step::Resize([0, _] | [_, 0]) => (self.forced, self.frames_left) = (Some([0; 2]), 2),
                Step::Resize(size) => {
                    (self.forced, self.options.size, self.began) = (None, size, Instant::now());
                    let panel = panel::pixels(&self.state, open.window.scale_factor());
                    let _ = open.window.request_inner_size(PhysicalSize::new(size[0] + panel, size[1]));
                }
                Step::Drop(file) => self.state.choose(&file),
                Step::Report => {
                    let (frames, bytes) = (self.frames, open.host.allocated_bytes());
                    let lowest = std::mem::take(&mut self.pace).text();
                    println!("{frames} frames, {bytes} bytes of device memory{lowest}");
                }
                Step::Quit => {
                    self.is_over = true;
                    self.files.finish()?;
                }
            }
            self.wants = true;
            if self.is_over {
                return Ok(());
            }
        }
    }

    /// Ends with an error where there is one.
    fn check(&mut self, events: &ActiveEventLoop, outcome: Result<()>) {
        if let Err(error) = outcome {
            (self.outcome, self.is_over) = (Err(error), true);
        }
        if self.is_over {
            events.exit();
        }
    }

    /// Whether the pointer is not over the panel.
    fn is_over_picture(&self, open: &Open) -> bool {
        let window: [u32; 2] = open.window.inner_size().into();
        self.pointer[0] < f64::from(panel::picture(&self.state, window, open.window.scale_factor())[0])
    }

    /// The mouse moves the camera.
    fn mouse(&mut self, [x, y]: [f64; 2], open: &Open) {
        let (right, down) = (x - self.pointer[0], y - self.pointer[1]);
        self.pointer = [x, y];
        let (Some(button), Some(stage)) = (self.dragged, &open.stage) else { return };
        let (camera, share) = (&stage.base().camera, 1.0 / f64::from(stage.size()[1]));
        match button {
            MouseButton::Left if self.control && camera::pull(&mut self.state, stage.base(), stage.size(), [x, y]) => {}
            MouseButton::Left => camera::orbit(&mut self.state, camera, -right * share * 4.0, down * share * 4.0),
            _ => camera::fly(&mut self.state, camera, [-right * share, down * share, 0.0]),
        }
    }
}

impl ApplicationHandler for View {
    fn resumed(&mut self, events: &ActiveEventLoop) {
        if self.open.is_none() {
            let outcome = self.start(events).map(|open| self.open = Some(open));
            self.check(events, outcome);
        }
    }

    fn window_event(&mut self, events: &ActiveEventLoop, _: WindowId, event: WindowEvent) {
        let Some(mut open) = self.open.take() else { return };
        if matches!(event, WindowEvent::RedrawRequested) {
            self.open = Some(open);
            self.wants = false;
            let outcome = self.frame();
            self.check(events, outcome);
            return;
        }
        let taken = open.input.on_window_event(&open.window, &event);
        self.wants |= taken.repaint;
        match event {
            WindowEvent::CloseRequested => self.is_over = true,
            WindowEvent::Resized(_) | WindowEvent::ScaleFactorChanged { .. } => self.wants = true,
            WindowEvent::DroppedFile(path) => {
                self.state.choose(&path.to_string_lossy());
                self.wants = true;
            }
            WindowEvent::KeyboardInput { event, .. } if event.state == ElementState::Pressed && !taken.consumed => {
                self.key(&key_name(&event.logical_key), &mut open);
                self.wants = true;
            }
            WindowEvent::MouseInput { state, button, .. } => {
                let is_ours = state == ElementState::Pressed && self.is_over_picture(&open);
                self.dragged = is_ours.then_some(button);
            }
            WindowEvent::ModifiersChanged(modifiers) => self.control = modifiers.state().control_key(),
            WindowEvent::CursorMoved { position, .. } => {
                self.mouse([position.x, position.y], &open);
                // A script has a pointer of its own.
                if self.state.curve && self.script.is_none() && self.is_over_picture(&open) {
                    self.state.pointer = Some([position.x, position.y].map(|at| at.max(0.0) as u32));
                    self.wants = true;
                }
                self.wants |= self.dragged.is_some();
            }
            WindowEvent::MouseWheel { delta, .. } if self.is_over_picture(&open) => {
                let lines = match delta {
                    MouseScrollDelta::LineDelta(_, y) => f64::from(y),
                    MouseScrollDelta::PixelDelta(pixels) => pixels.y / 40.0,
                };
                if let Some(stage) = &open.stage {
                    camera::zoom(&mut self.state, &stage.base().camera, 0.9f64.powf(lines));
                }
                self.wants = true;
            }
            _ => {}
        }
        self.open = Some(open);
        self.check(events, Ok(()));
    }

    fn about_to_wait(&mut self, events: &ActiveEventLoop) {
        if self.script.is_some() {
            let outcome = self.script();
            self.check(events, outcome);
        }
        let Some(open) = &self.open else { return };
        if self.forced.is_some() && self.wants {
            // A window without an area is not drawn, and frames go on.
            self.wants = false;
            let outcome = self.frame();
            self.check(events, outcome);
            events.set_control_flow(ControlFlow::Poll);
            return;
        }
        // The reference gets on by itself.
        let fills = open.stage.as_ref().is_some_and(|stage| !stage.is_whole(&self.state))
            || open.rays.is_waiting()
            || self.files.are_due();
        self.wants |= fills && self.last.elapsed() >= LOOK;
        if self.wants {
            open.window.request_redraw();
        }
        events.set_control_flow(match () {
            () if self.script.is_some() => ControlFlow::WaitUntil(Instant::now() + Duration::from_millis(5)),
            () if fills => ControlFlow::WaitUntil(Instant::now() + LOOK),
            () => ControlFlow::Wait,
        });
    }
}
