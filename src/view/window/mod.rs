//! The window and its frames. Keys and the mouse are handled in `input`, the lines of a script in `scripted`.

mod input;
mod scripted;

use super::chart::Chart;
use super::files::Files;
use super::host::{Host, HostMessages, Ui};
use super::pace::Pace;
use super::panel::{self, PanelAction, PanelText};
use super::rays::{self, Rays};
use super::script::Script;
use super::stage::{Stage, is_lost};
use super::state::State;
use super::{Options, no_display};
use crate::gpu;
use crate::{Error, Result};
use std::sync::Arc;
use std::time::{Duration, Instant};
use winit::application::ApplicationHandler;
use winit::dpi::PhysicalSize;
use winit::event::{MouseButton, WindowEvent};
use winit::event_loop::{ActiveEventLoop, ControlFlow};
use winit::window::{Window, WindowId};

/// Time between two checks for new rows of the reference.
const LOOK: Duration = Duration::from_millis(100);

/// Maximum age of the panel while pictures change on their own: laying it out takes longer than recording most frames. If fewer than
/// [`KEPT_FRAMES`] frames fit into this time, the maximum age is [`OLDEST`].
const REFRESH: Duration = Duration::from_millis(250);
const KEPT_FRAMES: u64 = 8;
const OLDEST: Duration = Duration::from_secs(1);

/// Seconds per frame under a script.
const FRAME_S: f64 = 1.0 / 30.0;

/// The device is not reopened after more than `MOST_LOSSES` losses in a row, each within `FEW_FRAMES` frames of the last.
const MOST_LOSSES: u32 = 3;
const FEW_FRAMES: u64 = 30;

/// Everything that exists while the window is open. Fields drop in this order.
struct Open {
    stage: Option<Stage>,
    rays: Rays,
    host: Host,
    input: egui_winit::State,
    window: Arc<Window>,
    /// Size of the window, in pixels, tracked here because X11 is queried only once.
    size: [u32; 2],
    /// The panel as last laid out, with the time and the frame of that layout.
    panel: Option<(Ui, Instant, u64)>,
}

pub struct View {
    options: Options,
    state: State,
    /// Last state that could be shown.
    good: State,
    script: Option<Script>,
    /// Time until which the script waits.
    until: Option<Instant>,
    frames_left: u64,
    said: HostMessages,
    open: Option<Open>,
    chart: Chart,
    lines: Vec<String>,
    files: Files,
    /// Number of frames drawn since the window opened.
    frames: u64,
    /// Number of times in a row that the device was lost, and the frame in which it was last lost.
    losses: u32,
    lost_at: u64,
    host_ms: f64,
    /// Frames since the last report.
    pace: Pace,
    last: Instant,
    began: Instant,
    /// Window size set by a script; `None` if the window has its own size.
    forced: Option<[u32; 2]>,
    dragged: Option<MouseButton>,
    /// Whether the control key is down.
    control: bool,
    pointer: [f64; 2],
    /// Whether something must be drawn.
    wants: bool,
    /// Whether the panel may have to change.
    touched: bool,
    /// Whether the panel shows an older frame's values.
    is_behind: bool,
    is_over: bool,
    outcome: Result<()>,
}

