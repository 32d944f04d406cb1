//! The stage: a scene, the techniques that light it, and their pictures. Unchanged parts are neither rebuilt nor redrawn.

mod moves;
mod output;

use self::moves::Simulated;
use self::output::{Output, Values};
use super::host::Host;
use super::lit::Lit;
use super::present::{PANELS, Present};
use super::state::{Show, Side, State};
use super::truth::{Counts, Truth};
use crate::animate::{AnimatedScene, Simulation};
use crate::gpu::{Buffer, Commands, Context};
use crate::report::StepRange;
use crate::scene::{Scene, SceneChange, View};
use crate::world::World;
use crate::{Error, GpuCause, Result};
use ash::vk;
use glam::DVec3;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// State of A or B.
enum Pane {
    /// Shows no technique, or the reference.
    Closed,
    Open(Box<Lit>),
    /// A technique that cannot be shown: its spec and look, and the cause.
    Refused {
        wanted: String,
        cause: String,
    },
}

impl Pane {
    fn lit(&self) -> Option<&Lit> {
        if let Self::Open(lit) = self { Some(lit) } else { None }
    }

    fn lit_mut(&mut self) -> Option<&mut Lit> {
        if let Self::Open(lit) = self { Some(lit) } else { None }
    }

    fn cause(&self) -> Option<&str> {
        if let Self::Refused { cause, .. } = self { Some(cause) } else { None }
    }
}

/// The scene, A and B.
pub struct Stage {
    /// Scene from its file, at the state's time.
    base: AnimatedScene,
    /// Part of the state that determined `base`.
    of: (String, f64, Option<usize>),
    /// Attractor and gravity of the scene's particles.
    pull: (Option<DVec3>, f64),
    /// Changes of the world relative to `base`.
    change: SceneChange,
    world: World,
    /// Number that changes whenever the world does; unique over all states of all scenes.
    version: u64,
    /// Same as `version`, but for changes of casters and lights only.
    cast: u64,
    /// Copy of the scene for other threads, with the `cast` of its casters and lights. The copy's camera may be out of date.
    kept: Option<(u64, Arc<Scene>)>,
    /// Camera's view, with the `version` and the picture size that it was computed for.
    camera: Option<(u64, [u32; 2], View)>,
    /// Moves particles on the device; created when they first move.
    simulation: Option<Simulation>,
    /// Copies the particles moved by the device to the host, whose scene takes them over once they stand still.
    simulated: Option<Simulated>,
    panes: [Pane; 2],
    /// A view of A, other than a picture, that cannot be shown: which view, for which spec, and why.
    unanswered: Option<(Show, String, String)>,
    truth: Truth,
    output: Output,
    steps: Option<StepRange>,
    /// Size of a picture, in pixels.
    size: [u32; 2],
    /// Size of the window's bytes, in pixels.
    area: [u32; 2],
    context: Context,
}

impl Stage {
    /// Creates a stage with the scene that `state` names, to be drawn in `area` pixels.
    ///
    /// # Errors
    /// See [`AnimatedScene::load`], [`SceneChange::of`] and [`World::new`].
    pub fn new(context: &Context, state: &State, area: [u32; 2]) -> Result<Self> {
        let base = state.load()?;
        let world = World::new(context, &state.change().of(&base.scene)?)?;
        Ok(Self {
            base,
            of: (state.scene.clone(), state.time_s, state.lights),
            pull: state.pull(),
            change: state.change(),
            world,
            version: next_version(),
            cast: next_version(),
            kept: None,
            camera: None,
            simulation: None,
            simulated: None,
            panes: [Pane::Closed, Pane::Closed],
            unanswered: None,
            truth: Truth::default(),
            output: Output::NOTHING,
            steps: None,
            size: picture_size(state.show, area),
            area: area.map(|side| side.max(1)),
            context: context.clone(),
        })
    }

    /// Whether the stage shows the scene that `state` names.
    pub fn is_of(&self, state: &State) -> bool {
        (&self.of.0, self.of.2) == (&state.scene, state.lights)
    }

    /// Returns the scene from its file, without the state's changes.
    pub fn base(&self) -> &Scene {
        &self.base.scene
    }

    /// Same as [`Stage::base`], but with the animation.
    pub fn animated(&self) -> &AnimatedScene {
        &self.base
    }

    /// Returns the version number of the world's state, and the camera that sees it.
    ///
    /// # Errors
    /// See [`World::scene`].
    pub fn seen(&self) -> Result<(u64, View)> {
        let known = self.camera.filter(|(of, size, _)| (*of, *size) == (self.version, self.size));
        let view = known.map(|(.., view)| Ok(view)).unwrap_or_else(|| {
            let scene = self.world.scene()?;
            Ok(View::camera(&scene.camera, scene, self.size))
        });
        view.map(|view| (self.version, view))
    }

