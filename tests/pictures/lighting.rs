//! `lighting=vertex` against `lighting=fragment`, against its CPU twin and against closed forms, for every technique.

use crate::support::{built, gpu_test, gpu_test_needing, runs, scenes, skipped, some, spec};
use glam::DVec3;
use gobo::bench::picture_error;
use gobo::gpu::{Context, Requirement};
use gobo::query::{PointBatch, Query};
use gobo::reference::truth::{Casters, picture};
use gobo::reference::twin::vertex_lit;
use gobo::scene::{Camera, Light, LightKind, Particle, Picture, SKY, Scene, Strand, View};
use gobo::shading::{Lighting, PainterKind, Renderer, Shading, ShadingSettings, VERTEX_SPACING};
use gobo::technique::{Name, REGISTRY};
use gobo::world::World;
use gobo::{Error, Need};

/// Returns a spec of every technique that shadows smoke and runs on the device; a short run has the first only.
fn techniques(test: &str, context: &Context) -> Vec<String> {
    let spec = |name| {
        let mut spec = spec(name);
        spec.set(Name::SIZE, "128");
        spec.set(Name::PATH, "two-pass");
        spec.short()
    };
    // Half-angle slicing paints casters itself, for a single light.
    let shadow_smoke = REGISTRY.iter().filter(|entry| entry.casts.particles && entry.name != "half-angle");
    some(shadow_smoke, 1).into_iter().map(|entry| spec(entry.name)).filter(|text| runs(test, context, text)).collect()
}

/// Returns the painters with which the device can light at vertices. With few buffers, compute passes are refused for some techniques.
fn painters(context: &Context) -> Vec<PainterKind> {
    let features = context.features();
    let tessellates = features.tessellation_shader.then_some(PainterKind::Raster);
    let computes = (features.max_per_stage_descriptor_storage_buffers >= 24).then_some(PainterKind::Compute);
    tessellates.into_iter().chain(computes).collect()
}

/// Runs a test with each painter.
fn by_each(name: &str, test: impl Fn(&Context, PainterKind)) {
    gpu_test(name, |context| {
        let painters = painters(context);
        if painters.is_empty() {
            skipped(name, "needs tessellation, or 24 storage buffers per stage");
        }
        painters.into_iter().for_each(|painter| test(context, painter));
    });
}

const FRAGMENT: Lighting = Lighting::Fragment;

fn vertex(spacing: f32) -> Lighting {
    Lighting::Vertex { spacing }
}

fn camera(scene: &Scene, size: [u32; 2]) -> View {
    View::camera(&scene.camera, scene, size)
}

/// Returns the pictures of `scene`, lit by the technique of a spec.
fn pictures<const N: usize>(
    (context, painter): (&Context, PainterKind),
    scene: &Scene,
    size: [u32; 2],
    text: &str,
    lightings: [Lighting; N],
) -> [Picture; N] {
    let world = World::new(context, scene).expect("room for the scene");
    let mut renderer = Renderer::new(context, &world, &camera(scene, size)).expect("a renderer");
    renderer.paint_by(Some(painter));
    let technique = built(context, scene, text);
    let drawn = lightings.map(|l| renderer.picture(&technique.answer(), Shading::Forward, l).expect("drawn"));
    assert!(drawn.iter().flat_map(|p| p.pixels.iter().flatten()).all(|c| c.is_finite()), "{text}: not a number");
    drawn
}

fn differences<'a>(a: &'a Picture, b: &'a Picture) -> impl Iterator<Item = f32> + 'a {
    a.pixels.iter().flatten().zip(b.pixels.iter().flatten()).map(|(a, b)| (a - b).abs())
}

fn largest(a: &Picture, b: &Picture) -> f32 {
    differences(a, b).fold(0.0, f32::max)
}

fn rms(a: &Picture, b: &Picture) -> f64 {
    let squares: f64 = differences(a, b).map(|d| f64::from(d).powi(2)).sum();
    (squares / (3 * a.pixels.len()) as f64).sqrt()
}

