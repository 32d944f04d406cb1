//! The views of all maps, fitted on the device to the current casters and meshes. Twin:
//! [`crate::reference::twin::fit`].

use super::Map;
use crate::Result;
use crate::gpu::{Bindings, Buffer, Commands, Constants, Context, Kernel, Memory, push_struct};
use crate::shaders::maps::{AIM, BOUNDS, FIT};
use crate::shaders::set;
use crate::world::World;
use bytemuck::{Pod, Zeroable};
use glam::DVec3;

/// Casters or triangles per thread.
const PER_THREAD: u64 = 8;

/// Maximum number of workgroups per map: each ends with a few atomics.
const MOST_GROUPS: u64 = 1024;

/// Twin: Extents in glsl/maps/extents.glsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Extents {
    /// Lower bounds of the casters, then of the meshes, along right, up and forward, as integers that sort like the floats.
    pub low: [u32; 6],
    /// Upper bounds, in the same form.
    pub high: [u32; 6],
}

impl Extents {
    /// Empty extents.
    pub const NONE: Self = Self { low: [u32::MAX; 6], high: [0; 6] };
}

push_struct! {
    /// Twin: AimPush in glsl/maps/aim.comp.
    struct AimPush {
        light_count: u32,
        map_count: u32,
        /// Number of maps per cascade, over all lights.
        cascade_maps: u32,
    }
}

push_struct! {
    /// Twin: BoundsPush in glsl/maps/bounds.comp.
    struct BoundsPush {
        caster_count: u32,
        triangle_count: u32,
        /// Threads per map.
        threads: u32,
        /// Nonzero if there are strands.
        see_all: u32,
    }
}

push_struct! {
    /// Twin: FitPush in glsl/maps/fit.comp.
    struct FitPush {
        map_count: u32,
        /// Nonzero if nothing translucent casts.
        only_meshes: u32,
        /// Number of maps per cascade, over all lights.
        cascade_maps: u32,
        /// The camera's position.
        eye: [f32; 3],
        /// The camera's direction, normalized.
        ahead: [f32; 3],
    }
}

/// The passes that fit the maps.
pub(super) struct Fit {
    context: Context,
    /// Aims maps with lights that only the device knows; created once there are such lights.
    aim: Option<Kernel<AimPush>>,
    /// [`Extents`] of each map.
    extents: Buffer,
    bounds: Kernel<BoundsPush>,
    fit: Kernel<FitPush>,
}

impl Fit {
    /// Creates the passes that fit `maps`, a buffer that is also bound in set 0, `scene`.
    pub(super) fn new(context: &Context, world: &World, maps: &Buffer, scene: &Bindings, count: u32) -> Result<Self> {
        let bytes = size_of::<Extents>() as u64 * u64::from(count);
        let extents = Buffer::new(context, "maps.extents", bytes, Memory::Device)?;
        let reduced = set::MapsBounds { extents: &extents }.bind(context, "maps.bounds")?;
        let fitted = set::MapsFit { maps, extents: &extents }.bind(context, "maps.fit")?;
        let none = Constants::new();
        Ok(Self {
            context: context.clone(),
            aim: if world.knows_lights() { None } else { Some(aim(context, world, maps)?) },
            bounds: Kernel::compute(context, &BOUNDS, &[scene, &reduced], &none)?,
            fit: Kernel::compute(context, &FIT, &[&fitted], &none)?,
            extents,
        })
    }

    /// Fits `maps` to the current world and its first `casters` casters; `aimed` holds the maps before fitting
    /// ([`Map::aimed`]), as far as the host knows the lights.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] if the device has no room for the kernel that aims the maps.
    pub(super) fn record(
        &mut self,
        commands: &mut Commands,
        world: &World,
        casters: u32,
        maps: &Buffer,
        aimed: &[Map],
    ) -> Result<()> {
        if !world.knows_lights() && self.aim.is_none() {
            self.aim = Some(aim(&self.context, world, maps)?);
        }
        let count = aimed.len() as u32;
        commands.pass("maps.aim", |pass| {
            pass.update(maps, aimed);
            pass.update(&self.extents, &vec![Extents::NONE; aimed.len()]);
        });
        if let Some(kernel) = self.aim.as_ref().filter(|_| !world.knows_lights()) {
            let (light_count, cascade_maps) = (world.light_count(), world.map_count() as u32);
            let push = AimPush { light_count, map_count: count, cascade_maps };
            let groups = [light_count.div_ceil(64), 1, 1];
            commands.pass("maps.aim", |pass| pass.dispatch(kernel, &push, groups));
        }
        let triangles = world.triangle_count();
        let things = u64::from(casters.max(triangles));
        let groups = things.div_ceil(64 * PER_THREAD).clamp(1, MOST_GROUPS) as u32;
        let push = BoundsPush {
            caster_count: casters,
            triangle_count: triangles,
            threads: 64 * groups,
            see_all: u32::from(world.shows_strands()),
        };
        commands.pass("maps.bounds", |pass| pass.dispatch(&self.bounds, &push, [groups, 1, count]));
        let (eye, ahead) = world.camera().map_or((DVec3::ZERO, DVec3::X), |c| (c.position, c.target - c.position));
        let push = FitPush {
            map_count: count,
            only_meshes: u32::from(casters == 0),
            cascade_maps: world.map_count() as u32,
            eye: eye.as_vec3().into(),
            ahead: ahead.normalize_or(DVec3::X).as_vec3().into(),
        };
        commands.pass("maps.fit", |pass| pass.dispatch(&self.fit, &push, [count.div_ceil(64), 1, 1]));
        Ok(())
    }
}

/// Creates the kernel that aims maps with the world's lights, as stored on the device.
fn aim(context: &Context, world: &World, maps: &Buffer) -> Result<Kernel<AimPush>> {
    let set = set::MapsAim { maps, lights: &world.lights }.bind(context, "maps.aim")?;
    Kernel::compute(context, &AIM, &[&set], &Constants::new())
}
