//! How finely a technique knows where opaque shadows begin and end.

use crate::scene::{Projection, View};
use glam::DVec3;

/// In a grid, how much farther than a voxel's reach a receiver is moved, voxels. Twin: RECEIVER_MARGIN in
/// glsl/technique/voxel_grid/visibility.glsl.
const GRID_MARGIN: f64 = 1e-3;

/// The resolution of one of a technique's maps, or of a grid in a map's place: the size of details that it cannot tell
/// apart.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Resolution {
    /// The view whose texels and range the other fields refer to.
    pub view: View,
    /// Whether the view's texels are those of a [paraboloid](View::paraboloid).
    pub paraboloid: bool,
    /// Whether the view is one of a light's six faces. A receiver that is moved out of its face is then looked up in the next face.
    pub faces: bool,
    /// How far across the light's rays a surface may affect a look-up, texels.
    pub reach_texels: f64,
    /// For techniques whose bias follows the slope of the point's surface: how far the centre of a compared texel may be from the point,
    /// texels across and down. 0 for other techniques.
    pub pushed_texels: f64,
    /// How much nearer to the light than a surface point its caster must be to shadow it, in widths of a texel.
    pub nearer_texels: f64,
    /// For maps whose depths are compared with the plane of a surface: how far from a texel's centre the place may be at which its depth
    /// was taken, texels. 0 for other techniques.
    pub snap_texels: f64,
    /// How far along its normal a surface point is moved before its look-up.
    pub moved: Moved,
    /// Whether the technique may answer anything inside closed meshes. Points within the resolution of such an inside then belong to the
    /// boundary too.
    pub free_inside: bool,
    /// How far along the rays a surface may affect a look-up, as a share of the view's range.
    pub depth: f64,
    /// Where rays go through a grid along the world's axes, the side of a voxel, world units; else 0. In a grid, a surface anywhere in a
    /// ray's voxels may affect the look-up, and the fields that are in texels are not used.
    pub voxel: f64,
    /// Whether rays are tested against triangles instead of voxels. Then `voxel` is the distance by which rounding may move a ray. A
    /// surface within that distance may be hit wrongly, and may also be missed.
    pub rounded: bool,
    /// How far a surface point is moved along its ray in such a grid, after it was moved off the surface, voxels.
    pub bias: f64,
}

impl Resolution {
    /// The resolution of a grid with voxels, or cells of voxels, of side `voxel`; receivers are moved by `bias` along their rays.
    pub fn of_grid(view: View, voxel: f64, bias: f64) -> Self {
        Self { voxel, bias, ..Self::exact(view) }
    }

    /// The resolution of rays against triangles, where rounding may move either by `rounding`.
    pub fn of_triangles(view: View, rounding: f64) -> Self {
        Self { voxel: rounding, rounded: true, ..Self::exact(view) }
    }

    /// The resolution of a paraboloid map with view `view`. A look-up reads four texels, each up to a texel away from the place and
    /// covering half a texel about its middle. The depth in each texel is compared with the distance of the surface's plane on the ray
    /// through the texel's middle, but with no more than the point's own distance. So a caster is missed if it is in front of the point by
    /// less than the plane's depth changes over a texel, or by less than half a texel. Twins: NEARER_TEXELS, surface_distance in
    /// glsl/technique/ism/visibility.glsl.
    pub fn of_paraboloid(view: View) -> Self {
        let (reach_texels, pushed_texels, nearer_texels) = (1.5, 1.0, 0.5);
        Self { paraboloid: true, reach_texels, pushed_texels, nearer_texels, ..Self::exact(view) }
    }

    /// The resolution of exact techniques, which have no boundary.
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

    /// The place at which a surface point with normal `normal` is looked up, world units. In a grid, a look-up moves that place further
    /// along the ray. A grid moves a virtual light off its surface in the same way.
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
            // A depth map moves a point at most half way to the light's height over the surface.
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

    /// The view that gives texels about a place.
    pub fn view_about(&self, position: DVec3) -> View {
        if self.paraboloid { self.view.about(position) } else { self.view }
    }
}

/// How far a surface point is moved along its normal n, so that its surface stays behind it. The move is the sum of `across`, `along` and
/// `always`, but at least `least_world`. All fields are 0 where points are not moved.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Moved {
    /// Texels, times |right · n| + |up · n|.
    pub across: f64,
    /// A share of the view's range, times |d · n|. Here d is the direction of the ray, scaled so that its part along forward has length 1.
    /// The surface then stays behind the moved point by this share of the range along the light's rays.
    pub along: f64,
    /// Texels, for any normal.
    pub always: f64,
    /// The least move, world units.
    pub least_world: f64,
    /// How far along the light's rays a surface may affect the look-up of a moved point, as a share of the view's range.
    pub felt: f64,
}