/// Views the scene from 5 units away along y.
fn from_the_front(scene: Scene, fov_y_degrees: f64) -> Scene {
    let position = DVec3::new(0.0, -5.0, 0.0);
    Scene { camera: Camera { position, target: DVec3::ZERO, up: DVec3::Z, fov_y_degrees }, ..scene }
}

/// Radius, extinction and z of a sphere outside the picture, 8 units to the left: all light passes through its upper half.
const OCCLUDER: (f32, f32, f32) = (4.0, 0.15, -2.8);

/// A sphere of radius 1 that fills the picture, lit from the left through the flank of a sphere outside it, so that light falls off
/// smoothly across the picture's height. The visible sphere is so thin, and the light so strong, that it does not shadow itself.
fn flank() -> Scene {
    let (radius, extinction, z) = OCCLUDER;
    let particles = vec![
        Particle { position: [0.0; 3], radius: 1.0, extinction: 5e-4 },
        Particle { position: [-8.0, 0.0, z], radius, extinction },
    ];
    let mut scene = from_the_front(scenes::directional("flank", [1.0, 0.0, 0.0], particles), 24.0);
    scene.lights[0].radiance = [1e3; 3];
    scene
}

/// As vertices get denser, the picture converges to per-pixel lighting: at least twice as close for half the distance. (Four times for
/// smooth light; less at the silhouette, where vertices lie outside.)
#[test]
fn finer_vertices_come_nearer() {
    if crate::support::is_costly("finer_vertices_come_nearer") {
        return;
    }
    by_each("finer_vertices_come_nearer", |context, painter| {
        // In a grid, light jumps or bends at each voxel, and a voxel covers ten pixels in a picture of this size; few samples give noise
        // from texel to texel. Steps of 8 bits would be as large as the last differences, so such texels use half floats.
        let is_smooth = |text: &String| {
            !["voxel-grid", "density-grid", "optical-depth-grid", "marched", "stochastic"]
                .iter()
                .any(|name| text.starts_with(name))
        };
        for text in techniques("finer_vertices_come_nearer", context).into_iter().filter(is_smooth) {
            let text = match text.split(':').next() {
                Some("psm") => format!("{text},storage=rgba16f"),
                Some("translucency-map") => format!("{text},storage=r16f"),
                _ => text,
            };
            let [pixels, drawn @ ..] = pictures(
                (context, painter),
                &flank(),
                [160, 160],
                &text,
                [FRAGMENT, vertex(40.0), vertex(20.0), vertex(10.0), vertex(5.0)],
            );
            let errors = drawn.map(|p| rms(&p, &pixels));
            println!("{text}: {errors:.5?}");
            assert!(errors.windows(2).all(|e| e[1] < e[0] / 2.0), "{text}: {errors:?}");
            assert!(errors[0] > 1e-3, "{text}: nothing to be seen: {errors:?}");
        }
    });
}

/// Behind the sphere's flank the light is exp(−σ · 2 √(R² − d²)) at distance d from the ray through its centre, which is almost linear
/// within one cell of a quad's vertex grid: interpolated light matches the closed form.
#[test]
fn light_has_its_closed_form() {
    by_each("light_has_its_closed_form", |context, painter| {
        let scene = flank();
        let size = [160, 160];
        let camera = camera(&scene, size);
        let [drawn] = pictures((context, painter), &scene, size, "uncompressed:size=512", [vertex(8.0)]);
        let (radius, extinction, z) = OCCLUDER;
        let (mut least, mut most, mut seen) = (f64::INFINITY, 0.0f64, 0);
        for (i, pixel) in drawn.pixels.iter().enumerate() {
            let at = glam::DVec2::new((i as u32 % size[0]) as f64 + 0.5, (i as u32 / size[0]) as f64 + 0.5);
            let ray = camera.ray(at);
            let square = ray.direction.length_squared();
            let middle = ray.at(-ray.origin.dot(ray.direction) / square);
            // Compares only pixels well inside the silhouette, so that all corners of the quad's grid cell are inside too.
            if middle.length() > 0.7 {
                continue;
            }
            let opacity = -(-5e-4 * 2.0 * (1.0 - middle.length_squared()).sqrt()).exp_m1();
            let across = middle.y.powi(2) + (middle.z - f64::from(z)).powi(2);
            let chord = 2.0 * (f64::from(radius).powi(2) - across).max(0.0).sqrt();
            let light = (-f64::from(extinction) * chord).exp();
            let expected = 0.92 * (0.10 + 1e3 * light) * opacity + f64::from(SKY[0]) * (1.0 - opacity);
            let relative = f64::from(pixel[0]) / expected - 1.0;
            assert!(relative.abs() < 0.01, "pixel {at}: {} and not {expected}", pixel[0]);
            (least, most, seen) = (least.min(light), most.max(light), seen + 1);
        }
        assert!(seen > 3000 && most > 1.3 * least, "{seen} pixels, light from {least} to {most}");
    });
}

