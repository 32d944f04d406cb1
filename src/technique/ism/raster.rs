//! Drawn points. A compute pass lists the points that lights see, one draw puts them into the maps of all lights, side by side in one depth
//! target, and another pass copies the depths into memory. Sources: Ritschel et al. 2008, Tokuyoshi 2014.

use super::atlas::AtlasPush;
use super::settings::{Culling, Settings};
use crate::gpu::{
    Buffer, Commands, Constants, Context, Format, Graphics, Image, ImageUse, Kernel, Limit, Memory, Target, groups,
};
use crate::shaders::set;
use crate::shaders::{constant, ism as shaders};
use crate::{Error, Result};

/// Number of points that a workgroup tests. Twins: CULL_THREADS, ROUNDS in glsl/technique/ism/cull.comp.
const CULLED_AT_ONCE: u32 = 128 * 8;

/// Bytes per point in the list.
const LISTED_BYTES: u64 = 16;

/// Threads per workgroup. Twin: local_size_x in glsl/technique/ism/gather.comp.
const GATHER_THREADS: u32 = 128;

/// The draw and its targets.
pub struct Raster {
    settings: Settings,
    vertices: u32,
    /// Where each point is drawn, one entry per point. Twin: drawn_point in glsl/technique/ism/drawn.glsl.
    listed: Buffer,
    /// A VkDrawIndirectCommand.
    arguments: Buffer,
    target: Image,
    cull: Option<Kernel<AtlasPush>>,
    draw: Kernel<AtlasPush>,
    gather: Kernel<AtlasPush>,
}

impl Raster {
    /// Creates the draw and its targets. `atlas` and `constants`: buffers and constants of all passes over the maps. `vertices`: vertices
    /// per point, 3 or 6.
    ///
    /// # Errors
    /// [`Error::Refused`] if the device does not support a buffer as large as the list or an image as large as the target, [`Error::Gpu`]
    /// if memory runs out.
    pub fn new(
        context: &Context,
        settings: &Settings,
        light_count: u32,
        atlas: set::IsmAtlas,
        constants: &Constants,
        vertices: u32,
    ) -> Result<Self> {
        let features = context.features();
        let columns = light_count.max(1).isqrt() + u32::from(light_count.max(1).isqrt().pow(2) < light_count);
        let size = [columns.max(1), light_count.div_ceil(columns.max(1)).max(1)].map(|side| side * settings.size);
        if let Some(needs) = Limit::image_2d(size[0].into()).lacks(features, " for the maps") {
            return Err(Error::Refused(needs));
        }
        let culls = settings.culling != Culling::Off;
        let most_points = if culls { u64::from(light_count.max(1)) * u64::from(settings.points) } else { 1 };
        let bytes = LISTED_BYTES * most_points;
        let most = u64::from(features.max_storage_buffer_range);
        if bytes > most {
            let needs =
                format!("maxStorageBufferRange of at least {bytes} for the list of points (this device has {most})");
            return Err(Error::Refused(needs.into()));
        }
        let listed = Buffer::new(context, "ism.listed", bytes, Memory::Device)?;
        let arguments = Buffer::new(context, "ism.arguments", 16, Memory::Device)?;
        let target = Image::new(context, "ism.target", Format::D32_SFLOAT, size, ImageUse::Depth)?;
        let set::IsmAtlas { lights, head, pool, maps, seen, taken, clusters } = atlas;
        let (listing, draw) = (&listed, &arguments);
        let set = set::IsmRaster { lights, head, pool, maps, seen, taken, clusters, listed: listing, draw };
        let set = set.bind(context, "ism.raster")?;
        let depths = set::IsmTarget { depths: &target }.bind(context, "ism.target")?;
        let constants = constants
            .clone()
            .set(constant::DRAWN_VERTICES, vertices)
            .set(constant::COLUMNS, columns.max(1))
            .set(constant::DRAWN_LISTED, culls);
        let shader = if features.subgroup_ballot { &shaders::CULL_BALLOTS_1 } else { &shaders::CULL_BALLOTS_0 };
        let cull = culls.then(|| Kernel::compute(context, shader, &[&set], &constants)).transpose()?;
        let (vertex, fragment) = (&shaders::DRAW_VERT, &shaders::DRAW_FRAG);
        let state = Graphics { vertex, fragment, colors: &[], depth: Some(Format::D32_SFLOAT) };
        Ok(Self {
            settings: *settings,
            vertices,
            listed,
            arguments,
            target,
            cull,
            draw: Kernel::graphics(context, &state, &[&set], &constants)?,
            gather: Kernel::compute(context, &shaders::GATHER, &[&set, &depths], &constants)?,
        })
    }

    /// Records the passes that splat all points into the maps.
    pub fn record(&self, commands: &mut Commands, push: &AtlasPush) {
        if let Some(cull) = &self.cull {
            let count = u64::from(push.light_count) * u64::from(push.points / CULLED_AT_ONCE);
            let [x, y] = groups(count);
            commands.pass("ism.clear", |pass| pass.update(&self.arguments, &[0, 1, 0, 0]));
            commands.pass("ism.cull", |pass| pass.dispatch(cull, push, [x, y, 1]));
        }
        commands.pass("ism.draw", |pass| {
            let target = Target { image: &self.target, clear: Some([1.0; 4]) };
            pass.render(self.target.size(), &[], Some(target), |draw| match &self.cull {
                Some(_) => draw.draw_indirect(&self.draw, push, &self.arguments, 0),
                None => draw.draw(&self.draw, push, self.vertices * push.light_count * push.points, 1),
            });
        });
        let count = u64::from(push.light_count) * u64::from(self.settings.texels().div_ceil(GATHER_THREADS));
        let [x, y] = groups(count);
        commands.pass("ism.gather", |pass| pass.dispatch(&self.gather, push, [x, y, 1]));
    }

    /// Returns the number of bytes needed only while building.
    pub fn transient_bytes(&self) -> u64 {
        self.listed.bytes() + self.arguments.bytes() + self.target.bytes()
    }
}
