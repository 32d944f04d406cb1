//! Casters and volumes painted by compute passes, lit by one technique. Each tile of 8 × 8 pixels has a list of the casters that it may
//! see; lists are cut into parts, which are painted in parallel and then composited. Blending from far to near is associative, so the
//! picture is the same as with drawing and blending, except for rounding. Twin: reference::truth::picture.

mod canvas;
mod lists;
mod shade;
mod slices;
mod vertices;

pub(super) use canvas::Canvas;
pub use lists::{ListReadback, PaintTotals, PartData};
pub(super) use lists::{Lists, usual_part};
pub(super) use shade::Shade;
pub(super) use slices::Slices;
pub use vertices::PatchData;

use super::volumes::VolumePush;
use super::{Lighting, Renderer, lock};
use crate::Result;
use crate::gpu::{Commands, Constants, Kernel};
use crate::scene::{Blended, Scene};
use crate::shaders::{constant, painter as shaders, shading};
use crate::technique::Answer;
use crate::world::CameraPush;
use std::cell::RefCell;
use std::ops::Range;
use std::sync::{Arc, Mutex};
use vertices::Vertices;

/// Number of runs of casters that are measured in one submission; each run takes a few passes.
const RUNS: usize = 64;

/// Paints casters and volumes.
pub(super) struct Painter {
    canvas: Arc<Canvas>,
    /// `None` if there are no casters except cells of volumes.
    casters: Option<CasterPainter>,
    volumes: Option<Kernel<VolumePush>>,
}

struct CasterPainter {
    lists: Arc<Mutex<Lists>>,
    /// Present if light is looked up at vertices.
    vertices: Option<RefCell<Vertices>>,
    paint: Kernel<CameraPush>,
    compose: Kernel<CameraPush>,
}

impl CasterPainter {
    fn new(
        renderer: &Renderer,
        canvas: &Canvas,
        answer: &Answer,
        lighting: Lighting,
        constants: &Constants,
    ) -> Result<Self> {
        let lists = renderer.lists()?;
        let (scene, split, is_staged) = {
            let lists = lock(&lists);
            (lists.scene.clone(), lists.split.clone(), lists.may_split())
        };
        let vertices = match lighting {
            Lighting::Fragment => None,
            Lighting::Vertex { spacing } => Some(Vertices::new(renderer, answer, constants, spacing)?),
        };
        let spreads = renderer.context.features().is_software();
        let constants = constants.clone().set(constant::SPREAD, spreads).set(constant::STAGED, is_staged);
        let kernel = |shader, sets: &[_]| Kernel::compute(&renderer.context, shader, sets, &constants);
        let paint = match &vertices {
            None => kernel(shaders::PAINT.of(answer.folder), &[&scene, answer.bindings, &canvas.bindings])?,
            Some(vertices) => kernel(&shaders::PAINT_LIT, &[&scene, &vertices.lit, &canvas.bindings])?,
        };
        let compose = kernel(&shaders::COMPOSE, &[&scene, &split, &canvas.bindings])?;
        Ok(Self { lists, vertices: vertices.map(RefCell::new), paint, compose })
    }

    fn record(&self, commands: &mut Commands, renderer: &Renderer, run: &Range<u32>, is_first: bool) {
        let (lists, push) = (lock(&self.lists), CameraPush::of(&renderer.camera));
        lists.record(commands, run, is_first);
        self.light(commands, run, is_first, true);
        commands.pass("painter.paint", |pass| lists.per_part(pass, &self.paint, &push));
        if lists.may_split() {
            commands.pass("painter.compose", |pass| lists.per_split(pass, &self.compose, &push));
        }
    }

    /// Records the passes that measure the capacities that [`CasterPainter::record`] needs.
    fn measure(&self, commands: &mut Commands, run: &Range<u32>, is_first: bool) {
        lock(&self.lists).measure(commands, run, is_first);
        self.light(commands, run, is_first, false);
    }

    fn light(&self, commands: &mut Commands, run: &Range<u32>, is_first: bool, lights: bool) {
        if let Some(vertices) = &self.vertices {
            vertices.borrow().record(commands, run, is_first, lights);
        }
    }

    fn settle(&self, frame: u64) -> Result<bool> {
        let mut lists = lock(&self.lists);
        let has_grown = lists.settle(frame)?;
        let Some(vertices) = &self.vertices else { return Ok(has_grown) };
        Ok(vertices.borrow_mut().settle(frame, &mut lists)? || has_grown)
    }
}

