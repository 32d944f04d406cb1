//! `ray-query`: exact on closed, interpenetrating meshes, and refused by name if the device has no ray queries.

use crate::opaque::{counted, lights};
use crate::support::scenes;
use crate::support::{built, gpu_test, gpu_test_needing, spec};
use glam::DVec3;
use gobo::gpu::Requirement;
use gobo::scene::Mesh;
use gobo::technique::open;
use gobo::world::World;
use gobo::{Error, Need};

/// Returns a closed box, rotated by `degrees` about the vertical.
fn closed_box(at: [f32; 3], half: f32, degrees: f32) -> Mesh {
    let (sin, cos) = degrees.to_radians().sin_cos();
    let corner = |i: u32| {
        let [x, y, z] = [0, 1, 2].map(|bit| if i >> bit & 1 == 1 { half } else { -half });
        [at[0] + x * cos - y * sin, at[1] + x * sin + y * cos, at[2] + z]
    };
    let sides = [[0, 1, 3, 2], [4, 5, 7, 6], [0, 1, 5, 4], [2, 3, 7, 6], [0, 2, 6, 4], [1, 3, 7, 5]];
    let triangles = sides.into_iter().flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    Mesh {
        name: "box".into(),
        positions: (0..8).map(corner).collect(),
        triangles,
        albedo: [0.5; 3],
        solid: false,
        alpha: None,
    }
}

/// Returns a ball of flat triangles.
fn ball(at: [f32; 3], radius: f32) -> Mesh {
    const RINGS: u32 = 24;
    let angle = |i: u32| std::f32::consts::PI * i as f32 / RINGS as f32;
    let place = |i: u32| {
        let ((sin, cos), (y, x)) = (angle(i / (2 * RINGS)).sin_cos(), angle(i % (2 * RINGS)).sin_cos());
        [at[0] + radius * sin * x, at[1] + radius * sin * y, at[2] + radius * cos]
    };
    let quad = |i: u32| {
        let (ring, step) = (i / (2 * RINGS), i % (2 * RINGS));
        let at = |ring, step| ring * 2 * RINGS + step % (2 * RINGS);
        let [a, b, c, d] = [at(ring, step), at(ring, step + 1), at(ring + 1, step + 1), at(ring + 1, step)];
        [[a, b, c], [a, c, d]]
    };
    let positions = (0..(RINGS + 1) * 2 * RINGS).map(place).collect();
    Mesh {
        name: "ball".into(),
        positions,
        triangles: (0..RINGS * 2 * RINGS).flat_map(quad).collect(),
        albedo: [0.5; 3],
        solid: false,
        alpha: None,
    }
}

/// There is no boundary to hide in: every point in space and on any surface counts.
#[test]
fn closed_meshes_shadow_what_the_reference_says() {
    gpu_test_needing("closed_meshes_shadow_what_the_reference_says", &[Requirement::RayQuery], |context| {
        for mut scene in lights(&[80.0, 50.0, 20.0, 4.0], DVec3::ZERO) {
            scene.meshes = vec![
                scenes::level(0.0, 5.0, [0.0, 0.0]),
                closed_box([1.0, 1.0, 0.5], 0.7, 20.0),
                closed_box([1.6, 0.7, 0.2], 0.5, 50.0),
                ball([-1.0, 1.5, 1.5], 0.8),
            ];
            let counted = counted(context, &scene, built(context, &scene, "ray-query").as_ref());
            let kind = scene.lights[0].kind;
            println!("{kind:?}: {} lit, {} dark", counted.lit, counted.dark);
            assert_eq!((counted.leaks.len(), counted.false_shadows.len()), (0, 0), "{kind:?}: {counted:?}");
            assert!(counted.boundary == 0 && counted.lit > 3000 && counted.dark > 1000, "{kind:?}: {counted:?}");
        }
    });
}

#[test]
fn a_device_without_rays_refuses() {
    gpu_test("a_device_without_rays_refuses", |context| {
        let mut features = context.features().clone();
        features.ray_query = false;
        assert_eq!(features.lacks(Requirement::RayQuery), Some("rayQuery"));
        let mut scene = scenes::directional("plate", [0.0, 0.0, -1.0], Vec::new());
        scene.meshes.push(scenes::level(0.0, 1.0, [0.0, 0.0]));
        let world = World::new(context, &scene).expect("room for a plate");
        let opened = open(context, &world, &spec("ray-query")).map(|_| ());
        if context.features().ray_query {
            return opened.expect("it has rays");
        }
        let refused = opened.expect_err("it has no rays");
        assert!(matches!(&refused, Error::Refused(Need::Feature(Requirement::RayQuery))), "{refused}");
    });
}
