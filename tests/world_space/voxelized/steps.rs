//! The picture of steps shows the twin's step counts.

use super::{Cube, PLAIN, Structure, as_baked, baked, cube, shapes, voxel};
use crate::support::gpu_test;
use glam::{DVec2, DVec3};
use gobo::reference::truth::{Casters, Hit};
use gobo::scene::{Camera, Ray, Scene, View};
use gobo::shading::Renderer;
use gobo::technique::Technique;
use gobo::world::World;

const SIZE: [u32; 2] = [80, 60];

/// Aims the camera at the origin from `from`.
fn seen(mut scene: Scene, from: DVec3) -> Scene {
    scene.camera = Camera { position: from, target: DVec3::ZERO, up: DVec3::Z, fov_y_degrees: 40.0 };
    scene
}

/// Returns what the ray of a pixel's centre hits, if the surface extends a quarter of a pixel around it, so that a rasterizer has no
/// choice.
fn steady(casters: &Casters, camera: &View, at: DVec2) -> Option<Option<(DVec3, DVec3)>> {
    let hit = |[x, y]: [f64; 2]| -> (Ray, Option<Hit>) {
        let ray = camera.ray(at + DVec2::new(x, y));
        (ray, casters.meshes.hit(ray.origin, ray.direction))
    };
    let plane = |(ray, hit): (Ray, Option<Hit>)| hit.map(|h| (h.normal, h.normal.dot(ray.at(h.distance))));
    let middle = plane(hit([0.0; 2]));
    let same = |offset| match (middle, plane(hit(offset))) {
        (None, None) => true,
        (Some((n, d)), Some((m, e))) => (n - m).length() < 1e-6 && (d - e).abs() < 1e-6,
        _ => false,
    };
    let about = [[-0.25, -0.25], [0.25, -0.25], [-0.25, 0.25], [0.25, 0.25]];
    let (ray, met) = hit([0.0; 2]);
    about.into_iter().all(same).then(|| met.map(|h| (ray.at(h.distance), h.normal)))
}

/// Returns the position of a surface point's look-up, in voxels of a cube: off the surface, outside closed meshes and on the light's side
/// of open ones. Twin: light_receiver in glsl/technique/voxelized/visibility.glsl, for one column.
fn receiver(cube: &Cube, (position, normal): (DVec3, DVec3), closed: bool) -> [f32; 3] {
    let axes = cube.axes.map(|axis| DVec3::from(axis.map(f64::from)));
    let voxels = axes[0].length();
    let normal = if closed || normal.dot(axes[2]) <= 0.0 { normal } else { -normal };
    let facing = axes.map(|axis| normal.dot(axis).abs() / voxels);
    let off = 0.5 * (facing[0] + facing[1] + facing[2]) + 1.0 / 32.0;
    voxel(cube, (position + normal * off / voxels).as_vec3().into())
}

/// Unless rounding may change the voxel, a pixel shows the twin's number of steps down to it, and 0 outside the cube; a pixel that hits
/// nothing has no count.
#[test]
fn steps_equal_their_twin() {
    gpu_test("steps_equal_their_twin", |context| {
        for (scene, closed, from) in
            [(shapes::houses(), true, DVec3::new(1.8, -1.2, 1.6)), (shapes::soup(), false, DVec3::new(-1.5, 1.9, 1.2))]
        {
            let scene = seen(scene, from);
            for structure in [Structure::Dag, Structure::Svo] {
                let settings = super::Settings { size: 256, structure, ..PLAIN };
                let opened = baked(context, &scene, settings);
                let (tree, twin) =
                    (opened.technique.trees().expect("read")[0], as_baked(&opened.technique, 0, settings));
                let camera = View::camera(&scene.camera, &scene, SIZE);
                let world = World::new(context, &scene).expect("room for the scene");
                let renderer = Renderer::new(context, &world, &camera).expect("a renderer");
                let counts = renderer.steps(&opened.technique.answer()).expect("counted");
                let casters = Casters::new(&scene);
                let (mut compared, mut of_count) = (0, [0; 16]);
                for (i, count) in counts.iter().enumerate() {
                    let at = DVec2::new((i as u32 % SIZE[0]) as f64, (i as u32 / SIZE[0]) as f64) + 0.5;
                    let Some(met) = steady(&casters, &camera, at) else { continue };
                    let Some(point) = met else {
                        assert_eq!(*count, None, "{}, pixel {at}", scene.name);
                        continue;
                    };
                    let place = receiver(&cube(&tree), point, closed);
                    if place.iter().any(|v| (v - v.round()).abs() < 2e-3) {
                        continue; // on a voxel face
                    }
                    let outside = place.iter().take(2).any(|v| !(0.0..256.0).contains(v)) || place[2] < 0.0;
                    let whole = place.map(|v| v.min(255.0) as u32);
                    // No look-up is done for surfaces facing away.
                    let away = closed && point.1.dot(DVec3::from(tree.forward.map(f64::from))) > 0.0;
                    let expected = if outside || away { 0 } else { twin.shadowed(whole).1 };
                    assert_eq!(*count, Some(expected), "{}, {structure:?}, pixel {at}", scene.name);
                    compared += 1;
                    of_count[expected as usize] += 1;
                }
                println!("{}, {structure:?}: {compared} pixels, by their steps {of_count:?}", scene.name);
                let different = of_count.iter().filter(|n| **n > 20).count();
                assert!(compared > 500 && different > 2, "{}: {compared} pixels, {of_count:?}", scene.name);
            }
        }
    });
}

/// A technique that does not count steps is refused.
#[test]
fn who_does_not_count_is_refused() {
    gpu_test("who_does_not_count_is_refused", |context| {
        let scene = shapes::houses();
        let technique = crate::support::built(context, &scene, "shadow-map:size=16");
        let world = World::new(context, &scene).expect("room for the scene");
        let camera = View::camera(&scene.camera, &scene, SIZE);
        let error = Renderer::new(context, &world, &camera).expect("a renderer").steps(&technique.answer());
        let error = error.expect_err("refused").to_string();
        for word in ["shadow-map", "does not count", "voxelized"] {
            assert!(error.contains(word), "{error}");
        }
    });
}
