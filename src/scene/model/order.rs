//! The order in which a picture is blended. Ties are by index, so that the same scene is always drawn the same.

use crate::scene::{Caster, Scene, View, Volume};
use glam::DVec3;
use std::ops::Range;

/// What a picture is blended of, from far to near by the z of middles. A volume is one thing, which is marched; its cells are for light.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Order {
    /// Indices of casters, but for cells of volumes.
    pub casters: Vec<u32>,
    /// Volumes: how many of `casters` are blended before each, and its number.
    pub volumes: Vec<(u32, u32)>,
}

/// What is blended next.
#[derive(Clone, Debug, PartialEq)]
pub enum Blended {
    /// Casters by their places in [`Order::casters`].
    Casters(Range<u32>),
    /// A volume by its number.
    Volume(u32),
}

impl Order {
    /// All of it, from far to near.
    pub fn blended(&self) -> impl Iterator<Item = Blended> {
        let mut first = 0;
        let ends = self.volumes.iter().map(|(before, volume)| (*before, Some(*volume)));
        ends.chain([(self.casters.len() as u32, None)])
            .flat_map(move |(before, volume)| {
                let casters = std::mem::replace(&mut first, before)..before;
                [Some(Blended::Casters(casters)), volume.map(Blended::Volume)]
            })
            .flatten()
            .filter(|next| !matches!(next, Blended::Casters(casters) if casters.is_empty()))
    }
}

/// What `camera` sees of `scene`, by falling z of middles; ties by index, and casters before volumes.
pub fn far_to_near(scene: &Scene, camera: &View) -> Order {
    let z = |caster: &Caster| camera.project(0.5 * (caster.start() + caster.end())).1;
    let count = scene.particles.len() + scene.strands.len() + scene.gaussians.len();
    let depths: Vec<f64> = scene.casters()[..count].iter().map(z).collect();
    let falling = |depths: &[f64]| {
        let mut order: Vec<u32> = (0..depths.len() as u32).collect();
        order.sort_by(|a, b| depths[*b as usize].total_cmp(&depths[*a as usize]).then(a.cmp(b)));
        order
    };
    let casters = falling(&depths);
    let of_volumes: Vec<f64> = scene.volumes.iter().map(|volume| camera.project(middle(volume)).1).collect();
    let before = |volume: u32| {
        let z = of_volumes[volume as usize];
        (casters.partition_point(|caster| depths[*caster as usize] >= z) as u32, volume)
    };
    let volumes = falling(&of_volumes).into_iter().map(before).collect();
    Order { casters, volumes }
}

fn middle(volume: &Volume) -> DVec3 {
    let [low, high] = volume.field().range();
    let along = |axis: usize| volume.placed().steps[axis] * 0.5 * (f64::from(low[axis]) + f64::from(high[axis]));
    volume.placed().origin + along(0) + along(1) + along(2)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Camera, Field, Light, LightKind, Motion, Particle, Placed, Strand};
    use std::sync::Arc;

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
            extinction_ratio: Scene::GREY,
            lights: vec![Light { kind, radiance: [1.0; 3], radius: f64::INFINITY }],
            camera: Camera { position: 10.0 * DVec3::Z, target: DVec3::ZERO, up: DVec3::Y, fov_y_degrees: 40.0 },
        }
    }

    fn all(scene: &Scene) -> Order {
        far_to_near(scene, &View::camera(&scene.camera, scene, [16, 16]))
    }

    fn order(scene: &Scene) -> Vec<u32> {
        all(scene).casters
    }

    /// A hat about z, in cells of a 16th.
    fn volume(z: f64) -> Volume {
        let field = Arc::new(Field::new([([0; 3], 1.0)]).expect("a field"));
        let steps = [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| axis / 16.0);
        // Blocks lie from sample −8 to 8.
        let origin = DVec3::new(0.0, 0.0, z);
        Volume::new(field, Placed { origin, steps, extinction: 1.0, color: [1.0; 3], side: 1 }).expect("a volume")
    }

    /// Each volume is among the casters by its middle, over those of the same z.
    #[test]
    fn volumes_are_among_casters() {
        let mut scene = scene(&[(1.0, 0.5), (2.0, 0.5), (0.0, 0.5)], &[]);
        scene.volumes = vec![volume(3.0), volume(-1.0), volume(1.0)];
        let order = all(&scene);
        assert_eq!((&order.casters[..], &order.volumes[..]), (&[2, 0, 1][..], &[(0, 1), (2, 2), (3, 0)][..]));
        let blended: Vec<_> = order.blended().collect();
        use Blended::{Casters, Volume};
        assert_eq!(blended, [Volume(1), Casters(0..2), Volume(2), Casters(2..3), Volume(0)]);
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
        assert_eq!(all(&scene(&[], &[])).blended().count(), 0);
    }
}
