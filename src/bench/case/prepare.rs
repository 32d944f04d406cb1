//! Pipelines of rows to come, made on all processors before anything is timed. A driver takes longer to make them than to run them,
//! and makes one on one processor.

use crate::Result;
use crate::bench::case::SceneCase;
use crate::bench::case::device_scene::DeviceScene;
use crate::gpu::{Context, fault};
use crate::query::Query;
use crate::shading::{Lighting, Renderer, Shading};
use crate::technique::{self, Spec};
use crate::world::World;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Techniques that are open at once, at most: each has its maps.
const AT_ONCE: usize = 8;

impl SceneCase<'_> {
    /// Makes the pipelines with which rows of these specs build, ask and draw, as far as they are made before the first
    /// build. A pipeline that fails is made again where its row is measured, and that row says why. To be called before
    /// anything is timed.
    ///
    /// # Errors
    /// [`crate::Error::Input`] where the world's scene is not known to the host.
    pub fn prepare(&self, specs: &[&Spec]) -> Result<()> {
        let threads = std::thread::available_parallelism().map_or(1, |n| n.get()).min(AT_ONCE).min(specs.len());
        // A test that lets the n-th call fail expects the failure in the row that makes the call.
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
                        // Until the next submission, pending work keeps new buffers alive.
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
