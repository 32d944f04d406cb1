//! CPU twin of glsl/maps/bins/sums.glsl: integer sums of optical depth.

use crate::scene::Caster;

/// Optical depth at which all light counts as absorbed. Twin: DARK.
pub const DARK: f32 = 16.0;

const BOUND_UNITS: f32 = 256.0;

/// Returns an upper bound of the casters' optical depth on any ray, in units of 1/256, where each caster counts for at most `dark`.
/// Twins: caster_most, entry_bound.
pub fn bound(casters: &[Caster], dark: f32) -> u64 {
    let most = |c: &Caster| if c.is_strand() { c.density } else { 2.0 * c.radius * c.density };
    casters.iter().map(|c| (most(c).min(dark) * BOUND_UNITS) as u64 + 1).sum()
}

/// Returns the number of units per optical depth of 1 for which sums below [`bound`] fit into 32 bits. Twin: sum_scale.
pub fn scale(bound: u64) -> f32 {
    (22.min(38 - bound.max(1).ilog2() as i32) as f32).exp2()
}
