//! The order in which a picture is blended. Ties are broken by the casters' values, so that their order in the scene does not matter.

use super::sheet::sheets;
#[cfg(feature = "program")]
use crate::scene::Caster;
use crate::scene::{Scene, View, Volume};
use glam::DVec3;
use std::ops::Range;

/// The objects that a picture blends, from far to near by the z of their centres. A volume is blended as a whole by ray marching; its cells
/// only cast shadows.
#[cfg(feature = "program")]
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Order {
    /// Indices of casters, excluding volume cells.
    pub casters: Vec<u32>,
    /// Volumes: the number of `casters` blended before each, and its index.
    pub volumes: Vec<(u32, u32)>,
}

/// A run of casters or a volume, to be blended next.
#[derive(Clone, Debug, PartialEq)]
pub enum Blended {
    /// Casters, as a range of positions in the order.
    Casters(Range<u32>),
    /// A volume, by index.
    Volume(u32),
}

/// Splits `casters` casters into runs between the volumes listed by [`volumes_among`], from far to near.
pub fn blended(casters: u32, volumes: &[(u32, u32)]) -> impl Iterator<Item = Blended> {
    let mut first = 0;
    let ends = volumes.iter().map(|(before, volume)| (*before, Some(*volume)));
    ends.chain([(casters, None)])
        .flat_map(move |(before, volume)| {
            let casters = std::mem::replace(&mut first, before)..before;
            [Some(Blended::Casters(casters)), volume.map(Blended::Volume)]
        })
        .flatten()
        .filter(|next| !matches!(next, Blended::Casters(casters) if casters.is_empty()))
}

/// Returns the volumes of a scene from far to near, each with the number of casters blended before it: all casters that are as far from
/// `camera` or farther. The casters need not be sorted.
pub fn volumes_among(scene: &Scene, camera: &View) -> Vec<(u32, u32)> {
    let z = |middle: DVec3| camera.project(middle).1;
    let mut volumes: Vec<_> = scene.volumes.iter().map(|volume| z(middle(volume))).zip(0..).collect();
    volumes.sort_by(|(a, _), (b, _)| b.total_cmp(a));
    let place = |place: [f32; 3]| DVec3::from(place.map(f64::from));
    let casters = scene.particles.iter().map(|particle| place(particle.position));
    let casters = casters.chain(scene.strands.iter().map(|strand| 0.5 * (place(strand.start) + place(strand.end))));
    let casters = casters.chain(scene.splats.iter().map(|splat| place(splat.position)));
    let casters = casters.chain(sheets(&scene.meshes).map(|sheet| place(sheet.position)));
    let mut behind = vec![0; volumes.len() + 1];
    for caster in casters.map(z) {
        behind[volumes.partition_point(|(volume, _)| *volume > caster)] += 1;
    }
    let sums = behind.into_iter().scan(0, |sum, count| {
        *sum += count;
        Some(*sum)
    });
    sums.zip(volumes).map(|(before, (_, volume))| (before, volume)).collect()
}

/// The longest run of casters at the same z that is sorted by values; longer runs keep their index order.
#[cfg(feature = "program")]
const LONGEST_RUN: usize = 256;

/// Returns the order of casters and volumes for `camera`, by descending z of their centres. Ties are broken by values, and casters precede
/// volumes.
#[cfg(feature = "program")]
pub fn far_to_near(scene: &Scene, camera: &View) -> Order {
    let z = |caster: &Caster| camera.project(0.5 * (caster.start() + caster.end())).1;
    let count = scene.first_cell();
    let all = scene.casters();
    let depths: Vec<f64> = all[..count].iter().map(z).collect();
    let mut casters = falling(&depths);
    for run in casters.chunk_by_mut(|a, b| depths[*a as usize] == depths[*b as usize]) {
        if (2..=LONGEST_RUN).contains(&run.len()) {
            run.sort_by(|a, b| all[*a as usize].compare(&all[*b as usize]));
        }
    }
    let of_volumes: Vec<f64> = scene.volumes.iter().map(|volume| camera.project(middle(volume)).1).collect();
    let before = |volume: u32| {
        let z = of_volumes[volume as usize];
        (casters.partition_point(|caster| depths[*caster as usize] >= z) as u32, volume)
    };
    let volumes = falling(&of_volumes).into_iter().map(before).collect();
    Order { casters, volumes }
}