impl View {
    pub fn new(options: Options, state: State, script: Option<Script>, said: HostMessages) -> Self {
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
            losses: 0,
            lost_at: 0,
            host_ms: 0.0,
            pace: Pace::default(),
            last: Instant::now(),
            began: Instant::now(),
            forced: None,
            dragged: None,
            control: false,
            pointer: [0.0; 2],
            wants: true,
            touched: true,
            is_behind: false,
            is_over: false,
            outcome: Ok(()),
        }
    }

    /// Closes the device and returns the outcome.
    pub fn close(mut self) -> Result<()> {
        self.files.forget_copies();
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
        self.open_on(window)
    }

    /// Opens the device for an existing window.
    fn open_on(&self, window: Arc<Window>) -> Result<Open> {
        let Options { device, validation, messages, .. } = &self.options;
        let host = Host::open(&window, device.as_deref(), *validation, &self.said, messages)?;
        let egui = egui::Context::default();
        let limit = host.context().features().max_image_dimension_2d as usize;
        let scale = Some(window.scale_factor() as f32);
        let input = egui_winit::State::new(egui, egui::ViewportId::ROOT, &window, scale, None, Some(limit));
        // Opens the same device a second time, for the rays.
        let wanted = Some(host.context().features().name.clone());
        let rays = Rays::new(gpu::Options { device: wanted, validation: *validation, messages: messages.clone() });
        let size = window.inner_size().into();
        Ok(Open { stage: None, rays, host, input, window, size, panel: None })
    }

    /// Draws a frame.
    fn frame(&mut self) -> Result<()> {
        let Some(mut open) = self.open.take() else { return Ok(()) };
        match self.frame_of(&mut open) {
            Err(error) if is_lost(&error) => self.go_on_without(open, error),
            outcome => {
                self.open = Some(open);
                outcome
            }
        }
    }

    /// Reopens the device after it was lost, and everything on it. The loss is shown as a line, and the window continues, unless the device
    /// is lost too often.
    fn go_on_without(&mut self, lost: Open, error: Error) -> Result<()> {
        self.losses = if self.frames - self.lost_at < FEW_FRAMES { self.losses + 1 } else { 1 };
        self.lost_at = self.frames;
        if self.losses > MOST_LOSSES {
            return Err(error);
        }
        self.tell(format!("the device is opened anew: {error}"));
        let window = lost.window.clone();
        self.files.forget_copies();
        // The old surface must be destroyed first: a window has one surface at a time.
        drop(lost);
        self.pace = Pace::default();
        self.open = Some(self.open_on(window)?);
        self.wants = true;
        Ok(())
    }

    fn frame_of(&mut self, open: &mut Open) -> Result<()> {
        let start = Instant::now();
        let seconds = if self.script.is_some() { FRAME_S } else { (start - self.last).as_secs_f64().min(0.1) };
        let since = start - self.last;
        self.last = start;
        self.pace.next(since);
        if self.state.runs {
            self.state.time_s += seconds;
        }
        let window = self.forced.unwrap_or(open.size);
        let size = panel::picture(&self.state, window, open.window.scale_factor());
        self.load(open, size)?;
        let ui = self.panel(open);
        open.host.resize(window);
        if let Some(stage) = open.stage.as_mut().filter(|_| !window.contains(&0)) {
            stage.resize(self.state.show, size);
        }
        let waited = Instant::now();
        let frame = open.host.begin()?;
        let waited = waited.elapsed();
        if let Some(over) = frame.number.checked_sub(open.host.frames_in_flight()) {
            let passes = open.host.context().times(over);
            self.chart.add(&passes);
            self.pace.passes(over, &passes);
            match self.files.save(over, open.host.is_blue_first()) {
                // For a script this is an error, since its next line may need the file.
                Err(error @ Error::Output { .. }) if self.script.is_none() => self.tell(error.to_string()),
                outcome => outcome?,
            }
        }
        if let Some(stage) = &mut open.stage {
            let (host, state) = (&open.host, &self.state);
            match host.record(&frame, |commands| stage.record(host, commands, state)) {
                Ok(()) => self.good = self.state.clone(),
                Err(error @ (Error::Input { .. } | Error::Usage { .. })) => {
                    self.tell(error.to_string());
                    self.state.go_back_to(&self.good);
                }
                Err(error) => return Err(error),
            }
            self.files.read(&self.state, stage, &open.host, &frame)?;
            self.ask(stage, &mut open.rays)?;
        }
        let picture = open.stage.as_ref().and_then(|stage| Some((stage.bytes()?, stage.area())));
        let is_whole = open.stage.as_ref().is_some_and(|stage| stage.is_whole(&self.state));
        let number = frame.number;
        let film = self.files.wanted(&open.host, is_whole && !open.rays.is_waiting())?;
        let waited = waited + open.host.end(frame, picture, ui, film.as_ref())?;
        let host = start.elapsed().saturating_sub(waited);
        self.pace.frame(number, host);
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

    /// Loads the scene that the state names, if it has changed. A scene that cannot be loaded produces a line, and the previous scene
    /// stays.
    fn load(&mut self, open: &mut Open, size: [u32; 2]) -> Result<()> {
        if open.stage.as_ref().is_some_and(|stage| stage.is_of(&self.state)) {
            return Ok(());
        }
        match Stage::new(open.host.context(), &self.state, size) {
            Ok(stage) => {
                stage.animated().notes.iter().for_each(|note| self.tell(format!("note: {note}")));
                (open.stage, self.touched) = (Some(stage), true);
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

    /// Returns what egui draws: the previous panel if nothing in it was touched and it is recent.
    fn panel(&mut self, open: &mut Open) -> Ui {
        let is_fresh = |at: &Instant, frame: u64| {
            let age = at.elapsed();
            age < REFRESH || age < OLDEST && self.frames - frame < KEPT_FRAMES
        };
        let kept = open.panel.as_ref().filter(|_| !self.touched && !self.files.are_due());
        let kept = kept.filter(|(_, at, frame)| is_fresh(at, *frame));
        self.is_behind = kept.is_some();
        if let Some((ui, ..)) = kept {
            return ui.clone();
        }
        self.touched = false;
        let input = open.input.take_egui_input(&open.window);
        let (context, mut pressed) = (open.input.egui_ctx().clone(), None);
        let (state, stage, script) = (&mut self.state, open.stage.as_ref(), self.script.is_some());
        let told = PanelText {
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
                panel::labels(ui, state, stage);
            }
            if state.panel {
                pressed = panel::panel(ui, state, &told);
            }
        });
        open.input.handle_platform_output(&open.window, output.platform_output);
        let delay = output.viewport_output.get(&egui::ViewportId::ROOT).map(|viewport| viewport.repaint_delay);
        self.touched |= delay.is_some_and(|delay| delay.is_zero());
        self.wants |= self.touched;
        match pressed {
            Some(PanelAction::Copy) => self.copy(open),
            Some(PanelAction::Screenshot) => self.files.shoot(None),
            None => {}
        }
        let pixels_per_point = output.pixels_per_point;
        let primitives = context.tessellate(output.shapes, pixels_per_point).into();
        let ui = Ui { textures: Default::default(), primitives, pixels_per_point };
        open.panel = Some((ui.clone(), Instant::now(), self.frames));
        Ui { textures: output.textures_delta, ..ui }
    }

    /// Shows a line in the panel, and prints it to standard error.
    fn tell(&mut self, line: String) {
        self.touched = true;
        eprintln!("gobo view: {line}");
        self.lines.push(line);
        if self.lines.len() > 3 {
            self.lines.remove(0);
        }
    }

    /// Copies the command to the clipboard, and prints it.
    fn copy(&self, open: &mut Open) {
        let size = open.stage.as_ref().map_or(self.options.size, |stage| stage.size_of(&self.state));
        let light = open.stage.as_ref().and_then(|stage| stage.base().lights.get(self.state.light));
        let faces = light.is_some_and(|light| light.map_count() > 1);
        let mut lines = self.state.commands(size, faces);
        if let Some(Ok(found)) = open.rays.answer() {
            lines.push(self.state.curve_command(found.texel, found.face, &rays::specs(&self.state)));
        }
        let text = lines.join("\n");
        println!("{text}");
        open.input.egui_ctx().copy_text(text);
    }

    /// Requests the curve under the pointer if it is shown, and writes it if a file was requested.
    fn ask(&mut self, stage: &mut Stage, rays: &mut Rays) -> Result<()> {
        if !self.state.curve {
            rays.rest();
            return Ok(());
        }
        let seen = stage.seen()?;
        rays.ask(&self.state, seen, || stage.shared());
        self.files.save_plot(rays)
    }

    /// On an error, stores it and closes the window.
    fn check(&mut self, events: &ActiveEventLoop, outcome: Result<()>) {
        if let Err(error) = outcome {
            (self.outcome, self.is_over) = (Err(error), true);
        }
        if self.is_over {
            events.exit();
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
        // Under a script, the user's keys and mouse are ignored.
        let is_input = matches!(
            event,
            WindowEvent::CursorMoved { .. }
                | WindowEvent::MouseInput { .. }
                | WindowEvent::MouseWheel { .. }
                | WindowEvent::ModifiersChanged(_)
                | WindowEvent::KeyboardInput { .. }
        );
        if !is_input || self.script.is_none() {
            self.event(&event, &mut open);
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
            // The system does not draw a window without area, so the frame is drawn here, and scripts continue.
            self.wants = false;
            let outcome = self.frame();
            self.check(events, outcome);
            events.set_control_flow(ControlFlow::Poll);
            return;
        }
        // The reference progresses without the window, so the window must poll it.
        let fills = open.stage.as_ref().is_some_and(|stage| !stage.is_whole(&self.state))
            || open.rays.is_waiting()
            || self.files.are_due();
        self.wants |= fills && self.last.elapsed() >= LOOK;
        let behind = open.panel.as_ref().filter(|_| self.is_behind).map(|(_, at, _)| *at + OLDEST);
        self.wants |= behind.is_some_and(|due| due <= Instant::now());
        if self.wants {
            open.window.request_redraw();
        }
        events.set_control_flow(match () {
            () if self.script.is_some() => ControlFlow::WaitUntil(Instant::now() + Duration::from_millis(5)),
            () if fills => ControlFlow::WaitUntil(Instant::now() + LOOK),
            () => behind.map_or(ControlFlow::Wait, ControlFlow::WaitUntil),
        });
    }
}
