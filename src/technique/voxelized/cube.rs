//! The voxels of a light. For parallel light, a cube fitted to the meshes, with its z axis along the light. For a light with a position, a
//! pyramid with the light at its tip.

use super::Plan;
use crate::scene::{Casting, Light, LightKind, Moved, Projection, Resolution, View};
use crate::world::World;
use crate::{Error, Result};
use glam::DVec3;
use std::ops::Range;

/// Twin: ROUNDING in glsl/technique/voxelized/visibility.glsl.
const ROUNDING: f64 = 1.0 / 32.0;

/// Fraction by which the cube is wider than the meshes, so that rounded points stay inside.
const MARGIN: f64 = 1.0 / 256.0;

/// Views whose texels are columns of voxels. Each view has `size` columns per side, and each column is `size` voxels deep.
pub struct Cubes {
    /// Views of all lights.
    pub views: Vec<View>,
    /// The range of each light's views: one view, or one per face.
    pub lights: Vec<Range<usize>>,
}

/// Refuses lights that only the device knows.
pub fn lights_are_known(world: &World) -> Result<()> {
    match world.knows_lights() {
        true => Ok(()),
        false => Err(Error::Refused("lights that the host knows (World::update_lights)".into())),
    }
}

impl Cubes {
    /// Fits views to the current meshes. Source: Sintorn et al. 2014, section 3.
    ///
    /// # Errors
    /// [`Error::Refused`] if the host does not know the lights or a bounding box of the triangles.
    pub fn new(world: &World, size: u32) -> Result<Self> {
        lights_are_known(world)?;
        let mut aimed = View::aimed(&world.aim(), size, Casting::Opaque).into_iter();
        let (mut views, mut lights) = (Vec::new(), Vec::new());
        for light in world.all_lights() {
            let first = views.len();
            for view in aimed.by_ref().take(light.map_count()) {
                views.push(match view.projection() {
                    Projection::Parallel => cube(world.mesh_hull()?, view),
                    Projection::Perspective => pyramid(world.mesh_hull()?, light, view),
                });
            }
            lights.push(first..views.len());
        }
        Ok(Self { views, lights })
    }

    /// Returns whether the light of a view has a position.
    pub fn is_perspective(&self, view: usize) -> bool {
        self.views.get(view).is_some_and(|view| view.projection() == Projection::Perspective)
    }

    /// Returns whether the light of any view has a position.
    pub fn has_perspective(&self) -> bool {
        (0..self.views.len()).any(|view| self.is_perspective(view))
    }
}

/// Returns how finely columns resolve where shadows begin and end.
pub fn resolution(cubes: &Cubes, plan: &Plan) -> Vec<Resolution> {
    // A column's edge is half a voxel from its centre. The filter's outermost column is farther away by the filter's radius. A triangle
    // that touches a column may be up to a voxel away from a point in the column.
    let across = f64::from(plan.filter) / 2.0 + if plan.is_conservative() { 0.5 } else { 0.0 };
    let reach_texels = across + ROUNDING / 2.0;
    let depth = 1.0 / f64::from(plan.size);
    let of = |view: View, faces: bool| {
        // A voxel of a pyramid may be longer than a column is wide, so the rounding error of its depth is larger.
        let along = if view.projection() == Projection::Perspective { 0.5 + ROUNDING } else { 0.5 };
        // With a bias below 100, a surface stays within its own columns, so all its points count as within the resolution.
        let bias = f64::from(plan.bias) / 100.0;
        let (across, felt) = (bias * across, along * depth);
        let moved = Moved { across, along: bias * felt, always: bias * ROUNDING, felt, ..Moved::default() };
        Resolution { faces, reach_texels, moved, free_inside: plan.closed, depth, ..Resolution::exact(view) }
    };
    let lights = cubes.lights.iter();
    lights.flat_map(|light| cubes.views[light.clone()].iter().map(move |view| of(*view, light.len() > 1))).collect()
}

fn cube(hull: impl Iterator<Item = [f32; 3]>, aimed: View) -> View {
    let axes = [aimed.right, aimed.up, aimed.forward].map(|axis| DVec3::from(axis.map(f64::from)));
    let origin = DVec3::from(aimed.origin.map(f64::from));
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for position in hull {
        let offset = DVec3::from(position.map(f64::from)) - origin;
        for (axis, along) in axes.iter().map(|axis| axis.dot(offset)).enumerate() {
            (low[axis], high[axis]) = (low[axis].min(along), high[axis].max(along));
        }
    }
    let empty = low[0] > high[0];
    let middle = |axis: usize| if empty { 0.0 } else { (low[axis] + high[axis]) / 2.0 };
    let widest = (0..3).map(|axis| high[axis] - low[axis]).fold(0.0, f64::max);
    let side = widest.max(least(&aimed)) * (1.0 + MARGIN);
    let front = origin + axes[0] * middle(0) + axes[1] * middle(1) + axes[2] * (middle(2) - side / 2.0);
    let scale = (2.0 / side) as f32;
    View { origin: front.as_vec3().into(), scale_x: scale, scale_y: scale, near: 0.0, far: side as f32, ..aimed }
}

/// Builds a pyramid from the light to the farthest mesh, or as far as the light shines. A face of a point light is wider than 90 degrees,
/// so that every filter fits. The pyramid of a spot light is wider than its cone for the same reason, and because points are moved off
/// their surface.
fn pyramid(hull: impl Iterator<Item = [f32; 3]>, light: &Light, aimed: View) -> View {
    let along = |position: [f32; 3]| aimed.axes(DVec3::from(position.map(f64::from))).z;
    let farthest = hull.map(along).fold(least(&aimed), f64::max).min(light.radius);
    let gutter = f64::from((aimed.width / 16).clamp(4, 16)) / f64::from(aimed.width);
    let inner = if matches!(light.kind, LightKind::Spot { .. }) { 1.0 - 2.0 * gutter } else { 1.0 };
    let scale = (f64::from(aimed.scale_x) * inner) as f32;
    View { scale_x: scale, scale_y: scale, near: 0.0, far: (farthest * (1.0 + MARGIN)) as f32, ..aimed }
}

/// Returns the minimum side of a cube in world units: even a scene of one point gets voxels that floats can tell apart.
fn least(aimed: &View) -> f64 {
    aimed.origin.iter().fold(1.0, |most: f64, v| most.max(f64::from(v.abs()))) * 1e-3
}