impl Painter {
    /// Creates the passes for pictures of `renderer`, lit by `answer`.
    pub(super) fn new(renderer: &Renderer, answer: &Answer, lighting: Lighting) -> Result<Self> {
        let canvas = renderer.canvas()?;
        let constants = renderer.painted(answer.constants);
        let casters = match renderer.blending.room() {
            0 => None,
            _ => Some(CasterPainter::new(renderer, &canvas, answer, lighting, &constants)?),
        };
        let march = |fields| {
            let sets = [&renderer.scene.set, answer.bindings, &canvas.bindings, fields];
            Kernel::compute(&renderer.context, shading::VOLUME.of(answer.folder), &sets, &constants)
        };
        let volumes = renderer.volumes.as_ref().map(|volumes| march(&volumes.bindings)).transpose()?;
        Ok(Self { canvas, casters, volumes })
    }

    /// Records the casters at positions `part` of the blending order, which must be sorted, and the volumes that come before one of them,
    /// or after the last caster of all.
    pub(super) fn record(&self, commands: &mut Commands, renderer: &Renderer, part: &Range<u32>) {
        self.canvas.begin(commands);
        let mut is_first = true;
        for next in renderer.blending.within(part) {
            match (next, &self.casters, &self.volumes) {
                (Blended::Casters(places), Some(casters), _) => {
                    let runs = lock(&casters.lists).runs(&places, renderer.blending.casters);
                    for run in runs {
                        casters.record(commands, renderer, &run, is_first);
                        is_first = false;
                    }
                }
                (Blended::Volume(volume), _, Some(kernel)) => self.volume(commands, renderer, kernel, volume),
                _ => {}
            }
        }
        self.canvas.end(commands);
    }

    fn volume(&self, commands: &mut Commands, renderer: &Renderer, kernel: &Kernel<VolumePush>, volume: u32) {
        let ratio = renderer.volumes.as_ref().map_or(Scene::GREY, |volumes| volumes.ratios[volume as usize]);
        let groups = self.canvas.groups();
        commands.pass("shading.volume", |pass| pass.dispatch(kernel, &VolumePush { volume, ratio }, groups));
    }

    /// Enlarges the lists until all casters fit, before the first frame of a camera. The casters must be sorted. Runs commands and waits.
    pub(super) fn make_room(&self, renderer: &Renderer) -> Result<()> {
        let Some(casters) = &self.casters else { return Ok(()) };
        loop {
            let (mut frame, mut is_first) = (0, true);
            let places = renderer.blending.runs.iter().filter_map(|next| match next {
                Blended::Casters(places) => Some(places),
                Blended::Volume(_) => None,
            });
            let lists = lock(&casters.lists);
            let runs: Vec<_> = places.flat_map(|places| lists.runs(places, renderer.blending.casters)).collect();
            drop(lists);
            for runs in runs.chunks(RUNS) {
                renderer.context.submit(|commands| {
                    frame = commands.frame();
                    for run in runs {
                        casters.measure(commands, run, is_first);
                        is_first = false;
                    }
                })?;
            }
            if !casters.settle(frame)? {
                return Ok(());
            }
        }
    }

    /// Returns the number of runs in which all casters are painted, one after another.
    pub(super) fn run_count(&self) -> u32 {
        self.casters.as_ref().map_or(1, |casters| lock(&casters.lists).run_count())
    }

    /// See [`Renderer::settle`].
    pub(super) fn settle(&self, frame: u64) -> Result<bool> {
        self.casters.as_ref().map_or(Ok(false), |casters| casters.settle(frame))
    }

    /// Returns the bytes of the lists, and of the light at vertices; `None` if there are no casters except cells of
    /// volumes.
    pub(super) fn bytes(&self) -> Option<u64> {
        let casters = self.casters.as_ref()?;
        let vertices = casters.vertices.as_ref().map_or(0, |vertices| vertices.borrow().bytes());
        Some(lock(&casters.lists).bytes() + vertices)
    }
}

impl Renderer {
    /// Returns the constants of passes that paint all three colors at once.
    pub(super) fn painted(&self, constants: &Constants) -> Constants {
        let constants = self.with_kinds(crate::query::colored(constants, self.kinds.extinction_ratio));
        if self.kinds.room_per_color > 0 {
            constants.set(constant::CASTER_ROOM, self.kinds.room_per_color)
        } else {
            constants
        }
    }

    /// Cuts the lists of casters per tile into parts of at least `least` entries, which are painted in parallel. Must be called before
    /// kernels are created. By default, software devices, which have few threads, paint each list as one part, and stop where nothing more
    /// is visible.
    pub fn cut_lists(&mut self, least: u32) {
        self.least_part = least.max(1);
    }
}
