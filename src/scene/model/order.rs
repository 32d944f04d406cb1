//! The order that the picture draws casters in. Ties are by index, so that the same scene is always drawn the same.

use crate::scene::{Caster, Scene, View};

/// Caster indices by falling z of their middles in `camera`; ties by index.
pub fn far_to_near(scene: &Scene, camera: &View) -> Vec<u32> {
    let z = |caster: &Caster| camera.project(0.5 * (caster.start() + caster.end())).1;
    let depths: Vec<f64> = scene.casters().iter().map(z).collect();
    let mut order: Vec<u32> = (0..depths.len() as u32).collect();
    order.sort_by(|a, b| depths[*b as usize].total_cmp(&depths[*a as usize]).then(a.cmp(b)));
    order
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Camera, Light, LightKind, Motion, Particle, Strand};
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
            gaussians: vec![],
            volumes: vec![],
            meshes: vec![],
            motion: Motion::Still,
            lights: vec![Light { kind, radiance: [1.0; 3], radius: f64::INFINITY }],
            camera: Camera { position: 10.0 * DVec3::Z, target: DVec3::ZERO, up: DVec3::Y, fov_y_degrees: 40.0 },
        }
    }

    fn order(scene: &Scene) -> Vec<u32> {
        far_to_near(scene, &View::camera(&scene.camera, scene, [16, 16]))
    }

    /// By middles: 0, -1, -2, 1.5.
    #[test]
    fn middles_count() {
        assert_eq!(order(&scene(&[(0.0, 0.25), (-1.0, 3.0), (-2.0, 0.5)], &[(3.0, 0.0)])), [2, 1, 0, 3]);
    }

    #[test]
    fn a_strand_either_way() {
        assert_eq!(order(&scene(&[(1.0, 0.25)], &[(3.0, -3.0), (-4.0, 2.0)])), [2, 1, 0]);
    }

    #[test]
    fn ties_are_by_index() {
        let scene = scene(&[(1.0, 0.5), (2.0, 0.5), (1.0, 0.5), (2.0, 0.5), (1.0, 0.5)], &[]);
        assert_eq!(order(&scene), [0, 2, 4, 1, 3]);
    }

    #[test]
    fn no_casters_no_order() {
        assert!(order(&scene(&[], &[])).is_empty());
    }
}