/// The sphere of [`flank`] behind a lattice of strands instead of the other sphere: strands are much denser than vertices, and absorb more
/// light the higher they are.
fn shutters() -> Scene {
    let mut scene = flank();
    scene.particles.truncate(1);
    let strand = |i: i16| {
        let z = 0.05 * f32::from(i);
        let end = |y: f32| [-8.0, y, z];
        Strand { start: end(-3.0), end: end(3.0), radius: 0.012, opacity: 0.6 + 0.2 * z }
    };
    scene.strands = (-40..=40).map(strand).collect();
    scene
}

/// Each vertex's look-up covers its own width: light between vertices equals a query of squares at the vertices, as wide as their spacing,
/// and not a query of points.
#[test]
fn vertices_ask_by_their_width() {
    if crate::support::is_costly("vertices_ask_by_their_width") {
        return;
    }
    by_each("vertices_ask_by_their_width", |context, painter| {
        let (scene, size, spacing) = (shutters(), [160, 160], 20.0);
        let camera = camera(&scene, size);
        let caster = scene.casters()[0];
        let quad = vertex_lit::quad(&camera, &caster, f64::from(spacing)).expect("it is seen");
        let [low, high] = quad.corners;
        let (parts, row) = (quad.parts, quad.parts[0] + 1);
        let pixels = glam::DVec2::from(size.map(f64::from));
        let apart = 0.5 * (high - low) * pixels / glam::DVec2::from(parts.map(|n| n as f64));
        let axis = |v: [f32; 3]| DVec3::from(v.map(f64::from));
        let vertex = |i: usize| {
            let at = glam::DVec2::new((i % row) as f64, (i / row) as f64) / glam::DVec2::from(parts.map(|n| n as f64));
            let pixel = (0.5 * (low + at * (high - low)) + 0.5) * pixels;
            let asked = vertex_lit::asked(&camera, &caster, pixel, camera.far.into());
            let z = (asked - axis(camera.origin)).dot(axis(camera.forward));
            let pixel_side = 2.0 * z / (pixels.y * f64::from(camera.scale_y)).abs();
            (asked.as_vec3().to_array(), ((apart.x * apart.y).sqrt() * pixel_side) as f32)
        };
        let (points, sides): (Vec<_>, Vec<_>) = (0..row * (parts[1] + 1)).map(vertex).unzip();
        for name in some(["avsm", "layers", "moments", "beer-shadow-map", "translucency-map"], 2) {
            let text = format!("{name}:path=binned,size=256,levels=7");
            if !runs("vertices_ask_by_their_width", context, &text) {
                continue;
            }
            let [drawn] = pictures((context, painter), &scene, size, &text, [Lighting::Vertex { spacing }]);
            let technique = built(context, &scene, &text);
            let ask = |sides: &[f32]| {
                let asked = [PointBatch { light: 0, points: &points, normals: &[] }];
                Query::of_areas(context, &asked, sides).expect("room").ask(&technique.answer()).expect("answered")
            };
            // Bounds of a pixel's light, since the device may split a grid cell along either diagonal.
            let between = |all: &[f32], ndc: glam::DVec2| {
                let at = (ndc - low) / (high - low) * glam::DVec2::from(parts.map(|n| n as f64));
                let part = at.floor();
                let (first, glam::DVec2 { x, y }) = (part.y as usize * row + part.x as usize, at - part);
                let [a, b, c, d] = [0, 1, row, row + 1].map(|i| f64::from(all[first + i]));
                let falling = if x >= y { a + x * (b - a) + y * (d - b) } else { a + y * (c - a) + x * (d - c) };
                let below = x + y <= 1.0;
                let rising =
                    if below { a + x * (b - a) + y * (c - a) } else { d + (1.0 - x) * (c - d) + (1.0 - y) * (b - d) };
                [falling.min(rising), falling.max(rising)]
            };
            let outside = |answers: &[f32]| {
                let (mut outside, mut seen, mut range) = (0, 0, [f64::INFINITY, 0.0f64]);
                for (i, pixel) in drawn.pixels.iter().enumerate() {
                    let at = glam::DVec2::new((i as u32 % size[0]).into(), (i as u32 / size[0]).into()) + 0.5;
                    let ray = camera.ray(at);
                    let middle = ray.at(-ray.origin.dot(ray.direction) / ray.direction.length_squared());
                    if middle.length() > 0.95 {
                        continue;
                    }
                    let opacity = -(-5e-4 * 2.0 * (1.0 - middle.length_squared()).sqrt()).exp_m1();
                    let shown =
                        |light: f64| 0.92 * (0.10 + 1e3 * light) * opacity + f64::from(SKY[0]) * (1.0 - opacity);
                    let [least, most] = between(answers, 2.0 * at / pixels - 1.0).map(shown);
                    let found = f64::from(pixel[0]);
                    outside += usize::from(found < 0.99 * least || found > 1.01 * most);
                    (seen, range) = (seen + 1, [range[0].min(found), range[1].max(found)]);
                }
                (outside, seen, range)
            };
            let (wrong, seen, range) = outside(&ask(&sides));
            let (of_points, ..) = outside(&ask(&vec![0.0; sides.len()]));
            println!("{text}: {wrong} of {seen} pixels outside, {of_points} of points; {range:.2?}");
            assert!(wrong == 0 && seen > 10_000, "{text}: {wrong} of {seen}");
            assert!(3 * of_points > seen && range[1] > 1.2 * range[0], "{text}: {of_points}, {range:?} prove nothing");
        }
    });
}

