//! Orders that casters are drawn in. Ties are by index, so that the same scene is always drawn in the same order.

use super::{Caster, Scene, View};

/// Caster indices by falling z of their middles in `camera`; ties by index.
pub fn far_to_near(scene: &Scene, camera: &View) -> Vec<u32> {
    by_depth(scene, |caster| -camera.project(0.5 * (caster.start() + caster.end())).1)
}

/// Caster indices by rising depth of their nearest point in the light's view; ties by index. It is near the order of
/// entry depths in each texel, which a drawing order cannot match in all texels at once.
pub fn near_to_far(scene: &Scene, view: &View) -> Vec<u32> {
    by_depth(scene, |caster| {
        let [start, end] = [caster.start(), caster.end()].map(|p| view.project(p).1);
        if caster.is_strand() { start.min(end) } else { start - f64::from(caster.radius) }
    })
}

/// Caster indices by rising `depth`; ties by index.
fn by_depth(scene: &Scene, depth: impl Fn(&Caster) -> f64) -> Vec<u32> {
    let depths: Vec<f64> = scene.casters().iter().map(depth).collect();
    let mut order: Vec<u32> = (0..depths.len() as u32).collect();
    order.sort_by(|a, b| depths[*a as usize].total_cmp(&depths[*b as usize]).then(a.cmp(b)));
    order
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Camera, Light, LightKind, Particle, Strand};
    use glam::DVec3;

    /// A light that shines down -z and a camera that looks down -z, from z 10: what has a greater z is nearer to both.
    fn scene(particles: &[(f32, f32)], strands: &[(f32, f32)]) -> Scene {
        let particle = |&(z, radius): &(f32, f32)| Particle { position: [0.1, 0.2, z], radius, extinction: 1.0 };
        let strand = |&(start, end): &(f32, f32)| Strand {
            start: [0.0, 0.0, start],
            radius: 0.1,
            end: [1.0, 0.0, end],
            opacity: 0.5,
        };
        let kind = LightKind::Directional { direction: DVec3::NEG_Z };
        Scene {
            name: String::new(),
            particles: particles.iter().map(particle).collect(),
            strands: strands.iter().map(strand).collect(),
            meshes: vec![],
            lights: vec![Light { kind, radiance: [1.0; 3] }],
            camera: Camera { position: 10.0 * DVec3::Z, target: DVec3::ZERO, up: DVec3::Y, fov_y_degrees: 40.0 },
        }
    }

    fn orders(scene: &Scene) -> [Vec<u32>; 2] {
        let camera = View::camera(&scene.camera, scene, [16, 16]);
        [far_to_near(scene, &camera), near_to_far(scene, &View::volumes(scene, 16)[0])]
    }

    #[test]
    fn the_ends_that_count() {
        // By middles: 0, -1, -2, 1.5; by nearest points: 0.25, 2, -1.5, 3.
        let scene = scene(&[(0.0, 0.25), (-1.0, 3.0), (-2.0, 0.5)], &[(3.0, 0.0)]);
        assert_eq!(orders(&scene), [vec![2, 1, 0, 3], vec![3, 1, 0, 2]]);
    }

    /// A strand counts by its nearer end, whichever that is.
    #[test]
    fn a_strand_either_way() {
        let scene = scene(&[(1.0, 0.25)], &[(3.0, -3.0), (-4.0, 2.0)]);
        assert_eq!(orders(&scene), [vec![2, 1, 0], vec![1, 2, 0]]);
    }

    #[test]
    fn ties_are_by_index_in_both() {
        let scene = scene(&[(1.0, 0.5), (2.0, 0.5), (1.0, 0.5), (2.0, 0.5), (1.0, 0.5)], &[]);
        assert_eq!(orders(&scene), [vec![0, 2, 4, 1, 3], vec![1, 3, 0, 2, 4]]);
    }

    #[test]
    fn no_casters_no_order() {
        assert!(orders(&scene(&[], &[])).iter().all(Vec::is_empty));
    }
}
