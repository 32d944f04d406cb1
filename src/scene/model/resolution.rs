//! How precisely a technique resolves the boundaries of opaque shadows.

use crate::scene::{Projection, View};
use glam::DVec3;

/// How far a receiver in a grid is moved beyond a voxel's reach, in voxels. Twin: RECEIVER_MARGIN in
/// glsl/technique/voxel_grid/visibility.glsl.
const GRID_MARGIN: f64 = 1e-3;

/// The resolution of one of a technique's maps, or of the grid used in place of a map: the size of details that it cannot tell apart.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Resolution {
    /// The view whose texels and range the other fields refer to.
    pub view: View,
    /// Whether the map is a [paraboloid](View::paraboloid), rather than a projection of the view.
    pub paraboloid: bool,
    /// Whether the view is one of a light's six faces. A receiver that is moved out of its face is then looked up in the next face.
    pub faces: bool,
    /// How far across the light's rays a surface may affect a look-up, in texels.
    pub reach_texels: f64,
    /// For techniques whose bias follows the slope of the receiving surface: how far the centre of a compared texel may be from the point,
    /// in texels, horizontally and vertically. 0 for other techniques.
    pub pushed_texels: f64,
    /// How much nearer to the light than a surface point its caster must be to shadow it, in texel widths.
    pub nearer_texels: f64,
    /// For maps whose depths are compared with a surface's plane: how far from a texel's centre its depth may have been sampled, in texels.
    /// 0 for other techniques.
    pub snap_texels: f64,
    /// How far along its normal a surface point is moved before its look-up.
    pub moved: Moved,
    /// Whether the technique may return anything inside closed meshes. Points that are nearer to such an inside than the technique resolves
    /// then belong to the boundary too.
    pub free_inside: bool,
    /// How far along the rays a surface may affect a look-up, as a fraction of the view's range.
    pub depth: f64,
    /// Side of a voxel in world units, if rays traverse a grid aligned with the world's axes; otherwise 0. In a grid, a surface anywhere in
    /// a ray's voxels may affect the look-up, and the fields in texels are not used.
    pub voxel: f64,
    /// Whether rays are tested against triangles instead of voxels. Then `voxel` is the error bound of a rounded ray. A surface within that
    /// distance of the ray may be hit wrongly or missed.
    pub rounded: bool,
    /// If rays traverse a grid: how far a surface point is moved along its ray, after it was moved off the surface, in voxels.
    pub bias: f64,
}

impl Resolution {
    /// Returns the resolution of a grid whose voxels, or cells of voxels, have side `voxel`; receivers are moved by `bias` along their
    /// rays.
    pub fn of_grid(view: View, voxel: f64, bias: f64) -> Self {
        Self { voxel, bias, ..Self::exact(view) }
    }

    /// Returns the resolution of rays tested against triangles; `rounding` is the error bound of a rounded ray or triangle, in world units.
    pub fn of_triangles(view: View, rounding: f64) -> Self {
        Self { voxel: rounding, rounded: true, ..Self::exact(view) }
    }

    /// Returns the resolution of a paraboloid map with view `view`. A look-up reads four texels, each up to a texel from the position and
    /// covering half a texel around its centre. The depth in each texel is compared with the distance to the surface's plane along the ray
    /// through the texel's centre, capped at the point's own distance. So a caster in front of the point is missed if its distance from the
    /// point is less than the change of the plane's depth over a texel, or less than half a texel. Twins: NEARER_TEXELS, surface_distance
    /// in glsl/technique/ism/visibility.glsl.
    pub fn of_paraboloid(view: View) -> Self {
        let (reach_texels, pushed_texels, nearer_texels) = (1.5, 1.0, 0.5);
        Self { paraboloid: true, reach_texels, pushed_texels, nearer_texels, ..Self::exact(view) }
    }

    /// Returns the resolution of exact techniques, which have no boundary.
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

    /// Returns the position at which a surface point with normal `normal` is looked up, in world units. In a grid, the look-up moves that
    /// position further along the ray. A grid moves a virtual light off its surface in the same way.
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

    /// Returns how far along its normal a point is moved. Twin: receiver_way in glsl/technique/voxelized/place.glsl.
    fn way(&self, view: &View, position: DVec3, normal: DVec3) -> f64 {
        let ([right, up], along) = (view.texel_at(position), view.ray_through(position).direction);
        let Moved { across, along: forward, always, least_world, felt: _ } = self.moved;
        let beside = across * (normal.dot(right).abs() + normal.dot(up).abs()) + always * right.length();
        let before = forward * f64::from(view.far - view.near) * normal.dot(along).abs();
        if self.paraboloid || view.projection() == Projection::Parallel {
            return (beside + before).max(least_world);
        }
        if self.snap_texels > 0.0 {
            // A depth map moves a point at most halfway to the light's height above the surface.
            let height = (view.ray_through(position).origin - position).dot(normal);
            return (beside + before).min(0.5 * height).max(least_world);
        }
        let z = view.axes(position).z;
        if z <= 0.0 {
            return 0.0;
        }
        // In perspective, the move itself changes the width of a texel and the slope of the ray; this corrects for both.
        let looks = normal.dot(DVec3::from(view.forward.map(f64::from)));
        let more = if looks > 0.0 { beside / z * looks } else { -2.0 * before / z * looks };
        ((beside + before) / (1.0 - more.min(0.5))).max(least_world)
    }

    /// Returns the view whose texels apply around a position.
    pub fn view_about(&self, position: DVec3) -> View {
        if self.paraboloid { self.view.about(position) } else { self.view }
    }
}

/// How far a surface point is moved along its normal n, so that its surface stays behind it. The move is the sum of `across`, `along` and
/// `always`, but at least `least_world`. All fields are 0 if points are not moved.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Moved {
    /// Move in texels, to be multiplied by |right · n| + |up · n|.
    pub across: f64,
    /// Move as a fraction of the view's range, to be multiplied by |d · n|. Here d is the direction of the ray, scaled so that its forward
    /// component is 1. The surface then stays behind the moved point by this fraction of the range along the light's rays.
    pub along: f64,
    /// Move in texels, the same for any normal.
    pub always: f64,
    /// The smallest move, in world units.
    pub least_world: f64,
    /// How far along the light's rays a surface may affect the look-up of a moved point, as a fraction of the view's range.
    pub felt: f64,
}