/// Spheres and strands under three lights of different colors: one sphere cut by the ground, one by the picture's edge, one behind a wall,
/// one behind the camera.
fn still_life() -> Scene {
    let sphere = |position, radius, extinction| Particle { position, radius, extinction };
    let particles = vec![
        sphere([0.1, 0.2, 0.1], 0.7, 0.8),
        sphere([0.9, -0.4, -0.4], 0.5, 1.5),
        sphere([-1.6, 0.3, 0.9], 0.9, 0.4),
        sphere([-0.7, 1.6, -0.2], 0.4, 1.0),
        sphere([0.3, -7.0, 0.0], 0.8, 1.0),
    ];
    let mut scene = from_the_front(scenes::directional("still-life", [0.4, 0.3, -0.8], particles), 40.0);
    let strand = |start, end, radius, opacity| Strand { start, end, radius, opacity };
    scene.strands = vec![
        strand([-1.2, -0.5, -0.6], [0.7, -0.6, 1.2], 0.06, 0.7),
        strand([0.5, 0.0, 1.3], [1.4, 0.1, 1.25], 0.1, 0.5),
    ];
    scene.meshes = vec![scenes::level(-0.6, 6.0, [0.0, 0.0])];
    let wall = [[-1.0, 0.9, -0.6], [-0.5, 0.9, -0.6], [-0.5, 0.9, 0.3], [-1.0, 0.9, 0.3]];
    scene.meshes.push(scenes::quad(wall, 0.5));
    let spot = LightKind::Spot {
        position: DVec3::new(3.0, -3.0, 4.0),
        direction: DVec3::new(-3.0, 3.0, -4.0).normalize(),
        cone_degrees: 70.0,
    };
    let point = LightKind::Point { position: DVec3::new(-2.5, -1.0, 1.5) };
    scene.lights[0].radiance = [0.5, 0.1, 0.0];
    scene.lights.push(Light { kind: spot, radiance: [0.0, 0.6, 0.2], radius: f64::INFINITY });
    scene.lights.push(Light { kind: point, radiance: [0.3, 0.0, 0.7], radius: f64::INFINITY });
    scene
}

