//! The cube of voxels of a light: fitted to the meshes, its z along the light.

use super::Plan;
use crate::scene::{Casting, LightKind, Moved, Resolution, View};
use crate::world::World;
use crate::{Error, Result};
use glam::DVec3;

/// Twin: ROUNDING in glsl/technique/voxelized/visibility.glsl.
const ROUNDING: f64 = 1.0 / 32.0;

/// The cube is wider than the meshes by this share, so that what rounds stays inside.
const MARGIN: f64 = 1.0 / 256.0;

/// Of each light, the view whose texels are the columns of its cube, `size` a side, and whose range is as long as it is wide.
/// Source: Sintorn et al. 2014, section 3.
///
/// # Errors
/// [`Error::Refused`] where a light is not directional, or the host knows no box about the triangles.
pub fn cubes(world: &World, size: u32) -> Result<Vec<View>> {
    if !world.all_lights().iter().all(|light| matches!(light.kind, LightKind::Directional { .. })) {
        return Err(Error::Refused { needs: "directional lights".into() });
    }
    let aimed = View::aimed(&world.aim(), size, Casting::Opaque);
    aimed.into_iter().map(|view| Ok(cube(world.mesh_hull()?, view))).collect()
}

/// How finely columns know where shadows begin and end.
pub fn resolution(cubes: &[View], plan: &Plan) -> Vec<Resolution> {
    // A column's middle is half a voxel away from its edge, and that of the filter's outermost column as many more.
    // What touches a column is up to a voxel away from a place in it.
    let across = f64::from(plan.filter) / 2.0 + if plan.is_conservative() { 0.5 } else { 0.0 };
    let reach_texels = across + ROUNDING / 2.0;
    // Less of that leaves a surface within its own columns: then all of it is within.
    let bias = f64::from(plan.normal_bias) / 100.0;
    let moved =
        Moved { across: bias * across, along: bias * 0.5, always: bias * ROUNDING, felt: 0.5, ..Moved::default() };
    let depth = 1.0 / f64::from(plan.size);
    let free_inside = plan.closed;
    let of = |view| Resolution { reach_texels, moved, free_inside, depth, ..Resolution::exact(view) };
    cubes.iter().copied().map(of).collect()
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
    // A scene of one point has a cube too, wide enough that its corners differ.
    let least = origin.abs().max_element().max(1.0) * 1e-3;
    let side = widest.max(least) * (1.0 + MARGIN);
    let front = origin + axes[0] * middle(0) + axes[1] * middle(1) + axes[2] * (middle(2) - side / 2.0);
    let scale = (2.0 / side) as f32;
    View { origin: front.as_vec3().into(), scale_x: scale, scale_y: scale, near: 0.0, far: side as f32, ..aimed }
}
