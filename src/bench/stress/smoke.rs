//! Cases of smoke and hair: extinction, size, number of casters per ray, and position.

use super::StressCase;
use super::scene_builders::{SLANTED, USUAL, along, changed, cloud, corners, denser, random, scene, sphere};
use crate::scene::{Particle, Strand};
use glam::DVec3;

/// Cases of smoke and hair.
pub(super) const CASES: &[StressCase] = &[
    StressCase {
        name: "extinction",
        about: "smoke that becomes opaque",
        swept: "factor of all extinctions",
        values: &[1.0, 1e2, 1e4, 1e6, 1e9, 1e38],
        scene: |factor| scene(along(SLANTED), changed(cloud(USUAL), |_, p| denser(p, factor)), vec![]),
        ..StressCase::USUAL
    },
    StressCase {
        name: "extinction-low",
        about: "smoke that becomes nothing",
        swept: "factor of all extinctions",
        values: &[1.0, 1e-3, 1e-6, 1e-9, 1e-38, 0.0],
        scene: |factor| scene(along(SLANTED), changed(cloud(USUAL), |_, p| denser(p, factor)), vec![]),
        ..StressCase::USUAL
    },
    StressCase {
        name: "extinction-mixed",
        about: "every other sphere opaque, the others of extinction 0",
        swept: "extinction of the former, 1 / unit",
        values: &[1.0, 1e3, 1e6, 1e12, 1e38],
        scene: |extinction| {
            let alternating = |i: usize, p: &Particle| Particle {
                extinction: if i.is_multiple_of(2) { extinction as f32 } else { 0.0 },
                ..*p
            };
            scene(along(SLANTED), changed(cloud(USUAL), alternating), vec![])
        },
        ..StressCase::USUAL
    },
    StressCase {
        name: "origin",
        about: "the same smoke, far from the origin",
        swept: "its distance, units",
        values: &[0.0, 1e2, 1e3, 1e4, 1e5, 1e6],
        scene: |distance| {
            let offset = distance * DVec3::new(0.8, -0.5, 0.33);
            let moved = |_: usize, p: &Particle| {
                let position = (DVec3::from(p.position.map(f64::from)) + offset).as_vec3().into();
                Particle { position, ..*p }
            };
            let mut scene = scene(along(SLANTED), changed(cloud(USUAL), moved), vec![]);
            (scene.camera.position, scene.camera.target) = (scene.camera.position + offset, offset);
            scene
        },
        ..StressCase::USUAL
    },
    StressCase {
        name: "radius-small",
        about: "spheres on one ray of length 2, so small that their ends are hardly two depths",
        swept: "radius, units",
        values: &[1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6],
        scene: |radius| {
            let mut random = random(2);
            let one = |_| {
                let beside = radius * 0.3 * random.in_ball();
                sphere(beside + random.between(-1.0, 1.0) * DVec3::Z, radius, 0.15 / radius)
            };
            scene(along(DVec3::NEG_Z), (0..12).map(one).collect(), vec![])
        },
        ..StressCase::USUAL
    },
    StressCase {
        name: "fragments",
        about: "small thin spheres on one texel's ray",
        swept: "how many",
        values: &[1.0, 1e2, 1e3, 1e4, 1e5],
        most_on_cpu: 1e4,
        scene: |count| {
            let mut random = random(3);
            let one = |_| {
                let at = DVec3::new(0.03125, 0.03125, random.between(-0.9, 0.9)) + 0.004 * random.in_ball();
                sphere(at, 0.02, 1.0 / (0.04 * count))
            };
            scene(along(DVec3::NEG_Z), corners().into_iter().chain((0..count as usize).map(one)).collect(), vec![])
        },
        ..StressCase::USUAL
    },
    StressCase {
        name: "one-place",
        about: "equal spheres in one place: equal depths on every ray",
        swept: "how many",
        values: &[2.0, 16.0, 128.0, 1024.0, 8192.0, 20000.0],
        most_on_cpu: 8192.0,
        scene: |count| scene(along(SLANTED), vec![sphere(DVec3::ZERO, 1.0, 1.0 / count); count as usize], vec![]),
        ..StressCase::USUAL
    },
    StressCase {
        name: "equal-depth",
        about: "spheres of unlike extinction that lie in a plane across the light and overlap",
        swept: "how many",
        values: &[2.0, 16.0, 128.0, 512.0],
        scene: |count| {
            let mut random = random(4);
            let one = |_| {
                let at = random.in_ball() * DVec3::new(0.6, 0.6, 0.0);
                sphere(at, 0.4, random.between(0.1, 8.0) / count)
            };
            scene(along(DVec3::NEG_Z), (0..count as usize).map(one).collect(), vec![])
        },
        ..StressCase::USUAL
    },
    StressCase {
        name: "nested",
        about: "concentric spheres, from the inside out",
        swept: "how many",
        values: &[2.0, 8.0, 32.0, 128.0, 512.0],
        scene: |count| {
            let one = |i: usize| sphere(DVec3::ZERO, (i + 1) as f64 / count, 1.0 / count);
            scene(along(SLANTED), (0..count as usize).map(one).collect(), vec![])
        },
        ..StressCase::USUAL
    },
    StressCase {
        name: "touching",
        about: "a row of equal spheres along the light, the next where the last ends",
        swept: "the gap between two, radii",
        values: &[1e-1, 1e-3, 1e-5, 1e-7, 0.0, -1e-7],
        scene: |gap| {
            let one = |i: usize| sphere((i as f64 - 3.5) * 0.25 * (1.0 + 0.5 * gap) * DVec3::Z, 0.125, 2.0);
            scene(along(DVec3::NEG_Z), (0..8).map(one).collect(), vec![])
        },
        ..StressCase::USUAL
    },
    StressCase {
        name: "rim",
        about: "a dense sphere whose rim is at the rays of texel centres",
        swept: "radius past the ray, of the radius",
        values: &[1e-1, 1e-2, 1e-4, 1e-5, 1e-6, 1e-7, 0.0],
        scene: |past| {
            // The centre of texel 24 of 32, in a view from −1 to 1 that is widened by the margin of fitting.
            let ray = (24.5 / 16.0 - 1.0) * 1.00001;
            let particles = corners().into_iter().chain([sphere(DVec3::ZERO, ray * (1.0 + past), 50.0)]);
            scene(along(DVec3::NEG_Z), particles.collect(), vec![])
        },
        ..StressCase::USUAL
    },
    StressCase {
        name: "strands",
        about: "hair among smoke: steps, segments of no length",
        swept: "what each hair lets pass",
        values: &[0.9, 0.5, 1e-2, 1e-4, 1e-7, 0.0],
        scene: |passes| {
            let mut random = random(5);
            let mut scene = scene(along(SLANTED), cloud(12), vec![]);
            let strand = |_| {
                let start = random.in_ball();
                let [start, end] = [start, start + 0.8 * random.in_ball()].map(|p| p.as_vec3().into());
                Strand { start, radius: 0.05, end, opacity: (1.0 - passes) as f32 }
            };
            scene.strands = (0..40).map(strand).collect();
            scene
        },
        ..StressCase::USUAL
    },
    StressCase {
        name: "motion",
        about: "spheres smaller than a texel of 1/16 that move by less",
        swept: "radius, texels",
        values: &[4.0, 2.0, 1.0, 0.5, 0.1],
        scene: |texels| {
            let (mut random, radius) = (random(6), texels / 16.0);
            let one = |_| sphere(0.9 * random.in_ball(), radius, 0.5 / radius);
            scene(along(SLANTED), corners().into_iter().chain((0..200).map(one)).collect(), vec![])
        },
        ..StressCase::USUAL
    },
    StressCase {
        name: "many",
        about: "thin smoke of many spheres",
        swept: "how many",
        values: &[1e3, 1e4, 1e5, 1e6],
        most_on_cpu: 1e5,
        scene: |count| {
            let (mut random, radius) = (random(7), 0.6 / count.cbrt());
            let one = |_| sphere(random.in_ball(), radius, 0.4 / count.cbrt() / radius);
            scene(along(SLANTED), (0..count as usize).map(one).collect(), vec![])
        },
        ..StressCase::USUAL
    },
    StressCase {
        name: "opaque-tile",
        about: "opaque spheres in one tile of 8 × 8 texels",
        swept: "how many",
        values: &[1e2, 1e3, 1e4, 5e5],
        most_on_cpu: 1e4,
        scene: |count| {
            let mut random = random(8);
            let one = |_| {
                let at = DVec3::new(0.25, 0.25, 0.0) + random.in_ball() * DVec3::new(0.2, 0.2, 0.8);
                sphere(at, 0.03, 1e6)
            };
            scene(along(DVec3::NEG_Z), corners().into_iter().chain((0..count as usize).map(one)).collect(), vec![])
        },
        ..StressCase::USUAL
    },
];
