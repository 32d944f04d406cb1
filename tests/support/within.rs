//! Fractions of a scene's points that may be within a technique's resolution, determined by shadow rays alone, whatever resolution the
//! technique claims.

use super::scenes::Random;
use glam::DVec3;
use gobo::reference::truth::{Casters, Meshes, bounds, points_outside, surface_points};
use gobo::scene::{LightKind, Scene, View};

/// Number of offsets tried around each point.
const TRIES: usize = 96;

/// Returns the diagonal of the meshes' bounding box, in world units.
pub fn diagonal(scene: &Scene) -> f64 {
    bounds(scene).map_or(0.0, |[low, high]| (high - low).length())
}

/// Returns the fraction of points in space, and of points on surfaces, whose shadow ray changes its result if shifted by less than `reach`
/// (in world units, for space and for surfaces; on surfaces only outwards): the shifted ray is free where the original is blocked or the
/// reverse, or it starts inside a closed mesh. Each fraction is estimated from about `points` points.
pub fn shares_within(scene: &Scene, reach: [f64; 2], points: usize) -> [f64; 2] {
    let (casters, meshes) = (Casters::new(scene), Meshes::new(&scene.meshes));
    let camera = View::camera(&scene.camera, scene, [96, 64]);
    let mut random = Random::new(17);
    let mut offset = || {
        let mut any = std::iter::repeat_with(|| DVec3::from(random.point(-1.0, 1.0).map(f64::from)));
        any.find(|by| by.length() < 1.0).expect("half of them")
    };
    let (mut within, mut all) = ([0.0; 2], [0.0; 2]);
    // At most eight lights.
    for light in (0..scene.lights.len()).step_by(scene.lights.len().div_ceil(8)) {
        let count = points / scene.lights.len().min(8);
        let kind = scene.lights[light].kind;
        let is_free = |p: DVec3, by: DVec3| match kind {
            LightKind::Directional { direction } => meshes.free(p + by, -direction, f64::INFINITY),
            _ => meshes.free(p + by, scene.lights[light].position().expect("a place") - p, 1.0),
        };
        let space = points_outside(&casters, bounds(scene).expect("meshes"), light, count);
        let space = space.into_iter().map(|p| (DVec3::from(p.map(f64::from)), DVec3::ZERO));
        let surface = surface_points(&casters, scene, light, &camera, count);
        let towards = |p: DVec3| scene.lights[light].towards(p);
        let surface = surface.into_iter().map(|s| (s.position, s.facing(towards(s.position))));
        for (p, normal) in space.chain(surface) {
            let of = usize::from(normal != DVec3::ZERO);
            let mut beside = || {
                let by = reach[of] * offset();
                // Reflects the offset to the outside.
                by - normal * (2.0 * by.dot(normal)).min(0.0)
            };
            let free = is_free(p, DVec3::ZERO);
            all[of] += 1.0;
            // Inside closed meshes some techniques return arbitrary values.
            let other = |by: DVec3| is_free(p, by) != free || casters.inside(light, p + by);
            within[of] += f64::from(u8::from((0..TRIES).any(|_| other(beside()))));
        }
    }
    [within[0] / all[0], within[1] / all[1]]
}
