//! How finely a technique knows where opaque shadows begin and end.

use super::View;

/// Of one of a technique's maps, or of what stands for a map: the size of what it cannot tell apart.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Resolution {
    /// Whose texels count, and whose range.
    pub view: View,
    /// How far across the light's rays, in texels of the view, a look-up may feel a surface.
    pub reach_texels: f64,
    /// How far along its normal, in texels of the view, a point of a surface is moved before it is looked up, at most.
    pub normal_texels: f64,
    /// Whether it may answer anything inside closed things: what is nearer to their inside than it resolves is boundary too.
    pub free_inside: bool,
    /// How far along the rays, as a share of the view's range.
    pub depth: f64,
}
