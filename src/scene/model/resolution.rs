//! How finely a technique knows where opaque shadows begin and end.

use crate::scene::{Projection, View};
use glam::DVec3;

/// How far a receiver is moved in a grid beyond the reach of a voxel, voxels. Twin: RECEIVER_MARGIN in
/// glsl/technique/voxel_grid/visibility.glsl.
const GRID_MARGIN: f64 = 1e-3;

/// The resolution of one of a technique's maps, or of a grid in a map's place: the size of details that it cannot tell
/// apart.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Resolution {
    /// Whose texels count, and whose range.
    pub view: View,
    /// Whether the view's texels are those of a [paraboloid](View::paraboloid).
    pub paraboloid: bool,
    /// Whether it is a face of a light that has one each way: a receiver that is moved out of it is looked up in the
    /// next.
    pub faces: bool,
    /// How far across the light's rays, in texels of the view, a look-up may feel a surface.
    pub reach_texels: f64,
    /// How far a compared texel's centre may be from a point, texels across and down, where what a texel holds is compared with the
    /// point's surface by what that changes over as much; 0 where it is not.
    pub pushed_texels: f64,
    /// How much nearer to the light than a point of a surface the point's caster must be, texels.
    pub nearer_texels: f64,
    /// How far beside a texel's centre, texels, the depth may have been taken that it holds, and that is compared with a surface's plane; 0
    /// where there are no such depths.
    pub snap_texels: f64,
    /// How far along its normal a point of a surface is moved before it is looked up.
    pub moved: Moved,
    /// Whether it may answer anything inside closed meshes: points closer to their inside than the resolution are boundary too.
    pub free_inside: bool,
    /// How far along the rays, as a share of the view's range.
    pub depth: f64,
    /// Side of a voxel, world units, where rays go through a grid in the world's axes; 0 for none. Then a surface may be felt
    /// anywhere in the voxels of a ray, and nothing else that stands here counts.
    pub voxel: f64,
    /// Whether a surface so near to a ray may be missed too: no voxel holds it, and `voxel` is what rounding moves a ray by.
    pub rounded: bool,
    /// How far a point of a surface is moved in such a grid along its ray, once it is off the surface, voxels.
    pub bias: f64,
}

impl Resolution {
    /// The resolution of a grid with voxels of that side, or cells of them, that moves receivers so far along their
    /// rays.
    pub fn of_grid(view: View, voxel: f64, bias: f64) -> Self {
        Self { voxel, bias, ..Self::exact(view) }
    }

    /// The resolution of rays against triangles, both of which may be taken to be so far beside where they are.
    pub fn of_triangles(view: View, rounding: f64) -> Self {
        Self { voxel: rounding, rounded: true, ..Self::exact(view) }
    }

    /// The resolution of a map whose paraboloid is `view`, asked at the four texels about a place: each of them is up to a texel away, and stands
    /// for half a texel about its middle. A surface is compared on the rays through these middles, no farther away than its point: so
    /// what is before the point by less than it changes over a texel is missed, as where depths are pushed back, and what is less than
    /// half a texel before it. Twins: NEARER_TEXELS, surface_distance in glsl/technique/ism/visibility.glsl.
    pub fn of_paraboloid(view: View) -> Self {
        let (reach_texels, pushed_texels, nearer_texels) = (1.5, 1.0, 0.5);
        Self { paraboloid: true, reach_texels, pushed_texels, nearer_texels, ..Self::exact(view) }
    }

    /// The resolution of exact techniques.
    pub fn exact(view: View) -> Self {
        Self {
            view,
            paraboloid: false,
            faces: false,
            reach_texels: 0.0,
            pushed_texels: 0.0,
            nearer_texels: 0.0,
            snap_texels: 0.0,
            moved: Moved::default(),
            free_inside: false,
            depth: 0.0,
            voxel: 0.0,
            rounded: false,
            bias: 0.0,
        }
    }

    /// Where a point of a surface with that normal is looked up, world units, in a grid before it is moved along its ray; and where a grid has
    /// a virtual light of that normal.
    pub fn looked_up(&self, position: DVec3, normal: DVec3) -> DVec3 {
        if self.voxel > 0.0 {
            return position + self.voxel * (normal.abs().element_sum() + GRID_MARGIN) * normal;
        }
        let way = self.way(&self.view_about(position), position, normal);
        let at = position + normal * way;
        if !self.faces {
            return at;
        }
        position + normal * way.max(self.way(&self.view.face_towards(at), position, normal))
    }

    /// How far along its normal a point is moved. Twin: receiver_way in glsl/technique/voxelized/place.glsl.
    fn way(&self, view: &View, position: DVec3, normal: DVec3) -> f64 {
        let ([right, up], along) = (view.texel_at(position), view.ray_through(position).direction);
        let Moved { across, along: forward, always, least_world, felt: _ } = self.moved;
        let beside = across * (normal.dot(right).abs() + normal.dot(up).abs()) + always * right.length();
        let before = forward * f64::from(view.far - view.near) * normal.dot(along).abs();
        if self.paraboloid || view.projection() == Projection::Parallel {
            return (beside + before).max(least_world);
        }
        if self.snap_texels > 0.0 {
            // A map of depths leaves nothing out of its light.
            let height = (view.ray_through(position).origin - position).dot(normal);
            return (beside + before).min(0.5 * height).max(least_world);
        }
        let z = view.axes(position).z;
        if z <= 0.0 {
            return 0.0;
        }
        // A texel is wider behind the point, and a ray steeper before it: as much as that counts where the point is then.
        let looks = normal.dot(DVec3::from(view.forward.map(f64::from)));
        let more = if looks > 0.0 { beside / z * looks } else { -2.0 * before / z * looks };
        ((beside + before) / (1.0 - more.min(0.5))).max(least_world)
    }

    /// The view whose texels count about a place.
    pub fn view_about(&self, position: DVec3) -> View {
        if self.paraboloid { self.view.about(position) } else { self.view }
    }
}

/// How far along its normal a point of a surface is moved, so that the surface stays behind it: texels as much as the normal looks
/// along the view's right and up, a share of the view's range as much as it looks along the light's ray, texels in full; and what it
/// is moved by in any case. All are 0 where points stay where they are.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Moved {
    /// Times |right · n| + |up · n|.
    pub across: f64,
    /// A share of the view's range, times |d · n|, with d the ray's direction, as long as forward counts 1 in it: as far along the light's rays the surface then stays behind
    /// what is asked.
    pub along: f64,
    /// Whatever the normal.
    pub always: f64,
    /// The least of all that, world units.
    pub least_world: f64,
    /// How far along the light's rays a look-up may feel a surface from there, of the view's range.
    pub felt: f64,
}
