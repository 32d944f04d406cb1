//! Each pixel's surface: the triangle that rays in f64 find, its G-buffer values as the twin computes them, and the picture drawn without
//! triangle numbers.

use super::{build, camera, drawn, lamps, seen};
use crate::support::{gpu_test, some};
use glam::{DVec2, Vec3};
use gobo::reference::truth::Casters;
use gobo::reference::twin::gbuffer::gbuffer;
use gobo::scene::{Mesh, Scene, sides};
use gobo::shading::{Lighting, Shading};

/// Returns the corners, albedo and side of each triangle, in the world's order.
fn triangles(scene: &Scene) -> Vec<([Vec3; 3], Vec3, i32)> {
    let of = |mesh: &Mesh| -> Vec<_> {
        let corners = |t: &[u32; 3]| t.map(|index| Vec3::from(mesh.positions[index as usize]));
        let all = mesh.triangles.iter().map(corners).zip(sides(mesh));
        all.map(|(corners, side)| (corners, Vec3::from(mesh.albedo), side.sign())).collect()
    };
    scene.meshes.iter().flat_map(of).collect()
}

/// Houses among lamps, on a ground and in the sky. If the f64 ray and rays 0.07 pixels beside it meet one plane, the pixel's triangle is
/// the one they meet, up to float rounding at the scene's distances.
#[test]
fn pixels_see_what_rays_meet() {
    gpu_test("pixels_see_what_rays_meet", |context| {
        for (scene, size) in some([(lamps::kinds(), [96, 54]), (lamps::lamps(3), [33, 71])], 1) {
            let built = build(context, &scene, "none");
            let (_, seen) = seen(context, &built, size);
            let (casters, camera, triangles) = (Casters::new(&scene), camera(&scene, size), triangles(&scene));
            let (mut compared, mut sky) = (0, 0);
            for i in 0..seen.z.len() {
                let pixel = [i as u32 % size[0], i as u32 / size[0]];
                let hit = |offset: [f64; 2]| {
                    let at = DVec2::new(pixel[0].into(), pixel[1].into()) + 0.5 + DVec2::from(offset);
                    let ray = camera.ray(at);
                    casters.meshes.hit(ray.origin, ray.direction).map(|hit| (hit.normal, hit.distance))
                };
                // A rasterizer may move corners by a 16th of a pixel.
                let corners = [[-0.07, -0.07], [0.07, -0.07], [-0.07, 0.07], [0.07, 0.07]];
                let middle = hit([0.0; 2]);
                let same = corners.iter().all(|offset| match (middle, hit(*offset)) {
                    (None, None) => true,
                    (Some((a, near)), Some((b, far))) => {
                        a.dot(b).abs() > 1.0 - 1e-9 && (near - far).abs() < 0.05 * near
                    }
                    _ => false,
                });
                if !same {
                    continue;
                }
                let Some((normal, distance)) = middle else {
                    assert_eq!((seen.numbers[i], seen.albedo[i], seen.normal[i]), (0, [0.0; 4], [0.0; 4]), "pixel {i}");
                    assert_eq!(seen.z[i], camera.far, "pixel {i}");
                    sky += 1;
                    continue;
                };
                let number = seen.numbers[i];
                assert!(number > 0, "pixel {i} sees something");
                let (corners, albedo, side) = triangles[number as usize - 1];
                assert_eq!(seen.albedo[i], [albedo.x, albedo.y, albedo.z, 1.0], "pixel {i}");
                let twin = gbuffer(&camera, corners, side, pixel);
                // Error bound: a few roundings of numbers as large as the scene's extent, divided by the cosine between ray and normal.
                let far = f64::from(camera.far.max(20.0));
                let slope = camera.ray(DVec2::new(pixel[0].into(), pixel[1].into()) + 0.5).direction.dot(normal).abs();
                let allowed = 16.0 * far * f64::from(f32::EPSILON) / slope;
                let z = f64::from(seen.z[i]);
                assert!((z - f64::from(twin.z)).abs() <= allowed, "pixel {i}: {z}, not {}", twin.z);
                assert!((z - distance).abs() <= allowed, "pixel {i}: {z}, and the ray meets it at {distance}");
                let [x, y, n, _] = seen.normal[i];
                assert!(
                    (Vec3::new(x, y, n) - twin.normal).length() < 1e-6,
                    "pixel {i}: {:?}, not {:?}",
                    seen.normal[i],
                    twin.normal
                );
                assert!(Vec3::new(x, y, n).as_dvec3().dot(normal).abs() > 1.0 - 1e-6, "pixel {i}");
                compared += 1;
            }
            println!("{}: {compared} pixels, {sky} of sky", scene.name);
            assert!(compared * 2 > seen.z.len() && sky > 50, "{compared}, {sky}");
        }
    });
}

/// Deferred shading from triangle numbers and forward shading from the rasterizer's interpolants give the same picture.
#[test]
fn numbers_show_the_picture_that_is_drawn() {
    gpu_test("numbers_show_the_picture_that_is_drawn", |context| {
        for (scene, size) in some(lamps::all(), 2) {
            let built = build(context, &scene, "none");
            let [forward, deferred] =
                [Shading::Forward, Shading::Deferred].map(|s| drawn(context, &built, size, s, Lighting::Fragment));
            for (i, (a, b)) in forward.pixels.iter().zip(&deferred.pixels).enumerate() {
                super::assert_near(context, *a, *b, format!("{}, pixel {i}", scene.name));
            }
        }
    });
}