/// Sorts indices by descending depth in the order of [`f64::total_cmp`], ties by index. It must be fast, because the window's reference
/// sorts once every few rows: it is a radix sort by three digits of each number's upper half. Numbers with equal upper halves are then
/// sorted by the whole number.
#[cfg(feature = "program")]
fn falling(depths: &[f64]) -> Vec<u32> {
    const DIGIT: u32 = 11;
    let key = |depth: &f64| {
        let bits = depth.to_bits();
        !(if bits >> 63 == 1 { !bits } else { bits | 1 << 63 })
    };
    let mut order: Vec<(u64, u32)> = depths.iter().map(key).zip(0..).collect();
    let mut other = order.clone();
    for shift in [32, 32 + DIGIT, 32 + 2 * DIGIT] {
        let digit = |key: u64| (key >> shift) as usize & ((1 << DIGIT) - 1);
        let mut places = [0u32; 1 << DIGIT];
        order.iter().for_each(|(key, _)| places[digit(*key)] += 1);
        let mut before = 0;
        places.iter_mut().for_each(|place| before += std::mem::replace(place, before));
        for entry in &order {
            let place = &mut places[digit(entry.0)];
            other[*place as usize] = *entry;
            *place += 1;
        }
        std::mem::swap(&mut order, &mut other);
    }
    for alike in order.chunk_by_mut(|(a, _), (b, _)| a >> 32 == b >> 32).filter(|alike| alike.len() > 1) {
        alike.sort_by_key(|(key, _)| *key);
    }
    order.into_iter().map(|(_, index)| index).collect()
}

fn middle(volume: &Volume) -> DVec3 {
    let [low, high] = volume.field().range();
    let along = |axis: usize| volume.placed().steps[axis] * 0.5 * (f64::from(low[axis]) + f64::from(high[axis]));
    volume.placed().origin + along(0) + along(1) + along(2)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Camera, Field, Light, LightKind, Particle, Placed, Strand};
    use std::sync::Arc;

    /// Builds a scene with a light that shines along −z and a camera that looks along −z from z = 10: points of greater z are nearer to
    /// both.
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
            particles: particles.iter().map(particle).collect(),
            strands: strands.iter().map(strand).collect(),
            lights: vec![Light { kind, radiance: [1.0; 3], radius: f64::INFINITY }],
            camera: Camera { position: 10.0 * DVec3::Z, target: DVec3::ZERO, up: DVec3::Y, fov_y_degrees: 40.0 },
            ..Scene::default()
        }
    }

    fn all(scene: &Scene) -> Order {
        far_to_near(scene, &View::camera(&scene.camera, scene, [16, 16]))
    }

    fn order(scene: &Scene) -> Vec<u32> {
        all(scene).casters
    }

    /// Builds a volume of one sample at height `z`, with cells of side 1/16.
    fn volume(z: f64) -> Volume {
        let field = Arc::new(Field::new([([0; 3], 1.0)]).expect("a field"));
        let steps = [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| axis / 16.0);
        // The field's blocks extend from sample −8 to 8.
        let origin = DVec3::new(0.0, 0.0, z);
        Volume::new(field, Placed { origin, steps, extinction: 1.0, color: [1.0; 3], side: 1 }).expect("a volume")
    }

    /// The radix sort gives the same order as comparisons, for numbers of either sign, numbers that are partly or wholly equal, NaN and
    /// infinity.
    #[test]
    fn digits_sort_as_comparisons_do() {
        let mut random = 1u64;
        let mut next = || {
            random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            random
        };
        let mut depths: Vec<f64> = (0..3000).map(|_| f64::from_bits(next())).collect();
        depths.extend((0..3000).map(|_| f64::from((next() >> 60) as u32) - 8.0));
        depths.extend((0..3000).map(|_| 10.0 + f64::EPSILON * f64::from((next() >> 56) as u32)));
        depths.extend([0.0, -0.0, f64::NAN, -f64::NAN, f64::INFINITY, f64::NEG_INFINITY]);
        let mut order: Vec<u32> = (0..depths.len() as u32).collect();
        order.sort_by(|a, b| depths[*b as usize].total_cmp(&depths[*a as usize]).then(a.cmp(b)));
        assert_eq!(falling(&depths), order);
        assert!(falling(&[]).is_empty());
    }

    /// Each volume must be placed among the casters by its centre, after casters of the same z.
    #[test]
    fn volumes_are_among_casters() {
        let mut scene = scene(&[(1.0, 0.5), (2.0, 0.5), (0.0, 0.5)], &[]);
        scene.volumes = vec![volume(3.0), volume(-1.0), volume(1.0)];
        let order = all(&scene);
        assert_eq!((&order.casters[..], &order.volumes[..]), (&[2, 0, 1][..], &[(0, 1), (2, 2), (3, 0)][..]));
        let camera = View::camera(&scene.camera, &scene, [16, 16]);
        assert_eq!(volumes_among(&scene, &camera), order.volumes, "without the casters' order");
        let next: Vec<_> = blended(order.casters.len() as u32, &order.volumes).collect();
        use Blended::{Casters, Volume};
        assert_eq!(next, [Volume(1), Casters(0..2), Volume(2), Casters(2..3), Volume(0)]);
    }

    /// Casters are ordered by their centres, whose z are 0, −1, −2 and 1.5.
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
        assert_eq!(blended(0, &[]).count(), 0);
    }
}
