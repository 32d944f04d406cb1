//! Virtual lights that follow the camera: texels are weighted by how much of their light reaches what the camera sees. Source: Ritschel et
//! al. 2011, *Making imperfect shadow maps view-adaptive*. Twin: reference::twin::indirect.

use super::ViewSeen;
use super::passes::{FluxPush, SumsPush, THREADS};
use crate::Result;
use crate::gpu::{
    Bindings, Blend, Buffer, Commands, Constants, Context, Format, Graphics, Image, ImageUse, Kernel, Memory, Target,
    groups,
};
use crate::scene::View;
use crate::shaders::{constant::SIDE_BITS, indirect as shaders, set};
use crate::world::{CameraPush, World};
use bytemuck::{Pod, Zeroable};

/// Number of points across and down the picture. Twin: POINTS_ACROSS in glsl/lights/indirect/view.glsl.
pub const POINTS_ACROSS: u32 = 16;

/// A point that the camera sees. Twin: ViewPoint in glsl/lights/indirect/view.glsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct ViewPointData {
    /// Position in world units.
    pub position: [f32; 3],
    /// Area of the surface that the point represents, divided by π.
    pub area: f32,
    /// Unit normal, on the outside of closed meshes.
    pub normal: [f32; 3],
    /// Luminance of the albedo; 0 if the camera sees no mesh.
    pub weight: f32,
    /// 1 if lit from either side.
    pub is_open: u32,
}

/// What the camera sees, and the passes that weight texels by it.
pub(super) struct ViewImportance {
    pub(super) camera: View,
    pub(super) numbers: Image,
    depth: Image,
    pub(super) points: Buffer,
    pub(super) importances: Buffer,
    pub(super) mean: Buffer,
    draw: Kernel<CameraPush>,
    see: Kernel<CameraPush>,
    importance: Kernel<SumsPush>,
    sum: Kernel<SumsPush>,
    weigh: Kernel<FluxPush>,
}

impl ViewImportance {
    /// Creates buffers and passes for `rows` rows of texels. `sets` are the descriptor sets of the passes that create virtual lights.
    pub(super) fn new(
        context: &Context,
        world: &World,
        sets: [&Bindings; 3],
        [rows, side_bits]: [u32; 2],
        camera: &View,
    ) -> Result<Self> {
        let size = [POINTS_ACROSS; 2];
        let numbers = Image::new(context, "indirect.numbers", Format::R32_UINT, size, ImageUse::Color)?;
        let depth = Image::new(context, "indirect.depth", Format::D32_SFLOAT, size, ImageUse::Depth)?;
        let buffer = |name, bytes: u64| Buffer::new(context, name, bytes, Memory::Device);
        let points = u64::from(POINTS_ACROSS * POINTS_ACROSS) * size_of::<ViewPointData>() as u64;
        let points = buffer("indirect.view_points", points)?;
        let importances = buffer("indirect.importances", (4 * u64::from(rows)) << side_bits)?;
        let [row_fluxes, mean] = [buffer("indirect.row_fluxes", 8 * u64::from(rows))?, buffer("indirect.mean", 4)?];
        let view = set::IndirectView { view_sides: &world.sides, numbers: &numbers, view_points: &points };
        let view = view.bind(context, "indirect.view")?;
        let weighed = set::IndirectWeighed {
            view_points: &points,
            importances: &importances,
            row_fluxes: &row_fluxes,
            mean_importance: &mean,
        };
        let weighed = weighed.bind(context, "indirect.weighed")?;
        let [maps, lit, drawn] = sets;
        let state = Graphics {
            vertex: &shaders::EYE_VERT,
            fragment: &shaders::MAP_FRAG,
            colors: &[(Format::R32_UINT, Blend::None)],
            depth: Some(Format::D32_SFLOAT),
        };
        let constants = Constants::new().set(SIDE_BITS, side_bits);
        let all = [maps, lit, drawn, &weighed];
        Ok(Self {
            camera: *camera,
            draw: Kernel::graphics(context, &state, &[maps], &world.constants())?,
            see: Kernel::compute(context, &shaders::VIEW_POINTS, &[maps, &view], &Constants::new())?,
            importance: Kernel::compute(context, &shaders::IMPORTANCE, &all, &constants)?,
            sum: Kernel::compute(context, &shaders::MEAN, &all, &Constants::new())?,
            weigh: Kernel::compute(context, &shaders::WEIGH, &all, &Constants::new())?,
            numbers,
            depth,
            points,
            importances,
            mean,
        })
    }

    /// Finds the points that the camera sees, and weights the flux of each texel by the light that reaches them. Writes the largest weight
    /// to `greatest`.
    pub(super) fn record(&self, commands: &mut Commands, world: &World, [rows, texels]: [u32; 2], greatest: &Buffer) {
        // One pixel per point.
        let camera = View { width: POINTS_ACROSS, height: POINTS_ACROSS, ..self.camera };
        let camera = CameraPush::of(&camera);
        commands.pass("indirect.eye", |pass| {
            // The pass that computes weights raises this number to the largest weight.
            pass.fill(greatest, 0);
            let target = |image, clear: f32| Target { image, clear: Some([clear; 4]) };
            let depth = target(&self.depth, 1.0);
            pass.render(self.numbers.size(), &[target(&self.numbers, 0.0)], Some(depth), |draw| {
                draw.draw(&self.draw, &camera, 3 * world.triangle_count(), 1);
            });
        });
        let all = POINTS_ACROSS * POINTS_ACROSS / THREADS;
        commands.pass("indirect.view_points", |pass| pass.dispatch(&self.see, &camera, [all, 1, 1]));
        let push = SumsPush { row_count: rows };
        let [x, y] = groups(rows.into());
        commands.pass("indirect.importance", |pass| pass.dispatch(&self.importance, &push, [x, y, 1]));
        commands.pass("indirect.mean", |pass| pass.dispatch(&self.sum, &push, [1, 1, 1]));
        let [x, y] = groups(u64::from(texels / THREADS));
        let push = FluxPush { texel_count: texels };
        commands.pass("indirect.weigh", |pass| pass.dispatch(&self.weigh, &push, [x, y, 1]));
    }

    /// Reads the buffers back.
    pub(super) fn seen(&self) -> Result<ViewSeen> {
        Ok(ViewSeen {
            numbers: self.numbers.read()?,
            points: self.points.read((POINTS_ACROSS * POINTS_ACROSS) as usize)?,
            importances: self.importances.read(self.importances.bytes() as usize / 4)?,
            mean: self.mean.read::<f32>(1)?[0],
        })
    }
}
