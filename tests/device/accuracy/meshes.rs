//! The opaque map: planes do not shadow themselves, and shadows fall where the reference says.

use crate::support::{ask, ask_on, built, gpu_test, scenes};
use glam::{DVec2, DVec3};
use gobo::reference::truth::{Casters, SurfacePoint, bounds, points_outside, surface_points};
use gobo::scene::{LightKind, Moved, Resolution, Scene, View};
use gobo::technique::Technique;
use rayon::prelude::*;

/// Half the side of the ground, at z = 0.
const HALF: f32 = 5.0;

/// Least transmittance of a fully lit point: the four texels' weights add up to 1 up to rounding.
const LIT: f32 = 1.0 - 1e-6;

/// Returns a ground plane under a light of this direction.
fn ground(direction: [f64; 3]) -> Scene {
    let mut scene = scenes::directional("ground", direction, Vec::new());
    scene.meshes.push(scenes::level(0.0, HALF, [0.0, 0.0]));
    scene
}

/// Returns the opaque map's view used for a point.
fn opaque_view(scene: &Scene, technique: &dyn Technique) -> impl Fn(&[f32; 3]) -> View + use<> {
    let (light, maps) = (scene.lights[0], technique.inspect().maps().to_vec());
    move |point| maps[light.map_at(*point)].opaque
}

/// Returns points of the ground, at least `margin` from its edge.
fn on_ground(count: usize, margin: f32) -> Vec<[f32; 3]> {
    let mut random = scenes::Random::new(9);
    let reach = HALF - margin;
    (0..count).map(|_| [random.between(-reach, reach), random.between(-reach, reach), 0.0]).collect()
}

/// Lights from overhead to grazing (3.4° above the plane): directional, spot and point. The point light's face edges cross the ground.
fn lights() -> Vec<Scene> {
    let slants = [[0.0, 0.0, -1.0], [0.5, 0.3, -0.81], [1.0, 0.4, -0.3], [1.0, 0.2, -0.06]];
    let mut all: Vec<_> = slants.into_iter().map(ground).collect();
    all.push(scenes::spot([1.0, 2.0, 6.0], 100.0, ground(slants[0])));
    all.push(scenes::spot([6.0, -3.0, 1.0], 90.0, ground(slants[0])));
    all.push(scenes::point([1.0, 2.0, 2.5], ground(slants[0])));
    all
}

#[test]
fn a_plane_does_not_shadow_itself() {
    gpu_test("a_plane_does_not_shadow_itself", |context| {
        for scene in lights() {
            let technique = built(context, &scene, "uncompressed:size=8");
            let view = opaque_view(&scene, technique.as_ref());
            let (light, resolutions) = (scene.lights[0], technique.inspect().resolution());
            let resolution = |point: &[f32; 3]| resolutions[light.map_at(*point)];
            let points = on_ground(5000, 0.05);
            let light = scene.lights[0].kind;
            for answer in ask_on(context, technique.as_ref(), 0, &points, &[[0.0, 0.0, 1.0]; 5000]) {
                assert!(answer >= LIT, "{light:?}: {answer}: a point of the plane is in its shadow");
            }
            // Points above the plane, with no plane in front of them anywhere in the bilinear footprint plus one subpixel step; and points
            // below the plane, which is nearer to the light over the same footprint by at least 1 % of the light's range.
            let apart = 1.0 + (-f64::from(context.features().sub_pixel_precision_bits)).exp2();
            let (mut above, mut below) = (Vec::new(), Vec::new());
            for point in &points {
                let view = view(point);
                let range = f64::from(view.far - view.near);
                let (texel, z) = view.project(DVec3::from(point.map(f64::from)));
                // Seen from straight above, the plane spans almost no depth range, so the point below it is offset by more than the float
                // error of a depth.
                let apart_z = range * resolution(point).depth.max(0.01);
                let (nearer, deeper) = (z - apart_z, z + apart_z);
                if texel.cmplt(DVec2::splat(2.0)).any() || texel.cmpgt(DVec2::splat(f64::from(view.width) - 2.0)).any()
                {
                    continue;
                }
                let corners = [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)].map(|(dx, dy)| {
                    let ray = view.ray(texel + apart * DVec2::new(dx, dy));
                    let hit = ray.at(-ray.origin.z / ray.direction.z);
                    (hit.x.abs().max(hit.y.abs()) < f64::from(HALF), view.project(hit).1)
                });
                if corners.iter().all(|(on_plane, z)| *on_plane && (0.0..deeper).contains(z)) {
                    below.push(view.ray(texel).at(deeper).as_vec3().to_array());
                }
                if corners.iter().all(|(on_plane, z)| *on_plane && *z > nearer) {
                    above.push(view.ray(texel).at(nearer).as_vec3().to_array());
                }
            }
            assert!(below.len() > 500 && above.len() > 500, "{light:?}: {} below, {} above", below.len(), above.len());
            for (answer, point) in ask(context, technique.as_ref(), 0, &above).into_iter().zip(&above) {
                assert!(answer >= LIT, "{light:?}: {answer}: {point:?}, above the plane, is in shadow");
            }
            for (answer, point) in ask(context, technique.as_ref(), 0, &below).into_iter().zip(&below) {
                assert_eq!(answer, 0.0, "{light:?}: {point:?}, under the plane, is lit");
            }
        }
    });
}

