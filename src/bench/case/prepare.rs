//! Creation of the pipelines of later rows, on all processors, before anything is timed. A driver takes longer to create them than to run
//! them, and creates each on a single processor.

use crate::Result;
use crate::bench::case::SceneCase;
use crate::bench::case::device_scene::DeviceScene;
use crate::gpu::{Context, fault};
use crate::query::Query;
use crate::shading::{Lighting, Renderer, Shading};
use crate::technique::{self, Spec};
use crate::world::World;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Maximum number of techniques open at once, since each has its own maps.
const AT_ONCE: usize = 8;

impl SceneCase<'_> {
    /// Creates the pipelines that rows of these specs use to build, query and draw, except pipelines that exist only after the first build.
    /// A pipeline that fails is created again when its row is measured, and that row reports why. Call this before anything is timed.
    ///
    /// # Errors
    /// [`crate::Error::Input`] if the host does not know the world's scene.
    pub fn prepare(&self, specs: &[&Spec]) -> Result<()> {
        let threads = std::thread::available_parallelism().map_or(1, |n| n.get()).min(AT_ONCE).min(specs.len());
        // A test that makes the n-th call fail expects the failure in the row that makes the call.
        if threads < 2 || fault::is_asked() {
            return Ok(());
        }
        let DeviceScene { context, world, .. } = &self.scene;
        let camera = self.scene.camera(self.effort.picture)?;
        let next = AtomicUsize::new(0);
        std::thread::scope(|scope| {
            for _ in 0..threads {
                scope.spawn(|| {
                    let Ok(mut renderer) = Renderer::new(context, world, &camera) else { return };
                    while let Some(spec) = specs.get(next.fetch_add(1, Ordering::Relaxed)) {
                        let _ = make(context, world, &mut renderer, spec);
                        // Pending work keeps new buffers alive until the next submission.
                        let _ = context.submit(|_| {});
                    }
                });
            }
        });
        Ok(())
    }
}

fn make(context: &Context, world: &World, renderer: &mut Renderer, spec: &Spec) -> Result<()> {
    let settings = spec.settings();
    let (lighting, shading) = (Lighting::of(&settings), Shading::of(&settings));
    settings.check(context.features())?;
    let opened = technique::open(context, world, spec)?;
    let technique = opened.technique.as_ref();
    Query::new(context, 0, &[[0.0; 3]])?.kernel(&technique.answer())?;
    renderer.paint_by(settings.painter);
    renderer.kernels_of(technique, shading, lighting)?;
    Ok(())
}
