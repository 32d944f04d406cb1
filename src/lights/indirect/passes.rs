//! The passes that create virtual lights, each named after its shader.

use crate::Result;
use crate::gpu::{
    Bindings, Blend, Commands, Constants, Context, Format, Graphics, Kernel, Target, groups, push_struct,
};
use crate::lights::indirect::Vpls;
use crate::maps::opaque_corner;
use crate::shaders::{constant::SIDE_BITS, indirect as shaders};
use crate::world::World;

push_struct! {
    /// Twin: SeenPush in glsl/lights/indirect/map.vert.
    pub(super) struct SeenPush {
        map: u32,
        /// The map's corner in the image of all maps, in texels.
        corner: [u32; 2],
    }
}

push_struct! {
    /// Twin: FluxPush in glsl/lights/indirect/flux.comp and weigh.comp.
    pub(super) struct FluxPush { texel_count: u32 }
}

push_struct! {
    /// Twin: SumsPush in glsl/lights/indirect/sums.comp, scan.comp, importance.comp and mean.comp.
    pub(super) struct SumsPush { row_count: u32 }
}

push_struct! {
    /// Twin: DrawPush in glsl/lights/indirect/draw.comp and lights.comp.
    pub(super) struct DrawPush {
        light_count: u32,
        map_count: u32,
    }
}

/// Threads per workgroup, in passes over texels or lights.
pub(super) const THREADS: u32 = 64;

pub(super) struct Kernels {
    map: Kernel<SeenPush>,
    flux: Kernel<FluxPush>,
    sums: Kernel<SumsPush>,
    scan: Kernel<SumsPush>,
    draw: Kernel<DrawPush>,
    lights: Kernel<DrawPush>,
}

impl Kernels {
    /// `constants` are the world's.
    pub(super) fn new(context: &Context, sets: [&Bindings; 3], side_bits: u32, constants: Constants) -> Result<Self> {
        let state = Graphics {
            vertex: &shaders::MAP_VERT,
            fragment: &shaders::MAP_FRAG,
            colors: &[(Format::R32_UINT, Blend::None)],
            depth: Some(Format::D32_SFLOAT),
        };
        let constants = constants.set(SIDE_BITS, side_bits);
        Ok(Self {
            map: Kernel::graphics(context, &state, &sets[..1], &constants)?,
            flux: Kernel::compute(context, &shaders::FLUX, &sets, &constants)?,
            sums: Kernel::compute(context, &shaders::SUMS, &sets, &constants)?,
            scan: Kernel::compute(context, &shaders::SCAN, &sets, &constants)?,
            draw: Kernel::compute(context, &shaders::DRAW, &sets, &constants)?,
            lights: Kernel::compute(context, &shaders::LIGHTS, &sets, &constants)?,
        })
    }
}

impl Vpls {
    fn texels(&self) -> u32 {
        self.maps.count() << (2 * self.side_bits)
    }

    /// Returns the number of rows of texels in all maps together.
    fn rows(&self) -> u32 {
        self.maps.count() << self.side_bits
    }

    fn draw_push(&self) -> DrawPush {
        DrawPush { light_count: self.count, map_count: self.maps.count() }
    }

    /// Draws, for each texel, the number of the triangle that the light sees through it.
    pub(super) fn map(&self, commands: &mut Commands, world: &World) {
        commands.pass("indirect.map", |pass| {
            // The flux pass raises this number to the largest flux.
            pass.fill(&self.greatest, 0);
            let target = |image, clear: f32| Target { image, clear: Some([clear; 4]) };
            let depth = target(self.maps.opaque_image(), 1.0);
            pass.render(self.seen.size(), &[target(&self.seen, 0.0)], Some(depth), |draw| {
                let size = [1 << self.side_bits; 2];
                for map in 0..self.maps.count() {
                    let corner = opaque_corner(&self.seen, size, map);
                    draw.area(corner, size);
                    draw.draw(&self.kernels.map, &SeenPush { map, corner }, 3 * world.triangle_count(), 1);
                }
            });
        });
    }

    /// Computes the flux of each texel, and the largest flux.
    pub(super) fn flux(&self, commands: &mut Commands) {
        let [x, y] = groups(u64::from(self.texels() / THREADS));
        let push = FluxPush { texel_count: self.texels() };
        commands.pass("indirect.flux", |pass| pass.dispatch(&self.kernels.flux, &push, [x, y, 1]));
    }

    /// Weights the flux of each texel by the camera, if virtual lights follow it.
    pub(super) fn weigh(&self, commands: &mut Commands, world: &World) {
        if let Some(viewed) = &self.viewed {
            viewed.record(commands, world, [self.rows(), self.texels()], &self.greatest);
        }
    }

    /// Sums the units of flux in each row of texels.
    pub(super) fn sums(&self, commands: &mut Commands) {
        let [x, y] = groups(u64::from(self.rows()));
        let push = SumsPush { row_count: self.rows() };
        commands.pass("indirect.sums", |pass| pass.dispatch(&self.kernels.sums, &push, [x, y, 1]));
    }

    /// Computes prefix sums: units of flux before each row.
    pub(super) fn scan(&self, commands: &mut Commands) {
        let push = SumsPush { row_count: self.rows() };
        commands.pass("indirect.scan", |pass| pass.dispatch(&self.kernels.scan, &push, [1, 1, 1]));
    }

    /// Chooses the texel of each virtual light.
    pub(super) fn draw(&self, commands: &mut Commands) {
        let groups = [self.count.div_ceil(THREADS), 1, 1];
        commands.pass("indirect.draw", |pass| pass.dispatch(&self.kernels.draw, &self.draw_push(), groups));
    }

    /// Writes the virtual lights for the chosen texels.
    pub(super) fn virtual_lights(&self, commands: &mut Commands) {
        let groups = [self.count.div_ceil(THREADS), 1, 1];
        commands.pass("indirect.lights", |pass| pass.dispatch(&self.kernels.lights, &self.draw_push(), groups));
    }
}