/// On the ground under a quad, points are lit or dark as the reference says, except in a band of two texels around the shadow's edge. The
/// rasterizer and the bilinear filter can displace the edge by up to one and a half texels.
#[test]
fn an_occluder_shadows_what_the_reference_says() {
    gpu_test("an_occluder_shadows_what_the_reference_says", |context| {
        for mut scene in lights() {
            scene.meshes.push(scenes::level(0.2, 0.8, [0.3, -0.2]));
            let casters = Casters::new(&scene);
            let technique = built(context, &scene, "uncompressed:size=8");
            let view = opaque_view(&scene, technique.as_ref());
            let points = on_ground(8000, 0.05);
            let answers = ask_on(context, technique.as_ref(), 0, &points, &[[0.0, 0.0, 1.0]; 8000]);
            let (mut lit, mut dark, mut seam) = (0, 0, 0);
            for (point, answer) in points.iter().zip(answers) {
                let at = DVec3::from(point.map(f64::from));
                let view = view(point);
                let (texel, _) = view.project(at);
                // The point's ray and rays two texels to each side: if their ground points disagree, the point is in the band around the
                // shadow's edge.
                let around = [(-2.0, -2.0), (2.0, -2.0), (-2.0, 2.0), (2.0, 2.0), (0.0, 0.0)].map(|(dx, dy)| {
                    let ray = view.ray(texel + DVec2::new(dx, dy));
                    casters.unblocked(0, ray.at(-ray.origin.z / ray.direction.z))
                });
                if around.iter().any(|a| *a != around[0]) {
                    seam += 1;
                    continue;
                }
                let expected = if around[0] { LIT..=1.0 } else { 0.0..=0.0 };
                assert!(expected.contains(&answer), "{:?} at {point:?}: {answer}", scene.lights[0].kind);
                if around[0] { lit += 1 } else { dark += 1 }
            }
            println!("{:?}: {lit} lit, {dark} dark, {seam} in the seam", scene.lights[0].kind);
            assert!(dark > 50 && lit > 1000 && seam < 400, "{lit} lit, {dark} dark, {seam} in the seam");
        }
    });
}

/// Particles and meshes multiply: behind both, no light; behind the particle alone, its transmittance.
#[test]
fn particles_and_meshes_multiply() {
    gpu_test("particles_and_meshes_multiply", |context| {
        let sphere = gobo::scene::Particle { position: [0.0, 0.0, 3.0], radius: 0.5, extinction: 1.0 };
        let mut scene = scenes::directional("both", [0.0, 0.0, -1.0], vec![sphere]);
        scene.meshes.push(scenes::level(0.0, HALF, [0.0, 0.0]));
        let behind = (-1.0f32).exp();
        for text in ["uncompressed:size=9", "avsm:size=9,nodes=8,path=two-pass"] {
            let points = [[0.0, 0.0, 4.0], [0.0, 0.0, 1.0], [0.0, 0.0, 0.0], [0.0, 0.0, -0.2], [3.0, 0.0, 0.0]];
            let answers = ask(context, built(context, &scene, text).as_ref(), 0, &points);
            for (answer, expected) in answers.into_iter().zip([1.0, behind, behind, 0.0, 1.0]) {
                assert!((answer - expected).abs() < 1e-4, "{text}: {answer}, not {expected}");
            }
        }
    });
}

