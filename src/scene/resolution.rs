//! How finely a technique knows where opaque shadows begin and end.

use super::View;

/// Of one of a technique's maps, or of what stands for a map: the size of what it cannot tell apart.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Resolution {
    /// Whose texels count, and whose range.
    pub view: View,
    /// How far across the light's rays, in texels of the view, a look-up may feel a surface.
    pub reach_texels: f64,
    /// How far a compared texel's centre may be from a point, texels across and down, where depths of surfaces are pushed back by
    /// what they change over that; 0 where they are not.
    pub pushed_texels: f64,
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
        let moved = Moved::default();
        Self { view, voxel, reach_texels: 0.0, pushed_texels: 0.0, moved, free_inside: false, depth: 0.0 }
    }
}

/// How far along its normal a point of a surface is moved, so that the surface stays behind it: three numbers of texels, of which
/// one counts as much as the normal looks along the view's right and up, the next as much as it looks forward, the last in full.
/// All are 0 where points stay where they are.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Moved {
    /// Times |right · n| + |up · n|.
    pub across: f64,
    /// Times |forward · n|: as far along the light's rays the surface then stays behind what is asked.
    pub along: f64,
    /// Whatever the normal.
    pub always: f64,
}
