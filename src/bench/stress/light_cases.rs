//! Cases that sweep the light's position and direction, and casters close to the light.

use super::StressCase;
use super::meshes::plate;
use super::scene_builders::{SLANTED, USUAL, along, cloud, random, scene, sphere, spot};
use crate::scene::LightKind;
use glam::DVec3;

/// The directions of the axes.
const AXES: [DVec3; 6] = [DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Y, DVec3::Z, DVec3::NEG_Z];

/// Cases of lights, and of casters close to them.
pub(super) const CASES: &[StressCase] = &[
    StressCase {
        name: "depth-range",
        about: "smoke before a spot light, near and far, as large as it looks alike",
        swept: "farthest over nearest",
        values: &[1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7],
        scene: |ratio| {
            let mut random = random(20);
            let one = |i: usize| {
                let away = ratio.powf(f64::from(i as u32) / 31.0);
                let beside = 0.2 * away * random.in_ball();
                sphere(beside * DVec3::new(1.0, 1.0, 0.0) - away * DVec3::Z, 0.1 * away, 1.0 / away)
            };
            let kind = LightKind::Spot { position: DVec3::ZERO, direction: DVec3::NEG_Z, cone_degrees: 40.0 };
            scene(kind, (0..32).map(one).collect(), vec![])
        },
        ..StressCase::USUAL
    },
    StressCase {
        name: "large-caster",
        about: "smoke, and a sphere about all of it and the light",
        swept: "the sphere's radius, units",
        values: &[0.5, 5.0, 50.0, 1e3, 1e6],
        scene: |radius| {
            let mut particles = cloud(USUAL);
            particles.push(sphere(DVec3::ZERO, radius, 0.2));
            scene(spot(DVec3::new(1.0, 1.0, 2.5), 50.0), particles, vec![])
        },
        ..StressCase::USUAL
    },
    StressCase {
        name: "around-light",
        about: "a spot light in the midst of smoke: spheres around it, behind it and on its near plane",
        swept: "the light's distance from the middle, units",
        values: &[3.0, 1.0, 0.5, 0.1, 1e-3, 1e-6],
        scene: |distance| scene(spot(distance * DVec3::new(0.5, 0.3, 0.81), 60.0), cloud(USUAL), vec![]),
        ..StressCase::USUAL
    },
    StressCase {
        name: "point-light",
        about: "a point light in the midst of smoke",
        swept: "the light's distance from the middle of the nearest sphere, units",
        values: &[1.0, 0.3, 1e-2, 1e-4, 1e-6],
        scene: |distance| {
            let mut particles = cloud(USUAL);
            particles.push(sphere(DVec3::ZERO, 0.1, 3.0));
            let position = distance * DVec3::new(0.5, 0.3, 0.81);
            scene(LightKind::Point { position }, particles, vec![])
        },
        ..StressCase::USUAL
    },
    StressCase {
        name: "axis",
        about: "light along an axis",
        swept: "which: +x, −x, +y, −y, +z, −z",
        values: &[0.0, 1.0, 2.0, 3.0, 4.0, 5.0],
        scene: |axis| scene(along(AXES[axis as usize % AXES.len()]), cloud(USUAL), vec![]),
        ..StressCase::USUAL
    },
    StressCase {
        name: "up",
        about: "light almost along the way that is up",
        swept: "tangent of the angle between",
        values: &[1.0, 0.15, 0.14, 1e-2, 1e-5, 1e-9],
        scene: |tangent| scene(along(DVec3::new(tangent, 0.3 * tangent, -1.0)), cloud(USUAL), vec![]),
        ..StressCase::USUAL
    },
    StressCase {
        name: "spot-wide",
        about: "a wide spot light; wider ones are refused",
        swept: "full opening angle, degrees",
        values: &[60.0, 120.0, 150.0, 170.0],
        scene: |degrees| scene(spot(DVec3::new(0.6, 0.4, 1.4), degrees), cloud(USUAL), vec![]),
        ..StressCase::USUAL
    },
    StressCase {
        name: "spot-narrow",
        about: "a narrow spot light",
        swept: "full opening angle, degrees",
        values: &[60.0, 10.0, 1.0, 1e-1, 1e-2, 1e-3],
        scene: |degrees| scene(spot(DVec3::new(0.6, 0.4, 2.4), degrees), cloud(USUAL), vec![]),
        ..StressCase::USUAL
    },
    StressCase {
        name: "texels",
        about: "the usual smoke in small maps, as small as each technique has them",
        swept: "texels per side",
        values: &[32.0, 8.0, 3.0, 2.0, 1.0],
        scene: |_| scene(along(SLANTED), cloud(USUAL), vec![]),
        texels: Some(|side| side as u32),
        ..StressCase::USUAL
    },
    StressCase {
        name: "few",
        about: "as good as no smoke, and none",
        swept: "how many spheres",
        values: &[2.0, 1.0, 0.0],
        scene: |count| scene(along(SLANTED), cloud(count as usize), vec![]),
        ..StressCase::USUAL
    },
    StressCase {
        name: "wall",
        about: "smoke, and one opaque wall behind it, in it and before it",
        swept: "how far the wall stands before the smoke's middle, units",
        values: &[-2.0, -0.5, 0.0, 0.5, 2.0, 1e3],
        scene: |before| scene(along(DVec3::new(0.01, 0.02, -1.0)), cloud(USUAL), vec![plate(before, 0.7)]),
        ..StressCase::USUAL
    },
];
