//! The depth map of the opaque casters, shared by all techniques.

use super::{LightData, SceneData};
use crate::Result;
use crate::gpu::shader;
use crate::gpu::{Bindings, Buffer, Commands, Context, Format, Graphics, Image, ImageUse, Pipeline, Resource, Target};

/// The map and the pass that draws it.
pub struct OpaqueMap {
    /// D32: depth in the range of the light's `opaque` view, 1 where there is nothing; 1×1 without meshes.
    pub image: Image,
    bindings: Bindings,
    pipeline: Pipeline,
    vertices: u32,
}

impl OpaqueMap {
    /// Makes the map; `lights` holds `light`.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] where memory runs out.
    pub fn new(context: &Context, scene: &SceneData, light: &LightData, lights: &Buffer) -> Result<Self> {
        let size = [light.opaque.width, light.opaque.height];
        let image = Image::new(context, "opaque.depth", Format::D32_SFLOAT, size, ImageUse::Depth)?;
        let resources = [Resource::Buffer(lights.clone()), Resource::Buffer(scene.triangles.clone())];
        let bindings = Bindings::new(context, "opaque.depth", &resources)?;
        let state = Graphics {
            vertex: shader("opaque/depth.vert")?,
            fragment: shader("opaque/depth.frag")?,
            colors: &[],
            depth: true,
        };
        let pipeline = Pipeline::graphics(context, &state, &[&bindings], &[])?;
        Ok(Self { image, bindings, pipeline, vertices: 3 * scene.triangle_count })
    }

    /// Draws the meshes as the light sees them. No pass where there are none.
    pub fn depth(&self, commands: &mut Commands) {
        if self.vertices == 0 {
            return;
        }
        commands.pass("opaque.depth", |pass| {
            let target = Target { image: &self.image, clear: Some([1.0; 4]) };
            pass.render(self.image.size(), &[], Some(target), |draw| {
                draw.draw(&self.pipeline, &[&self.bindings], &[], self.vertices);
            });
        });
    }
}