/// A ball of triangles with `rings` rings, centred at `place`.
fn ball(place: [f32; 3], rings: u32) -> gobo::scene::Mesh {
    let round = 2 * rings;
    let at = |i: u32| {
        let (ring, along) = (f64::from(i / round), f64::from(i % round));
        let (polar, around) =
            (std::f64::consts::PI * ring / f64::from(rings), std::f64::consts::TAU * along / f64::from(round));
        let p = DVec3::new(polar.sin() * around.cos(), polar.sin() * around.sin(), polar.cos()).as_vec3();
        [p.x + place[0], p.y + place[1], p.z + place[2]]
    };
    let quad = |ring: u32, along: u32| {
        let (a, b) = (ring * round + along, ring * round + (along + 1) % round);
        [[a, a + round, b], [b, a + round, b + round]]
    };
    gobo::scene::Mesh {
        name: "ball".into(),
        positions: (0..(rings + 1) * round).map(at).collect(),
        triangles: (0..rings).flat_map(|ring| (0..round).flat_map(move |along| quad(ring, along))).collect(),
        albedo: [0.5; 3],
        solid: false,
        alpha: None,
    }
}

/// Points within the resolution of a finer map are also within the resolution of a coarser one. This holds for each point in space; on
/// surfaces, whose look-ups are offset, it holds for the number of such points. Tested for many triangles, near the origin and far from it,
/// under parallel and perspective rays, and for a scanned mesh if the data is available.
#[test]
fn within_never_grows_as_the_size_doubles() {
    let at = |place: [f32; 3], kind: fn(DVec3) -> LightKind| {
        let mut scene = scenes::directional("ball", [0.4, 0.35, -0.8], Vec::new());
        scene.meshes = vec![ball(place, 40)];
        scene.lights[0].kind = kind(DVec3::from(place.map(f64::from)));
        scene
    };
    let sun = |_| LightKind::Directional { direction: DVec3::new(0.4, 0.35, -0.8).normalize() };
    let spot = |place| LightKind::Spot {
        position: place - DVec3::new(1.6, 1.4, -3.2),
        direction: DVec3::new(0.4, 0.35, -0.8).normalize(),
        cone_degrees: 60.0,
    };
    let mut all =
        vec![at([0.0; 3], sun), at([0.0; 3], spot), at([3000.0, -2000.0, 500.0], sun), at([300.0, 0.0, 50.0], spot)];
    if let Some(folder) = crate::support::shared_data("within_never_grows_as_the_size_doubles") {
        all.push(Scene::load(&folder.join("bunny.ply").to_string_lossy(), 0.0).expect("a mesh"));
    }
    for scene in &all {
        let casters = Casters::new(scene);
        let points = points_outside(&casters, bounds(scene).expect("meshes"), 0, 3000);
        let camera = View::camera(&scene.camera, scene, [64, 64]);
        let surface = surface_points(&casters, scene, 0, &camera, 2000);
        let mut before: Option<(usize, Vec<bool>, usize)> = None;
        // The largest cube that `voxelized` bakes has a side of 65,536.
        for size in (9..=16).map(|level| 1u32 << level) {
            let view = View::opaques(scene, size)[0];
            let depth = 1.0 / f64::from(size);
            let texel = 2.0 / (f64::from(view.scale_x) * f64::from(size));
            let along = 0.5 * texel / f64::from(view.far - view.near);
            let moved = Moved { across: 0.5, along, always: 1.0 / 32.0, felt: along, ..Moved::default() };
            let off = Resolution { reach_texels: 0.5, depth, moved, ..Resolution::exact(view) };
            let map = Resolution { reach_texels: 1.0625, snap_texels: 0.0625, depth: 1e-5, ..Resolution::exact(view) };
            let near = |p: &[f32; 3]| casters.in_boundary(0, &map, DVec3::from(p.map(f64::from)));
            let now: Vec<bool> = points.par_iter().map(near).collect();
            let facing = |s: &SurfacePoint| s.facing(scene.lights[0].towards(s.position));
            let on = |s: &&SurfacePoint| casters.in_surface_boundary(0, &off, s.position, facing(s));
            let (within, on) = (now.iter().filter(|near| **near).count(), surface.par_iter().filter(on).count());
            println!(
                "{}, {size}: {within} of {} in space, {on} of {} on surfaces",
                scene.name,
                points.len(),
                surface.len()
            );
            if let Some((before, all, on_before)) = before {
                let new = now.iter().zip(&all).filter(|(now, before)| **now && !**before).count();
                assert_eq!(new, 0, "{}: at {size} are within that were not, of {before}", scene.name);
                assert!(
                    on <= on_before,
                    "{}: {on} points of surfaces at {size}, {on_before} at half of it",
                    scene.name
                );
            }
            before = Some((within, now, on));
        }
        let least = before.expect("some").0;
        assert!(least * 100 < points.len(), "{}: {least} are left", scene.name);
    }
}
