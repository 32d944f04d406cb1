//! Casters that a ray passes so closely that rounding decides whether it meets them.

use super::Twins;
use glam::DVec2;
use gobo::reference::twin::splat::AlongRay;
use gobo::scene::{Caster, Ray};

/// How close, world units, a ray may pass a strand's outline before rounding decides: positions here are of some units,
/// whose floats are 2e-7 apart, and a hit is some ten operations.
const OUTLINE_ROUNDING: f64 = 4e-6;

/// Whether the ray passes a splat where it ends, at three deviations, and still has 1.1 % of its optical depth; to so many deviations.
fn ends_at(ray: &Ray, splat: &Caster, within: f32) -> bool {
    let along = AlongRay::of((ray.origin.as_vec3(), ray.direction.as_vec3()), splat);
    (along.square.sqrt() - 3.0).abs() < within
}

/// Whether the ray passes the caster's outline too closely to tell on which side. A sphere's is within a share of its
/// radius; a strand's is its ribbon, two edges and two ends, seen along the ray.
fn grazes(ray: &Ray, caster: &Caster) -> bool {
    let offset = caster.start() - ray.origin;
    let radius = f64::from(caster.radius);
    let across = offset.reject_from(ray.direction);
    if caster.is_splat() {
        // Packing its axes again moves that.
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
    /// Casters that the texel's ray grazes so closely that rounding decides whether it meets them.
    pub fn grazed(&self, texel: u32) -> u64 {
        let corner = DVec2::new(f64::from(texel % self.view.width), f64::from(texel / self.view.width));
        if self.area {
            // What a texel's square has of a sphere or a strand grows with it from nothing. A splat ends in a step, for each ray by itself.
            let rays = (0..16).map(|i| DVec2::new(f64::from(i % 4), f64::from(i / 4)) / 4.0 + 0.125);
            let rays: Vec<_> = rays.map(|beside| self.view.ray(corner + beside)).collect();
            let grazed = |splat: &&Caster| rays.iter().any(|ray| ends_at(ray, splat, 1e-4));
            return self.casters.iter().filter(|caster| caster.is_splat()).filter(grazed).count() as u64;
        }
        let ray = self.view.ray(corner + 0.5);
        self.casters.iter().filter(|caster| grazes(&ray, caster)).count() as u64
    }

    /// The same of all texels.
    pub fn grazing(&self) -> u64 {
        (0..self.view.texels() as u32).map(|texel| self.grazed(texel)).sum()
    }
}