/// The device chooses the diagonal that splits a grid cell of a quad: every pixel lies between the twin's darkest and brightest picture, up
/// to the map's resolution. A twin with other vertices, or with per-pixel look-ups, is well outside.
#[test]
fn the_device_draws_what_its_twin_does() {
    by_each("the_device_draws_what_its_twin_does", |context, painter| {
        let scene = still_life();
        let size = [160, 120];
        let camera = camera(&scene, size);
        let casters = Casters::new(&scene);
        let spacing = 18.0;
        let [drawn] = pictures((context, painter), &scene, size, "uncompressed:size=256", [vertex(spacing)]);
        // Returns by how much values lie outside the bounds, on average, and the number of values far outside.
        let outside = |[low, high]: &[Picture; 2]| {
            let bounds = low.pixels.iter().flatten().zip(high.pixels.iter().flatten());
            let by =
                drawn.pixels.iter().flatten().zip(bounds).map(|(d, (l, h))| f64::from((l - d).max(d - h).max(0.0)));
            let by: Vec<_> = by.collect();
            (by.iter().sum::<f64>() / by.len() as f64, by.iter().filter(|b| **b > 0.02).count())
        };
        let twin = vertex_lit::picture(&casters, &scene, &camera, f64::from(spacing));
        let (mean, far) = outside(&twin);
        let room = rms(&twin[0], &twin[1]);
        let elsewhere = outside(&vertex_lit::picture(&casters, &scene, &camera, f64::from(spacing) * 1.3));
        let pixels = picture(&casters, &scene, &camera);
        let fragment = outside(&[pixels.clone(), pixels]);
        println!("outside by {mean:.1e}, {far} values by more than 0.02; diagonals are {room:.1e} apart");
        println!("elsewhere {elsewhere:.5?}, at each pixel {fragment:.5?}");
        let values = 3 * drawn.pixels.len();
        assert!(mean < 5e-4 && far < values / 500, "outside by {mean}, {far} of {values} by more than 0.02");
        assert!(
            elsewhere.0 > 3.0 * mean && fragment.0 > 3.0 * mean,
            "{elsewhere:?}, {fragment:?}: the test proves nothing"
        );
    });
}

/// If the light is the same everywhere, the position of the look-up does not matter.
#[test]
fn even_light_is_the_same_everywhere() {
    if crate::support::is_costly("even_light_is_the_same_everywhere") {
        return;
    }
    by_each("even_light_is_the_same_everywhere", |context, painter| {
        // No light: a spot that faces away. Pixels at the casters' edges must match too.
        let mut dark = still_life();
        let direction = DVec3::X;
        let kind = LightKind::Spot { position: DVec3::new(9.0, 0.0, 0.0), direction, cone_degrees: 20.0 };
        dark.lights = vec![Light { kind, radiance: [1.0; 3], radius: f64::INFINITY }];
        // Full light: strands in one layer across the light, none of which shadows another or itself.
        let mut layer = from_the_front(scenes::directional("layer", [0.0, 1.0, 0.0], Vec::new()), 40.0);
        let mut random = scenes::Random::new(31);
        for _ in 0..60 {
            let [x, z, dx] = random.point(-1.5, 1.5);
            let end = [x + dx, 0.0, z + random.between(-1.5, 1.5)];
            layer.strands.push(Strand { start: [x, 0.0, z], end, radius: 0.04, opacity: random.between(0.2, 1.0) });
        }
        for (scene, brightest) in [(&dark, 0.15 * 0.95), (&layer, 0.7 * 1.1)] {
            for text in techniques("even_light_is_the_same_everywhere", context) {
                let [pixels, drawn] = pictures((context, painter), scene, [128, 96], &text, [FRAGMENT, vertex(8.0)]);
                let difference = largest(&pixels, &drawn);
                println!("{}, {text}: largest difference {difference:.1e}", scene.name);
                assert!(difference < 1e-4, "{}, {text}: {difference}", scene.name);
                let seen = drawn.pixels.iter().flatten().fold(0.0f32, |a, b| a.max(*b));
                assert!(seen > 0.9 * brightest, "{}, {text}: {seen}", scene.name);
            }
        }
    });
}

