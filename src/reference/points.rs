//! Where the techniques are measured, and the truth there.

use super::{Casters, TrueCurve};
use crate::scene::{Scene, View};
use glam::{DVec2, DVec3};
use rayon::prelude::*;

/// Depths a covered texel is measured at: evenly through the light's range, both ends included.
pub const MAP_DEPTHS: u32 = 64;

/// The truth at the map points of one light view.
pub struct MapTruth {
    /// Texels that some caster covers, as index y · width + x, rising.
    pub texels: Vec<u32>,
    /// World positions, [`MAP_DEPTHS`] a texel, depth rising.
    pub points: Vec<[f32; 3]>,
    /// How much of the light reaches each.
    pub visibility: Vec<f64>,
    /// Particle segments in all, over all texels.
    pub segments: u64,
}

/// The truth at the centres of all covered texels of `view` × [`MAP_DEPTHS`] depths. Where a scene has no particles,
/// every texel counts as covered.
pub fn map_truth(casters: &Casters, view: &View, scene: &Scene) -> MapTruth {
    let depths = f64::from(MAP_DEPTHS - 1);
    let per_row: Vec<_> = (0..view.height)
        .into_par_iter()
        .map(|y| {
            let mut row = MapTruth { texels: vec![], points: vec![], visibility: vec![], segments: 0 };
            for x in 0..view.width {
                let ray = view.ray(DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5));
                let (curve, segments) = casters.true_curve(view, &ray);
                if segments == 0 && !scene.particles.is_empty() {
                    continue;
                }
                row.texels.push(y * view.width + x);
                row.segments += u64::from(segments);
                for k in 0..MAP_DEPTHS {
                    let depth = f64::from(k) / depths;
                    let position = ray.at(view.z(depth));
                    let unblocked = scene.meshes.is_empty() || casters.unblocked(position);
                    row.points.push(position.as_vec3().into());
                    row.visibility.push(if unblocked { curve.transmittance(depth) } else { 0.0 });
                }
            }
            row
        })
        .collect();
    let mut truth = MapTruth { texels: vec![], points: vec![], visibility: vec![], segments: 0 };
    for row in per_row {
        truth.texels.extend(row.texels);
        truth.points.extend(row.points);
        truth.visibility.extend(row.visibility);
        truth.segments += row.segments;
    }
    truth
}

/// The exact curve at a texel's centre.
pub(super) fn texel_curve(casters: &Casters, view: &View, texel: u32) -> TrueCurve {
    let (x, y) = (texel % view.width, texel / view.width);
    casters.true_curve(view, &view.ray(DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5))).0
}

/// The first `count` points of a low-discrepancy sequence in the bounds of the particles (of the meshes where there
/// are none) that the light shines on. The same for the same scene.
///
/// The sequence is Roberts' R3: multiples of the powers of the inverse of the real root of x⁴ = x + 1.
pub fn space_points(casters: &Casters, scene: &Scene, count: usize) -> Vec<[f32; 3]> {
    let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    let mut include = |p: [f32; 3], radius: f64| {
        let p = DVec3::from(p.map(f64::from));
        low = low.min(p - radius);
        high = high.max(p + radius);
    };
    if scene.particles.is_empty() {
        scene.meshes.iter().flat_map(|m| &m.positions).for_each(|p| include(*p, 0.0));
    } else {
        scene.particles.iter().for_each(|p| include(p.position, p.radius.into()));
    }
    if low.x > high.x {
        return Vec::new();
    }
    const ROOT: f64 = 1.220_744_084_605_759_5;
    let step = DVec3::new(1.0 / ROOT, 1.0 / (ROOT * ROOT), 1.0 / (ROOT * ROOT * ROOT));
    let mut points = Vec::with_capacity(count);
    // A light that shines on none of the bounds would never fill the list.
    for i in 0..count.saturating_mul(64) {
        if points.len() == count {
            break;
        }
        let share = (DVec3::splat(0.5) + step * (i as f64)).fract();
        let position = low + share * (high - low);
        if casters.lights(position) {
            points.push(position.as_vec3().into());
        }
    }
    points
}
