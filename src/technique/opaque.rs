//! The depth map of the opaque casters, shared by all techniques.

use super::SceneData;
use super::light::{Maps, stacked};
use crate::Result;
use crate::gpu::shader;
use crate::gpu::{Bindings, Commands, Context, Format, Graphics, Image, ImageUse, Pipeline, Resource, Target};

/// The maps of all lights and the pass that draws them.
pub struct OpaqueMap {
    /// D32: depth in the range of the map's `opaque` view, 1 where there is nothing; 1×1 a map without meshes. The maps
    /// stand one above the other.
    pub image: Image,
    bindings: Bindings,
    pipeline: Pipeline,
    vertices: u32,
    /// Of one map.
    size: [u32; 2],
    count: u32,
}

impl OpaqueMap {
    /// Makes the maps.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] where memory runs out, or the maps are more than fit into an image.
    pub fn new(context: &Context, scene: &SceneData, maps: &Maps) -> Result<Self> {
        let size = maps.data.first().map_or([1, 1], |m| [m.opaque.width, m.opaque.height]);
        let stacked = stacked(context, "opaque.depth", size, maps.count())?;
        let image = Image::new(context, "opaque.depth", Format::D32_SFLOAT, stacked, ImageUse::Depth)?;
        let resources = [Resource::Buffer(maps.buffer.clone()), Resource::Buffer(scene.triangles.clone())];
        let bindings = Bindings::new(context, "opaque.depth", &resources)?;
        let state = Graphics {
            vertex: shader("opaque/depth.vert")?,
            fragment: shader("opaque/depth.frag")?,
            colors: &[],
            depth: true,
        };
        let pipeline = Pipeline::graphics(context, &state, &[&bindings], &[])?;
        Ok(Self { image, bindings, pipeline, vertices: 3 * scene.triangle_count, size, count: maps.count() })
    }

    /// Draws the meshes as the lights see them, a pass a map. No pass where there are none.
    pub fn depth(&self, commands: &mut Commands) {
        if self.vertices == 0 {
            return;
        }
        for map in 0..self.count {
            commands.pass("opaque.depth", |pass| {
                let target = Target { image: &self.image, clear: Some([1.0; 4]) };
                pass.render_rows(map * self.size[1], self.size, &[], Some(target), |draw| {
                    draw.draw(&self.pipeline, &[&self.bindings], bytemuck::bytes_of(&map), self.vertices);
                });
            });
        }
    }
}