/// The camera is inside a particle, among others clipped by its near plane, and strands that pass it or point at it: no vertex looks up a
/// NaN position. (`pictures` checks every pixel.)
#[test]
fn a_camera_inside_smoke_sees_numbers() {
    if crate::support::is_costly("a_camera_inside_smoke_sees_numbers") {
        return;
    }
    by_each("a_camera_inside_smoke_sees_numbers", |context, painter| {
        let mut scene = from_the_front(scenes::random(), 60.0);
        let eye = [0.0f32, -5.0, 0.0];
        scene.particles.truncate(60);
        for radius in [0.0004, 0.01, 0.3, 2.0, 5.0] {
            scene.particles.push(Particle { position: eye, radius, extinction: 0.1 });
            scene.particles.push(Particle { position: [0.1, -5.0 - radius, 0.0], radius, extinction: 0.1 });
        }
        let strand = |start, end| Strand { start, end, radius: 0.05, opacity: 0.3 };
        scene.strands.push(strand(eye, [0.0, 0.0, 0.0]));
        scene.strands.push(strand([0.0, -6.0, 0.0], [0.0, 1.0, 0.0]));
        scene.strands.push(strand([-1.0, -5.0, 0.01], [1.0, -5.0, 0.01]));
        scene.meshes.push(scenes::level(-0.5, 6.0, [0.0, 0.0]));
        let point = scenes::point([0.0, -5.0, 0.0], scene.clone());
        for scene in [scene, point] {
            for text in techniques("a_camera_inside_smoke_sees_numbers", context) {
                let [pixels, drawn] = pictures((context, painter), &scene, [96, 54], &text, [FRAGMENT, vertex(4.0)]);
                let apart = rms(&pixels, &drawn);
                println!("{text}: {apart:.1e} apart");
                assert!(apart < 0.05, "{text}: {apart}");
            }
        }
    });
}

/// On real smoke, lighting at vertices is nearly identical to lighting at pixels, as Fife and Strugar (2013) say; hair is thinner than the
/// spacing of vertices.
#[test]
fn smoke_is_nearly_identical() {
    if crate::support::is_costly("smoke_is_nearly_identical") {
        return;
    }
    by_each("smoke_is_nearly_identical", |context, painter| {
        for (name, size, bound) in some([("hair", [320, 240], 0.02), ("three-emitters", [640, 360], 0.003)], 1) {
            let scene = Scene::load(name, 20.0).expect("built in");
            let lightings = [FRAGMENT, vertex(16.0), vertex(VERTEX_SPACING), vertex(4.0)];
            let [pixels, drawn @ ..] =
                pictures((context, painter), &scene, size, "avsm:size=128,path=two-pass", lightings);
            let errors = drawn.map(|p| picture_error(&p, &pixels));
            println!("{name}, 16, {VERTEX_SPACING} and 4 pixels from vertex to vertex: {errors:?}");
            assert!(errors[1].rmse < bound, "{name}: {errors:?}");
            assert!(errors.windows(2).all(|e| e[1].rmse < e[0].rmse), "{name}: {errors:?}");
        }
    });
}

