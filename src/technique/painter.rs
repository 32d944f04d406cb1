//! Painters, for techniques that light casters while the picture is painted and cannot evaluate a point in space. Slices are stacked along
//! the half vector between light and camera. The light's buffer holds the light left by the slices so far. The renderer draws a slice, lit
//! by the buffer, then draws that slice into the buffer, and continues with the next. Sources: Kniss et al. 2003; Green 2008.

use super::Technique;
use crate::gpu::{
    Bindings, Blend, Buffer, Commands, Constants, Context, Format, Image, ImageUse, Kernel, Pass, Resource, Shader,
    Target, groups, push_struct,
};
use crate::maps::{CasterQuads, Maps, Order, QuadsPush};
use crate::scene::View;
use crate::shaders::set;
use crate::world::World;
use crate::{Error, Result};
use glam::Vec3;
use std::ops::Range;
use std::sync::{Mutex, PoisonError};

push_struct! {
    /// Twin: HalfPush in glsl/technique/half_angle/keys.comp.
    struct HalfPush {
        half_vector: [f32; 3],
        count: u32,
    }
}

/// The slices, their order, and the light's buffer.
pub struct Painter {
    /// Number of slices, each with the same number of casters.
    slices: u32,
    /// Light left by the slices so far.
    light: Image,
    draw: Kernel<QuadsPush>,
    quads: CasterQuads,
    keys: Kernel<HalfPush>,
    order: Order,
    /// Direction of the light at the last build.
    forward: Mutex<[f32; 3]>,
    /// Bindings through which look-ups read the light's buffer.
    pub look_up: Bindings,
    /// Bindings of the casters' order, for glsl/shading/sliced.vert.
    pub sorted: Bindings,
}

/// What a technique supplies to create a [`Painter`].
pub(super) struct PainterKernels<'a> {
    pub name: &'static str,
    pub slices: u32,
    /// The format of the light's buffer.
    pub format: Format,
    /// Draws a caster into the light's buffer (maps/caster_quads.glsl).
    pub fragment: &'a Shader,
    /// Writes the sort key of each caster.
    pub keys: &'a Shader,
    pub constants: &'a Constants,
}

/// Returns the unit vector along which slices are stacked, which points away from the light, and whether the slices in this order run from
/// near to far for the camera. `camera` is the camera's viewing direction, `light` the direction in which the light shines.
/// Twin: reference::twin::half_angle::half_vector.
pub fn half_vector(camera: Vec3, light: Vec3) -> (Vec3, bool) {
    let near_to_far = camera.dot(light) >= 0.0;
    ((light + if near_to_far { camera } else { -camera }).normalize_or_zero(), near_to_far)
}

/// Checks that the technique can evaluate points in space; a technique that paints casters cannot.
///
/// # Errors
/// [`Error::Refused`] if the technique paints casters.
pub fn answers_in_space(technique: &dyn Technique) -> Result<()> {
    let needs = "a technique that answers at points in space, and this one paints the picture: name another";
    if technique.answer().painter.is_none() { Ok(()) } else { Err(Error::Refused(needs.into())) }
}

impl Painter {
    pub(super) fn new(context: &Context, world: &World, maps: &Maps, kernels: &PainterKernels) -> Result<Self> {
        let PainterKernels { name, slices, format, fragment, keys, constants } = *kernels;
        let light = Image::new(context, name, format, maps.size(), ImageUse::Color)?;
        let order = Order::new(context, world.caster_capacity(), 1)?;
        let quads = CasterQuads::sorted_by(context, world, maps, &order.sorted)?;
        let items = set::OrderKeys { items: &order.items }.bind(context, name)?;
        Ok(Self {
            slices,
            draw: quads.kernel(context, maps, fragment, &[(format, Blend::Multiply)], &[], constants)?,
            keys: Kernel::compute(context, keys, &[maps.scene(), &items], &Constants::new())?,
            look_up: maps.look_up(context, name, &[Resource::Texture(light.clone())])?,
            sorted: set::SlicedOrder { sorted: &order.sorted }.bind(context, name)?,
            forward: Mutex::default(),
            light,
            quads,
            order,
        })
    }

    fn forward(&self) -> [f32; 3] {
        *self.forward.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Sets the direction in which the light shines.
    pub(super) fn set_forward(&self, direction: [f32; 3]) {
        *self.forward.lock().unwrap_or_else(PoisonError::into_inner) = direction;
    }

    /// Returns whether the slices run from near to far for this camera. If so, each slice is blended behind the picture so far, not over
    /// it.
    pub fn near_to_far(&self, camera: &View) -> bool {
        half_vector(camera.forward.into(), self.forward().into()).1
    }

    /// Sorts the first `count` casters into slice order for this camera.
    pub fn sort(&self, commands: &mut Commands, camera: &View, count: u32) {
        let (half, _) = half_vector(camera.forward.into(), self.forward().into());
        let [x, y] = groups(u64::from(count).div_ceil(64));
        let push = HalfPush { half_vector: half.into(), count };
        commands.pass("half_angle.keys", |pass| pass.dispatch(&self.keys, &push, [x, y, 1]));
        self.order.sort(commands, count);
    }

    /// Returns the slices of `count` casters, each as a range of positions in the sorted order; empty slices are omitted.
    pub fn slices(&self, count: u32) -> impl Iterator<Item = Range<u32>> + use<> {
        let slices = self.slices;
        let at = move |slice: u32| (u64::from(slice) * u64::from(count) / u64::from(slices)) as u32;
        (0..slices).map(move |slice| at(slice)..at(slice + 1)).filter(|places| !places.is_empty())
    }

    /// Returns the indices of casters in slice order.
    pub fn order(&self) -> &Buffer {
        &self.order.sorted
    }

    /// Draws casters into the light's buffer. Without casters, resets the buffer to full light.
    pub fn light(&self, pass: &mut Pass, places: Range<u32>) {
        let clear = places.is_empty().then_some([1.0; 4]);
        pass.render(self.light.size(), &[Target { image: &self.light, clear }], None, |draw| {
            if clear.is_none() {
                self.quads.draw_places(draw, &self.draw, places);
            }
        });
    }

    /// Returns the size of the buffer and the order, in bytes.
    pub(super) fn bytes(&self) -> u64 {
        self.light.bytes() + self.order.bytes()
    }
}
