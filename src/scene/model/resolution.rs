//! How finely a technique knows where opaque shadows begin and end.

use crate::scene::{Projection, View};
use glam::DVec3;

/// What a receiver is moved by in a grid, voxels, more than a voxel reaches. Twin: RECEIVER_MARGIN in
/// glsl/technique/voxel_grid/visibility.glsl.
const GRID_MARGIN: f64 = 1e-3;

/// Of one of a technique's maps, or of what stands for a map: the size of what it cannot tell apart.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Resolution {
    /// Whose texels count, and whose range.
    pub view: View,
    /// Whether the view's texels are those of a [paraboloid](View::paraboloid).
    pub paraboloid: bool,
    /// How far across the light's rays, in texels of the view, a look-up may feel a surface.
    pub reach_texels: f64,
    /// How far beside a texel's centre, texels, the depth may have been taken that it holds, and that is compared with a surface's plane; 0
    /// where there are no such depths.
    pub snap_texels: f64,
    /// How far along its normal a point of a surface is moved before it is looked up.
    pub moved: Moved,
    /// Whether it may answer anything inside closed things: what is nearer to their inside than it resolves is boundary too.
    pub free_inside: bool,
    /// How far along the rays, as a share of the view's range.
    pub depth: f64,
    /// Side of a voxel, world units, where rays go through a grid in the world's axes; 0 for none. Then a surface may be felt
    /// anywhere in the voxels of a ray, and nothing else that stands here counts.
    pub voxel: f64,
}

impl Resolution {
    /// Of a grid with voxels of that side.
    pub fn of_grid(view: View, voxel: f64) -> Self {
        Self { voxel, ..Self::exact(view) }
    }

    /// The resolution of a map whose paraboloid is `view`, asked at the four texels about a place: each of them is up to a texel away, and stands
    /// for half a texel about its middle. Points of surfaces are moved by as much, and by `least_world` at least.
    pub fn of_paraboloid(view: View, least_world: f64) -> Self {
        const REACH: f64 = 1.5;
        let moved = Moved { always: REACH, least_world, ..Moved::default() };
        Self { paraboloid: true, reach_texels: REACH, moved, ..Self::exact(view) }
    }

    /// The resolution of what knows all exactly.
    pub fn exact(view: View) -> Self {
        Self {
            view,
            paraboloid: false,
            reach_texels: 0.0,
            snap_texels: 0.0,
            moved: Moved::default(),
            free_inside: false,
            depth: 0.0,
            voxel: 0.0,
        }
    }

    /// Where a point of a surface with that normal is looked up, world units; and where a grid has a virtual light of that normal.
    pub fn looked_up(&self, position: DVec3, normal: DVec3) -> DVec3 {
        if self.voxel > 0.0 {
            return position + self.voxel * (normal.abs().element_sum() + GRID_MARGIN) * normal;
        }
        let view = self.view_about(position);
        let ([right, up], along) = (view.texel_at(position), view.ray_through(position).direction);
        let Moved { across, along: forward, always, least_world } = self.moved;
        let looks = (normal.dot(along) / along.length()).abs();
        let by =
            across * (normal.dot(right).abs() + normal.dot(up).abs()) + (forward * looks + always) * right.length();
        // A map of depths leaves nothing out of its light.
        let is_parallel = self.snap_texels == 0.0 || view.projection() == Projection::Parallel;
        let height = (view.ray_through(position).origin - position).dot(normal);
        let by = if is_parallel { by } else { by.min(0.5 * height) };
        position + normal * by.max(least_world)
    }

    /// The view whose texels count about a place.
    pub fn view_about(&self, position: DVec3) -> View {
        if self.paraboloid { self.view.about(position) } else { self.view }
    }
}

/// How far along its normal a point of a surface is moved, so that the surface stays behind it: three numbers of texels, of which
/// one counts as much as the normal looks along the view's right and up, the next as much as it looks forward, the third in full;
/// and what it is moved by in any case. All are 0 where points stay where they are.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Moved {
    /// Times |right · n| + |up · n|.
    pub across: f64,
    /// Times |forward · n|: as far along the light's rays the surface then stays behind what is asked.
    pub along: f64,
    /// Whatever the normal.
    pub always: f64,
    /// The least of all that, world units.
    pub least_world: f64,
}
