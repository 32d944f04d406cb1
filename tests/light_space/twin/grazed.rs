//! Casters that a ray grazes so closely that rounding decides whether it hits them.

use super::Twins;
use glam::DVec2;
use gobo::reference::twin::splat::AlongRay;
use gobo::scene::{Caster, Ray};

/// Distance from a strand's outline, in world units, within which rounding decides: coordinates here are a few units, where floats are 2e-7
/// apart, and a hit test takes some ten operations.
const OUTLINE_ROUNDING: f64 = 4e-6;

/// Returns whether the ray passes within `within` deviations of a splat's cut-off at three deviations, where 1.1 % of its optical depth is
/// left.
fn ends_at(ray: &Ray, splat: &Caster, within: f32) -> bool {
    let along = AlongRay::of((ray.origin.as_vec3(), ray.direction.as_vec3()), splat);
    (along.square.sqrt() - 3.0).abs() < within
}

/// Returns whether the ray passes too close to the caster's outline to tell on which side. A sphere's tolerance is relative to its radius;
/// a strand's outline is that of its ribbon, two edges and two ends, seen along the ray.
fn grazes(ray: &Ray, caster: &Caster) -> bool {
    let offset = caster.start() - ray.origin;
    let radius = f64::from(caster.radius);
    let across = offset.reject_from(ray.direction);
    if caster.is_splat() {
        // Repacking a splat's axes moves its cut-off.
        return ends_at(ray, caster, 0.01);
    }
    if !caster.is_strand() {
        return (across.length() / radius - 1.0).abs() < 1e-5;
    }
    let axis = (caster.end() - caster.start()).reject_from(ray.direction);
    let length = axis.length();
    if length < 1e-4 * (caster.end() - caster.start()).length() {
        return length > 1e-6; // nearly edge on: a sliver
    }
    let along = -across.dot(axis) / length;
    let side = (across.reject_from(axis).length() - radius).abs();
    let before_edge = along > -OUTLINE_ROUNDING && along < length + OUTLINE_ROUNDING && side < OUTLINE_ROUNDING;
    let at_end = along.abs().min((along - length).abs()) < OUTLINE_ROUNDING;
    before_edge || (at_end && across.reject_from(axis).length() < radius + OUTLINE_ROUNDING)
}

impl Twins<'_> {
    /// Returns the number of casters that the texel's ray grazes so closely that rounding decides whether it hits them.
    pub fn grazed(&self, texel: u32) -> u64 {
        let corner = DVec2::new(f64::from(texel % self.view.width), f64::from(texel / self.view.width));
        if self.area {
            // A square's overlap with a sphere or a strand grows continuously from zero. A splat is cut off in a step, for each ray
            // separately.
            let rays = (0..16).map(|i| DVec2::new(f64::from(i % 4), f64::from(i / 4)) / 4.0 + 0.125);
            let rays: Vec<_> = rays.map(|beside| self.view.ray(corner + beside)).collect();
            let grazed = |splat: &&Caster| rays.iter().any(|ray| ends_at(ray, splat, 1e-4));
            return self.casters.iter().filter(|caster| caster.is_splat()).filter(grazed).count() as u64;
        }
        let ray = self.view.ray(corner + 0.5);
        self.casters.iter().filter(|caster| grazes(&ray, caster)).count() as u64
    }

    /// Returns the number of grazed casters, summed over all texels.
    pub fn grazing(&self) -> u64 {
        (0..self.view.texels() as u32).map(|texel| self.grazed(texel)).sum()
    }
}
