//! Where the techniques are measured, and the truth there.

use super::casters::Casters;
use super::true_curve::TrueCurve;
use crate::scene::{Scene, View};
use glam::{DVec2, DVec3};
use rayon::prelude::*;

/// Depths a covered texel is measured at: evenly through the light's range, both ends included.
pub const MAP_DEPTHS: u32 = 64;

/// The truth at the map points of one map.
pub struct MapTruth {
    /// The light whose map it is.
    pub light: usize,
    /// Which of all lights' maps.
    pub map: usize,
    /// Texels that some caster covers, as index y · width + x, rising.
    pub texels: Vec<u32>,
    /// World positions, [`MAP_DEPTHS`] a texel, depth rising.
    pub points: Vec<[f32; 3]>,
    /// How much of the light reaches each.
    pub visibility: Vec<f64>,
    /// Segments over all these texels.
    pub segments: u64,
}

/// The truth in every map of every light; `views` are those of all maps, the first light's first.
pub fn map_truths(casters: &Casters, scene: &Scene, views: &[View]) -> Vec<MapTruth> {
    let maps = |light: usize| (0..scene.lights[light].map_count()).map(move |face| (light, face));
    let all = (0..scene.lights.len()).flat_map(maps).zip(views).enumerate();
    all.map(|(map, ((light, face), view))| map_truth(casters, scene, light, face, map, view)).collect()
}

/// The truth at the centres of all covered texels of `view` × [`MAP_DEPTHS`] depths. Where a scene has only meshes,
/// every texel counts as covered. Left out are the texels of a point light's face that another face is asked for.
fn map_truth(casters: &Casters, scene: &Scene, light: usize, face: usize, map: usize, view: &View) -> MapTruth {
    let depths = f64::from(MAP_DEPTHS - 1);
    let none = || MapTruth { light, map, texels: vec![], points: vec![], visibility: vec![], segments: 0 };
    // At the light itself any face answers.
    let asked_for = |p: &[f32; 3]| *p == view.origin || scene.lights[light].map_at(*p) == face;
    let per_row: Vec<_> = (0..view.height)
        .into_par_iter()
        .map(|y| {
            let mut row = none();
            for x in 0..view.width {
                let ray = view.ray(DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5));
                let position = |k: u32| ray.at(view.z(f64::from(k) / depths));
                if !(0..MAP_DEPTHS).all(|k| asked_for(&position(k).as_vec3().into())) {
                    continue;
                }
                let (curve, segments) = casters.true_curve(map, view, &ray);
                if segments == 0 && !scene.has_only_meshes() {
                    continue;
                }
                row.texels.push(y * view.width + x);
                row.segments += u64::from(segments);
                for k in 0..MAP_DEPTHS {
                    let unblocked = scene.meshes.is_empty() || casters.unblocked(light, position(k));
                    row.points.push(position(k).as_vec3().into());
                    row.visibility.push(if unblocked { curve.transmittance(f64::from(k) / depths) } else { 0.0 });
                }
            }
            row
        })
        .collect();
    let mut truth = none();
    for row in per_row {
        truth.texels.extend(row.texels);
        truth.points.extend(row.points);
        truth.visibility.extend(row.visibility);
        truth.segments += row.segments;
    }
    truth
}

/// The exact curve at a texel's centre.
pub(super) fn texel_curve(casters: &Casters, map: usize, view: &View, texel: u32) -> TrueCurve {
    let (x, y) = (texel % view.width, texel / view.width);
    casters.true_curve(map, view, &view.ray(DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5))).0
}

/// The first `count` points of a low-discrepancy sequence in the bounds of the casters (of the meshes where there is
/// nothing else) that light `light` shines on. The same for the same scene.
///
/// The sequence is Roberts' R3: multiples of the powers of the inverse of the real root of x⁴ = x + 1.
pub fn space_points(scene: &Scene, light: usize, count: usize) -> Vec<[f32; 3]> {
    let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    let mut include = |p: [f32; 3], radius: f64| {
        let p = DVec3::from(p.map(f64::from));
        low = low.min(p - radius);
        high = high.max(p + radius);
    };
    if scene.has_only_meshes() {
        scene.meshes.iter().flat_map(|m| &m.positions).for_each(|p| include(*p, 0.0));
    } else {
        scene.particles.iter().for_each(|p| include(p.position, p.radius.into()));
        scene.strands.iter().for_each(|s| {
            include(s.start, s.radius.into());
            include(s.end, s.radius.into());
        });
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
        if scene.lights[light].shines_on(position) {
            points.push(position.as_vec3().into());
        }
    }
    points
}
