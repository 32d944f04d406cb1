//! The maps of all lights, and the passes that splat points into them.

use super::adapt::Adapt;
use super::raster::Raster;
use super::sample::Sample;
use super::{BuildPath, Settings};
use crate::gpu::{Buffer, Commands, Constants, Context, Kernel, Memory, groups, push_struct};
use crate::shaders::set;
use crate::shaders::{constant, ism as shaders};
use crate::world::World;
use crate::{Error, Result};

/// Threads per workgroup when splatting with atomic operations in memory. Twin: local_size_x in glsl/technique/ism/splat.comp.
const SPLAT_THREADS: u32 = 128;

/// Number of threads in a workgroup that holds a map: the maximum on a GPU, and the number on a software device, where threads take turns.
const MAP_THREADS: [u32; 2] = [512, 128];

push_struct! {
    /// Twin: AtlasPush in glsl/technique/ism/atlas.glsl.
    pub(super) struct AtlasPush { light_count: u32, points: u32 }
}

enum Passes {
    Tiled(Kernel<AtlasPush>),
    Atomic { splat: Kernel<AtlasPush>, fill: Kernel<AtlasPush> },
    Raster { raster: Box<Raster>, fill: Kernel<AtlasPush> },
}

/// The maps of all lights.
pub struct Atlas {
    settings: Settings,
    way: BuildPath,
    light_count: u32,
    /// Distances as floats, map by map, [`Atlas::stride`] texels each, starting with the rows of the finest level.
    pub maps: Buffer,
    seen: Buffer,
    passes: Passes,
}

impl Atlas {
    pub(super) fn new(
        context: &Context,
        world: &World,
        settings: &Settings,
        way: BuildPath,
        sample: &Sample,
        adapt: Option<&Adapt>,
    ) -> Result<Self> {
        let light_count = world.light_count();
        let bytes = 4 * u64::from(light_count.max(1)) * u64::from(stride(settings, way));
        let most = u64::from(context.features().max_storage_buffer_range);
        if bytes > most {
            let needs = format!("maxStorageBufferRange of at least {bytes} for the maps (this device has {most})");
            return Err(Error::Refused(needs.into()));
        }
        let maps = Buffer::new(context, "ism.maps", bytes, Memory::Device)?;
        let seen = Buffer::new(context, "ism.seen", 4 * u64::from(light_count.max(1)), Memory::Device)?;
        // Not read unless points are adaptive.
        let (taken, clusters) = adapt.map_or((&seen, &seen), |adapt| (&adapt.taken, &adapt.clusters));
        let buffers = set::IsmAtlas {
            lights: &world.lights,
            head: &sample.head,
            pool: &sample.pool,
            maps: &maps,
            seen: &seen,
            taken,
            clusters,
        };
        let set = buffers.bind(context, "ism.atlas")?;
        let [most, few] = MAP_THREADS;
        let features = context.features();
        let threads = if features.is_software() { few } else { features.max_compute_workgroup_threads.min(most) };
        let constants = Constants::new()
            .set(constant::ISM_SIZE, settings.size)
            .set(constant::ISM_LEVELS, settings.levels())
            .set(constant::ISM_TEXELS, settings.texels())
            .set(constant::ISM_CULLING, settings.culls())
            .set(constant::ISM_SLIDE, settings.slides())
            .set(constant::ISM_FILL, settings.fill)
            .set(constant::ISM_ADAPTIVE, settings.adaptive)
            .set(constant::THREADS, threads)
            .set(constant::WORKGROUP, threads);
        let kernel = |shader| Kernel::compute(context, shader, &[&set], &constants);
        let passes = match way {
            BuildPath::Tiled => Passes::Tiled(kernel(&shaders::TILED)?),
            BuildPath::Atomic => Passes::Atomic { splat: kernel(&shaders::SPLAT)?, fill: kernel(&shaders::FILL)? },
            BuildPath::Quads | BuildPath::Triangles => {
                let vertices = if way == BuildPath::Quads { 6 } else { 3 };
                let raster = Raster::new(context, settings, light_count, buffers, &constants, vertices)?;
                Passes::Raster { raster: Box::new(raster), fill: kernel(&shaders::FILL)? }
            }
        };
        Ok(Self { settings: *settings, way, light_count, maps, seen, passes })
    }

    /// Returns the number of texels from one map to the next.
    pub fn stride(&self) -> u32 {
        stride(&self.settings, self.way)
    }

    /// After a build, returns the distances in the finest level of the map of light `light`, row by row; infinite where there is nothing.
    ///
    /// # Errors
    /// [`Error::Gpu`] if they cannot be read back.
    pub fn map(&self, light: usize) -> Result<Vec<f32>> {
        let (stride, texels) = (self.stride() as usize, self.settings.size.pow(2) as usize);
        let all: Vec<f32> = self.maps.read((light + 1) * stride)?;
        Ok(all[light * stride..][..texels].to_vec())
    }

    /// After a build, returns how many of its points each light sees.
    ///
    /// # Errors
    /// [`Error::Gpu`] if they cannot be read back.
    pub fn seen(&self) -> Result<Vec<u32>> {
        self.seen.read(self.light_count as usize)
    }

    pub(super) fn record(&self, commands: &mut Commands, world: &World) {
        let points = if world.triangle_count() == 0 { 0 } else { self.settings.points };
        let push = AtlasPush { light_count: self.light_count, points };
        let [x, y] = groups(self.light_count.into());
        commands.pass("ism.clear", |pass| {
            pass.fill(&self.seen, 0);
            if self.way == BuildPath::Atomic {
                pass.fill(&self.maps, NOTHING);
            }
        });
        match &self.passes {
            Passes::Tiled(tiled) => commands.pass("ism.tiled", |pass| pass.dispatch(tiled, &push, [x, y, 1])),
            Passes::Atomic { splat, fill } => {
                let [all_x, all_y] = groups(u64::from(self.light_count) * u64::from(points / SPLAT_THREADS));
                commands.pass("ism.splat", |pass| pass.dispatch(splat, &push, [all_x, all_y, 1]));
                commands.pass("ism.fill", |pass| pass.dispatch(fill, &push, [x, y, 1]));
            }
            Passes::Raster { raster, fill } => {
                raster.record(commands, &push);
                commands.pass("ism.fill", |pass| pass.dispatch(fill, &push, [x, y, 1]));
            }
        }
    }

    /// Returns the number of bytes that look-ups do not need.
    pub(super) fn transient_bytes(&self) -> u64 {
        let raster = if let Passes::Raster { raster, .. } = &self.passes { raster.transient_bytes() } else { 0 };
        self.seen.bytes() + raster
    }
}

/// Bits of an empty texel. Twin: NOTHING.
const NOTHING: u32 = f32::INFINITY.to_bits();

/// Returns the number of texels from one map to the next. Maps that are built in memory keep their coarser levels there too.
fn stride(settings: &Settings, way: BuildPath) -> u32 {
    match way {
        BuildPath::Tiled => settings.size.pow(2),
        BuildPath::Atomic | BuildPath::Quads | BuildPath::Triangles => settings.texels(),
    }
}
