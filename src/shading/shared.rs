//! Passes and buffers that all kernels of a renderer share, created when kernels first need them and kept from frame to
//! frame.

use super::many_lights::{ManyLights, Targets};
use super::painter::{Canvas, Lists};
use super::{Renderer, Tiled};
use crate::Result;
use crate::maps::SeenTriangles;
use std::cell::{OnceCell, RefCell};
use std::sync::{Arc, Mutex};

/// Passes and buffers created so far.
#[derive(Default)]
pub(super) struct SharedPasses {
    /// The image that compute passes paint into.
    canvas: OnceCell<Arc<Canvas>>,
    /// The triangles that compute passes see.
    pub seen: OnceCell<Arc<Mutex<SeenTriangles>>>,
    /// The lists of casters for compute passes.
    pub lists: OnceCell<Arc<Mutex<Lists>>>,
    /// Buffers and passes of `shading=tiled`, for the settings of the kernels created last.
    pub tiles: RefCell<Option<Arc<ManyLights>>>,
}

fn get_or_make<T>(kept: &OnceCell<Arc<T>>, make: impl FnOnce() -> Result<T>) -> Result<Arc<T>> {
    if let Some(made) = kept.get() {
        return Ok(made.clone());
    }
    let made = Arc::new(make()?);
    Ok(kept.get_or_init(|| made).clone())
}

impl Renderer {
    /// Returns the canvas, creating it on the first call.
    pub(super) fn canvas(&self) -> Result<Arc<Canvas>> {
        get_or_make(&self.shared.canvas, || Canvas::new(self))
    }

    /// Returns the passes that find the triangles that pixels see, creating them on the first call.
    pub(super) fn seen_triangles(&self) -> Result<Arc<Mutex<SeenTriangles>>> {
        let (scene, camera) = (&self.scene, &self.camera);
        let read = (&scene.casters, &scene.triangles);
        let make = || SeenTriangles::new(&self.context, read, &scene.constants, camera).map(Mutex::new);
        get_or_make(&self.shared.seen, make)
    }

    /// Returns the lists of casters, creating them on the first call.
    pub(super) fn lists(&self) -> Result<Arc<Mutex<Lists>>> {
        get_or_make(&self.shared.lists, || Lists::of_all(self).map(Mutex::new))
    }

    /// Returns the buffers and passes of `shading=tiled`: the ones of earlier kernels if the settings are the same, otherwise new ones.
    pub(super) fn tiles(&self, tiled: Tiled) -> Result<Arc<ManyLights>> {
        let mut kept = self.shared.tiles.borrow_mut();
        if let Some(tiles) = kept.as_ref().filter(|tiles| tiles.tiled == tiled) {
            return Ok(tiles.clone());
        }
        let targets = Targets {
            context: &self.context,
            lights: &self.scene.lights,
            light_count: self.scene.light_count,
            gbuffer: &self.targets.surfaces,
            color: &self.targets.color,
            color_format: self.targets.format,
        };
        let tiles = Arc::new(ManyLights::new(&targets, tiled)?);
        *kept = Some(tiles.clone());
        Ok(tiles)
    }
}