/// More vertices than 16 bits can number, which lavapipe loses in a single draw.
#[test]
fn many_vertices_are_all_drawn() {
    by_each("many_vertices_are_all_drawn", |context, painter| {
        let sphere = |i: u16| Particle { position: [f32::from(i) * 0.02, 0.0, 0.0], radius: 1.0, extinction: 0.1 };
        let scene = from_the_front(scenes::directional("row", [0.5, 0.3, -0.81], (0..20).map(sphere).collect()), 40.0);
        // 20 quads of 65² vertices.
        let [pixels, drawn] =
            pictures((context, painter), &scene, [128, 128], "avsm:size=64,path=two-pass", [FRAGMENT, vertex(1.0)]);
        let quads =
            scene.casters().iter().map(|c| vertex_lit::quad(&camera(&scene, [128, 128]), c, 1.0)).collect::<Vec<_>>();
        assert!(quads.iter().flatten().filter(|q| q.parts == [64, 64]).count() == 20, "{quads:?}");
        let apart = rms(&pixels, &drawn);
        println!("{apart:.1e} apart");
        assert!(apart < 2e-3, "{apart}");
    });
}

/// Wireframe lines are drawn over the picture, and only where casters are.
#[test]
fn lines_are_drawn_over_casters_alone() {
    let needs = [Requirement::Tessellation, Requirement::Lines];
    gpu_test_needing("lines_are_drawn_over_casters_alone", &needs, |context| {
        let scene = still_life();
        let size = [160, 120];
        let world = World::new(context, &scene).expect("room for the scene");
        let camera = camera(&scene, size);
        let mut renderer = Renderer::new(context, &world, &camera).expect("a renderer");
        // The rasterizer draws the picture without lines too: compute passes interpolate differently between vertices.
        renderer.paint_by(Some(PainterKind::Raster));
        let technique = built(context, &scene, "psm:size=64,slices=64");
        let answer = technique.answer();
        let count = |spacing: f32| {
            let before = renderer.picture(&answer, Shading::Forward, vertex(spacing)).expect("drawn");
            let after = renderer.wireframe(&answer, Shading::Forward, spacing).expect("drawn");
            let mut changed = 0;
            for (i, (a, b)) in before.pixels.iter().zip(&after.pixels).enumerate() {
                if a != b {
                    let at = glam::DVec2::new((i as u32 % size[0]) as f64, (i as u32 / size[0]) as f64) + 0.5;
                    let ndc = at / glam::DVec2::from(size.map(f64::from)) * 2.0 - 1.0;
                    let quads = scene.casters().into_iter().filter_map(|c| vertex_lit::quad(&camera, &c, 16.0));
                    // A line is one pixel wide.
                    let inside = |q: vertex_lit::Quad| {
                        let wide = glam::DVec2::splat(2.0 / f64::from(size[1]));
                        ndc.cmpge(q.corners[0] - wide).all() && ndc.cmple(q.corners[1] + wide).all()
                    };
                    assert!(quads.into_iter().any(inside), "a line at {at}, where no quad is");
                    changed += 1;
                }
            }
            changed
        };
        let (coarse, fine) = (count(16.0), count(8.0));
        println!("{coarse} and {fine} pixels under lines");
        assert!(coarse > 500 && fine > coarse + coarse / 4, "{coarse}, {fine}");
    });
}

/// A missing feature is named in the same words as in a comparison's row.
#[test]
fn a_device_without_tessellation_refuses() {
    gpu_test_needing("a_device_without_tessellation_refuses", &[], |context| {
        let mut features = context.features().clone();
        (features.tessellation_shader, features.fill_mode_non_solid) = (false, false);
        let settings = |text: &str| spec(text).settings::<ShadingSettings>();
        for technique in REGISTRY.iter().map(|entry| entry.name) {
            settings(technique).check(&features).expect("light at each pixel needs nothing");
            settings(&format!("{technique}:lighting=vertex,painter=compute"))
                .check(&features)
                .expect("no tessellation");
            let error = settings(&format!("{technique}:lighting=vertex,painter=raster")).check(&features);
            assert_eq!(error.map_err(|e| e.to_string()), Err("refused: needs tessellationShader".into()));
        }
        let error = features.require(&[Requirement::Lines]).expect_err("lines");
        assert!(matches!(&error, Error::Refused(Need::Feature(Requirement::Lines))), "{error}");
        (features.tessellation_shader, features.fill_mode_non_solid) = (true, true);
        features.require(&[Requirement::Tessellation, Requirement::Lines]).expect("both are there");
    });
}
