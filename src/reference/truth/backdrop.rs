//! The sky behind a picture made for viewing, and the fade of the ground into it, in f64. Twin: glsl/shading/backdrop.glsl.

use crate::scene::Backdrop;
use glam::DVec3;

/// Twins: SUN_WHOLE, SUN_NONE.
const SUN: [f64; 2] = [0.99965, 0.99985];

fn wide(v: [f32; 3]) -> DVec3 {
    DVec3::from(v.map(f64::from))
}

fn smoothstep([low, high]: [f64; 2], at: f64) -> f64 {
    let share = ((at - low) / (high - low)).clamp(0.0, 1.0);
    share * share * (3.0 - 2.0 * share)
}

/// Returns the sky's color in `direction` (of unit length), in linear RGB.
pub fn sky_color(backdrop: &Backdrop, direction: DVec3) -> DVec3 {
    let height = direction.dot(wide(backdrop.up));
    let below_zenith = 1.0 - height.max(0.0);
    let color =
        wide(backdrop.zenith).lerp(wide(backdrop.horizon), below_zenith.powi(3)) * (1.0 + 0.5 * height.min(0.0));
    let towards = direction.dot(wide(backdrop.sun)).max(0.0);
    let sun = 0.25 * towards.powi(32) + 4.0 * smoothstep(SUN, towards);
    color + wide(backdrop.sunlight) * smoothstep([-0.02, 0.02], height) * sun
}

/// Returns how far the ground at `position` has faded into the sky, from 0 to 1.
pub fn ground_faded(backdrop: &Backdrop, position: DVec3) -> f64 {
    let (offset, up) = (position - wide(backdrop.middle), wide(backdrop.up));
    let height = offset.dot(up);
    let fades = backdrop.fade[1] > 0.0 && height.abs() <= f64::from(backdrop.thick);
    if fades { smoothstep(backdrop.fade.map(f64::from), (offset - height * up).length()) } else { 0.0 }
}