    /// Returns the number of pictures that the reference has begun, finished and dropped.
    pub fn truth_counts(&self) -> Counts {
        self.truth.counts()
    }

    /// Returns how often A and B were built since they were opened.
    pub fn builds(&self) -> u64 {
        self.panes.iter().filter_map(Pane::lit).map(|lit| lit.builds).sum()
    }

    /// Returns the size of a picture, in pixels.
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// Returns the size of a picture for a state that is still to be drawn.
    pub fn size_of(&self, state: &State) -> [u32; 2] {
        picture_size(state.show, self.area)
    }

    /// Returns the size of the window's bytes, in pixels: larger than a picture if several stand side by side.
    pub fn area(&self) -> [u32; 2] {
        self.area
    }

    /// Maps a position in the window to the picture at that position.
    pub fn place(&self, at: [f64; 2]) -> [f64; 2] {
        [0, 1].map(|i| if self.area[i] == self.size[i] { at[i] } else { at[i].rem_euclid(f64::from(self.size[i])) })
    }

    /// Returns the size of a picture's file: for a slice, the size of its square.
    pub fn pictured(&self, state: &State) -> [u32; 2] {
        if state.show == Show::Slice { [self.area[0].min(self.area[1]); 2] } else { self.area }
    }

    /// Sets the number of pixels to draw in, for one picture or several.
    pub fn resize(&mut self, show: Show, area: [u32; 2]) {
        let (size, area) = (picture_size(show, area), area.map(|side| side.max(1)));
        if (size, area) != (self.size, self.area) {
            (self.size, self.area) = (size, area);
            for pane in self.panes.iter_mut().filter(|pane| pane.lit().is_some()) {
                *pane = Pane::Closed;
            }
            self.forget();
        }
    }

    /// Drops everything created from the present pictures.
    fn forget(&mut self) {
        self.output = Output::NOTHING;
    }

    /// Returns the views of A and B that cannot be shown, one line each.
    pub fn refused(&self) -> impl Iterator<Item = &str> {
        let unanswered = self.unanswered.iter().map(|(.., cause)| cause.as_str());
        self.panes.iter().filter_map(Pane::cause).chain(unanswered)
    }

    /// Returns the range of the steps shown as colors.
    pub fn steps(&self) -> Option<&StepRange> {
        self.steps.as_ref()
    }

    /// Returns the numbers of finished rows and of all rows of the reference; `None` if the reference is not shown.
    pub fn truth(&self, state: &State) -> Option<[u32; 2]> {
        has_reference(state).then(|| self.truth.rows())
    }

    /// Returns the path that A or B runs.
    pub fn path(&self, side: usize) -> Option<&'static str> {
        self.panes[side].lit().and_then(|lit| lit.technique.inspect().facts().ok()).map(|facts| facts.path)
    }

    /// Returns the bytes that the window shows.
    pub fn bytes(&self) -> Option<&Buffer> {
        self.output.present.as_ref().map(Present::shown)
    }

    /// Whether the picture is final until the next change.
    pub fn is_whole(&self, state: &State) -> bool {
        self.is_drawn(state) && (!has_reference(state) || self.truth.is_whole())
    }

    /// Same as [`Stage::is_whole`], but ignores the reference, which progresses without frames.
    pub fn is_drawn(&self, state: &State) -> bool {
        let side = |i: usize| match (&state.sides[i], &self.panes[i]) {
            _ if !state.show.draws()[i] => true,
            (Side::Reference, _) | (_, Pane::Refused { .. }) => true,
            (Side::Technique(_), Pane::Open(lit)) => {
                lit.is_current(&self.world) && (lit.is_drawn() || !state.show.is_picture())
            }
            (Side::Technique(_), Pane::Closed) => false,
        };
        let is_answered = match state.show {
            Show::Slice => self.output.values == Values::Slice(state.light, state.depth),
            Show::Steps => self.output.values == Values::Steps,
            Show::A | Show::B | Show::Wipe | Show::Difference | Show::Wireframe | Show::Beside => true,
        };
        side(0)
            && side(1)
            && !self.simulated.as_ref().is_some_and(|simulated| simulated.is_moving)
            && (is_answered || self.panes[0].cause().is_some() || self.unanswered.is_some())
            && self.output.shown.is_some()
    }

    /// Records the frame of `state`, without waiting for anything.
    ///
    /// # Errors
    /// [`Error::Gpu`] if the device is lost or out of memory; [`Error::Input`] if the scene cannot have this state.
    pub fn record(&mut self, host: &Host, commands: &mut Commands, state: &State) -> Result<()> {
        if let Some(over) = commands.frame().checked_sub(host.frames_in_flight()) {
            for lit in self.panes.iter_mut().filter_map(Pane::lit_mut) {
                lit.settle(over)?;
            }
            self.paint_steps(over)?;
            self.take_particles(over)?;
        }
        self.move_world(commands, state)?;
        let (_, camera) = self.seen()?;
        self.camera = Some((self.version, self.size, camera));
        self.see(state, &camera);
        for i in 0..2 {
            self.open(i, state, &camera)?;
        }
        self.ask_of_a(state)?;
        for (i, pane) in self.panes.iter_mut().enumerate() {
            let Pane::Open(lit) = pane else { continue };
            if !state.show.draws()[i] {
                continue;
            }
            let (seen, lines) = ((self.version, camera), state.show == Show::Wireframe);
            let recorded = lit.record(commands, &self.world, seen, state.show.is_picture(), lines)?;
            if recorded.changed && self.output.values != Values::Reference {
                (self.output.values, self.output.counting) = (Values::Nothing, None);
            }
            if recorded.changed || recorded.drawn {
                self.output.shown = None;
            }
        }
        self.show(commands, state, host.is_blue_first())
    }

    /// Requests the reference for the present view.
    fn see(&mut self, state: &State, camera: &View) {
        if !has_reference(state) {
            self.truth.rest();
            if !state.curve {
                self.kept = None;
            }
            return;
        }
        let mut truth = std::mem::take(&mut self.truth);
        truth.see(self.cast, camera, state.look(), || self.scene_of_now());
        self.truth = truth;
    }

    /// Opens A or B if its spec or its look has changed. A failure to open it is not an error; it is shown as a line.
    fn open(&mut self, i: usize, state: &State, camera: &View) -> Result<()> {
        let wanted = match &state.sides[i] {
            Side::Technique(spec) if state.show.draws()[i] => spec,
            Side::Technique(_) => return Ok(()),
            Side::Reference => {
                let was = std::mem::replace(&mut self.panes[i], Pane::Closed);
                if was.lit().is_some() {
                    self.forget();
                }
                return Ok(());
            }
        };
        let look = state.look();
        let is = |lit: &Lit| (lit.spec.to_string(), lit.look) == (wanted.to_string(), look);
        let text = format!("{wanted} {look:?}");
        match &self.panes[i] {
            Pane::Open(lit) if is(lit) => return Ok(()),
            Pane::Refused { wanted, .. } if *wanted == text => return Ok(()),
            _ => self.panes[i] = Pane::Closed,
        }
        self.forget();
        self.panes[i] = match Lit::open(&self.context, &self.world, wanted, (self.version, *camera), look) {
            Ok(lit) => Pane::Open(Box::new(lit)),
            Err(error) if is_lost(&error) => return Err(error),
            Err(error) => Pane::Refused { wanted: text, cause: error.to_string() },
        };
        Ok(())
    }

    /// Records that A cannot be shown in this way.
    fn refuse(&mut self, show: Show, error: &Error) {
        let spec = self.panes[0].lit().map_or_else(String::new, |lit| lit.spec.to_string());
        self.unanswered = Some((show, spec, error.to_string()));
    }

    /// Prepares A for the requested view. If A cannot show it, it is not tried again.
    fn ask_of_a(&mut self, state: &State) -> Result<()> {
        let spec = self.panes[0].lit().map_or_else(String::new, |lit| lit.spec.to_string());
        // A slice may concern another light now, so it is tried again.
        self.unanswered.take_if(|(show, of, _)| *show != state.show || *of != spec || *show == Show::Slice);
        if self.unanswered.is_some() {
            return Ok(());
        }
        let outcome = match (state.show, self.panes[0].lit_mut()) {
            (Show::Slice | Show::Steps | Show::Wireframe, _) if matches!(state.sides[0], Side::Reference) => {
                Err(Error::input("the reference", "it is only shown as a picture", "choose a technique"))
            }
            (Show::Wireframe, Some(lit)) => lit.outline(),
            _ => Ok(()),
        };
        match outcome {
            Err(error) if is_lost(&error) => return Err(error),
            Err(error) => self.refuse(state.show, &error),
            Ok(()) => {}
        }
        Ok(())
    }
}

fn next_version() -> u64 {
    static NEXT: AtomicU64 = AtomicU64::new(0);
    NEXT.fetch_add(1, Ordering::Relaxed)
}

/// Returns the size of each picture, in pixels, if `show` divides `area` among several.
fn picture_size(show: Show, area: [u32; 2]) -> [u32; 2] {
    let panels = if show == Show::Beside { PANELS } else { [1; 2] };
    [0, 1].map(|i| (area[i] / panels[i]).max(1))
}

/// Whether the reference is shown.
fn has_reference(state: &State) -> bool {
    let has_pictures = state.show.is_picture() && state.show != Show::Wireframe;
    state.show == Show::Beside
        || has_pictures && (0..2).any(|i| state.show.draws()[i] && matches!(state.sides[i], Side::Reference))
}

/// Whether the error means that the device is lost.
pub fn is_lost(error: &Error) -> bool {
    matches!(error, Error::Gpu { cause: GpuCause::Vulkan(vk::Result::ERROR_DEVICE_LOST), .. })
}
