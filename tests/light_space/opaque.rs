//! Techniques that shadow with meshes alone: no flat receiver shadows itself, occluders cast the reference's shadows, lights do not disturb
//! each other, and a moved world gives the same result as a new one. Tests of single techniques are in opaque/.

mod compute;

mod kept;

mod ray_query;

mod shadow_map;

use crate::support::scenes::{self, Random};
use crate::support::within::{diagonal, shares_within};
use crate::support::{ask, ask_on, built, gpu_test, opened, skipped, some, spec};
use glam::DVec3;
use gobo::Error;
use gobo::gpu::Context;
use gobo::reference::truth::{Casters, space_points, surface_points};
use gobo::scene::{Light, LightKind, Mesh, Scene, View};
use gobo::technique::{Technique, open};
use gobo::world::World;

/// Returns the specs that the device runs: rays, and maps with every filter, both bit depths, coarse and fine, drawn both ways.
fn specs(test: &str, context: &Context) -> Vec<String> {
    let filters = [1, 9, 3, 5, 7].into_iter().flat_map(|filter| [(filter, 32), (filter, 16)]);
    let maps = |(filter, bits)| [64, 1024].map(|size| format!("shadow-map:size={size},filter={filter},bits={bits}"));
    let ways = ["raster", "compute"].map(|way| format!("shadow-map:size=256,opaque={way}"));
    let more = ["ray-query".to_owned()].into_iter().chain(ways);
    let all = more.chain(some(filters, 4).into_iter().flat_map(maps));
    let specs: Vec<_> = all.filter(|text| runs(test, context, text)).collect();
    assert!(!specs.is_empty(), "shadow maps run everywhere");
    specs
}

/// Returns whether this device runs `text`; if it is refused, logs `test` as skipped with the reason.
fn runs(test: &str, context: &Context, text: &str) -> bool {
    let mut plate = scenes::directional("plate", [0.0, 0.0, -1.0], Vec::new());
    plate.meshes.push(scenes::level(0.0, 1.0, [0.0, 0.0]));
    let world = World::new(context, &plate).expect("room for a plate");
    match open(context, &world, &spec(text)) {
        Ok(_) => true,
        Err(Error::Refused(needs)) => {
            skipped(test, &format!("{text}: needs {needs}"));
            false
        }
        Err(error) => panic!("{text}: {error}"),
    }
}

fn light(kind: LightKind) -> Light {
    Light { kind, radiance: [1.0; 3], radius: f64::INFINITY }
}

/// Returns scenes under directional lights at these elevations in degrees, each from a different side.
fn slanted(elevations: &[f64]) -> Vec<Scene> {
    let scene = |(i, elevation): (usize, &f64)| {
        let (elevation, azimuth) = (elevation.to_radians(), 0.3 + 2.4 * i as f64);
        let across = elevation.cos();
        scenes::directional("slanted", [azimuth.cos() * across, azimuth.sin() * across, -elevation.sin()], Vec::new())
    };
    elevations.iter().enumerate().map(scene).collect()
}

/// Returns a scene for every kind of light: directional ones at these elevations in degrees, the others aimed at `at`.
pub fn lights(elevations: &[f64], at: DVec3) -> Vec<Scene> {
    let mut all = slanted(elevations);
    let under = |kind| Scene { lights: vec![light(kind)], ..all[0].clone() };
    let places = [DVec3::new(1.0, 2.0, 6.0), DVec3::new(7.0, -3.0, 0.5)].map(|offset| at + offset);
    let others = places.into_iter().flat_map(|position| {
        let direction = (at - position).normalize();
        [LightKind::Spot { position, direction, cone_degrees: 90.0 }, LightKind::Point { position }].map(under)
    });
    let others: Vec<_> = others.collect();
    all.extend(others);
    all
}

/// Returns a square of half side `half`, centred at `at` and tilted by `degrees`.
fn leaning(degrees: f32, half: f32, at: [f32; 3]) -> Mesh {
    let (sin, cos) = degrees.to_radians().sin_cos();
    let corner = |x: f32, y: f32| [at[0] + half * x * cos, at[1] + half * y, at[2] + half * x * sin];
    scenes::quad([corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)], 0.5)
}

/// Returns points on a mesh's triangles, as exact as f32 allows.
fn points_of(mesh: &Mesh, count: usize) -> Vec<[f32; 3]> {
    let mut random = Random::new(5);
    let corner = |v: u32| DVec3::from(mesh.positions[v as usize].map(f64::from));
    let point = |i: usize| {
        let [a, b, c] = mesh.triangles[i % mesh.triangles.len()].map(corner);
        let (u, v) = (f64::from(random.between(0.0, 1.0)), f64::from(random.between(0.0, 1.0)));
        let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
        (a + u * (b - a) + v * (c - a)).as_vec3().into()
    };
    (0..count).map(point).collect()
}

/// No point of a flat receiver is shadowed by lights from overhead down to 1° above its plane, whether it is level or tilted, at the origin
/// or where floats are thirty times coarser.
#[test]
fn a_flat_receiver_never_shadows_itself() {
    let name = "a_flat_receiver_never_shadows_itself";
    gpu_test(name, |context| {
        let mut specs = specs(name, context);
        // A Beer shadow map uses the opaque map that all techniques with other maps share.
        specs.extend(["raster", "compute"].map(|way| format!("beer-shadow-map:size=8,opaque={way}")));
        for (at, lean) in some([([0.0; 3], 20.0), ([300.0, -200.0, 50.0], 0.0), ([0.0; 3], 0.0)], 2) {
            for mut scene in lights(&[90.0, 60.0, 30.0, 5.0, 1.0], DVec3::from(at.map(f64::from))) {
                scene.meshes.push(leaning(lean, 5.0, at));
                let points = points_of(&scene.meshes[0], 2000);
                let normals = normals_of(&scene, &scene.meshes[0], &points);
                for text in &specs {
                    let answers = ask_on(context, built(context, &scene, text).as_ref(), 0, &points, &normals);
                    let light = scene.lights[0].kind;
                    for (point, answer) in points.iter().zip(answers) {
                        // Bilinear weights are rounded.
                        assert!(answer >= 1.0 - 1e-6, "{text} at {point:?}, {light:?}, leaning by {lean}: {answer}");
                    }
                }
            }
        }
    });
}

/// Plates over the ground, level, tilted and upright, none touching another.
fn plates() -> Vec<Mesh> {
    vec![
        scenes::level(0.0, 5.0, [0.0, 0.0]),
        scenes::level(1.0, 1.4, [-2.5, -2.5]),
        leaning(35.0, 1.2, [2.5, -1.0, 1.2]),
        leaning(-80.0, 0.5, [0.0, 2.0, 0.7]),
        leaning(10.0, 0.5, [-2.5, 2.5, 2.2]),
    ]
}

/// Points whose look-up is above 0.5 though dark or below 0.5 though lit, and the numbers of points that are lit, dark and in the boundary.
#[derive(Debug, Default)]
struct Counted {
    leaks: Vec<[f32; 3]>,
    false_shadows: Vec<[f32; 3]>,
    lit: usize,
    dark: usize,
    boundary: usize,
    /// Shares of points in space and on surfaces that lie in the boundary.
    shares: [f64; 2],
}

/// Returns how far from a plate's surface a shadow map of this size may still be affected by it, in world units, in space and on surfaces.
/// It assumes the widest texel anywhere in the scene, whatever resolution the technique claims.
fn reach(scene: &Scene, size: u32, filter: u32) -> [f64; 2] {
    let diagonal = diagonal(scene);
    let width = match scene.lights[0].kind {
        LightKind::Directional { .. } => diagonal,
        // Width of a 90° view at the farthest distance, plus a quarter on each side for a point light's face.
        _ => 3.0 * (scene.lights[0].position().expect("a place").length() + 0.5 * diagonal),
    };
    // In space: half the filter's width plus one step of the coarsest rasterizer grid. On surfaces: also the receiver's offset from its
    // surface.
    let (texel, filter) = (width / f64::from(size), f64::from(filter));
    let in_space = 2f64.sqrt() * texel * (0.5 * filter + 0.07);
    [in_space, in_space + 2f64.sqrt() * texel * 0.15 * filter]
}

/// Counts points in space and on the meshes, for the scene's first light.
fn counted(context: &Context, scene: &Scene, technique: &dyn Technique) -> Counted {
    const POINTS: usize = 8000;
    let (casters, light, resolution) = (Casters::new(scene), scene.lights[0], technique.inspect().resolution());
    let of = |p: &[f32; 3]| resolution.get(light.map_at(*p));
    let camera = View::camera(&scene.camera, scene, [320, 180]);
    let mut all = Vec::new();
    for p in space_points(scene, 0, POINTS) {
        let at = DVec3::from(p.map(f64::from));
        all.push((p, [0.0; 3], casters.unblocked(0, at), of(&p).is_some_and(|r| casters.in_boundary(0, r, at))));
    }
    for s in surface_points(&casters, scene, 0, &camera, POINTS).into_iter().filter(|s| light.shines_on(s.position)) {
        let p: [f32; 3] = s.position.as_vec3().into();
        let normal = s.facing(light.towards(s.position));
        let boundary = of(&p).is_some_and(|r| casters.in_surface_boundary(0, r, s.position, normal));
        all.push((p, normal.as_vec3().into(), casters.unblocked(0, s.position), boundary));
    }
    let (points, normals): (Vec<_>, Vec<_>) = all.iter().map(|(p, normal, _, _)| (*p, *normal)).unzip();
    let share = |on: bool| {
        let of: Vec<_> = all.iter().filter(|(_, normal, _, _)| (*normal != [0.0; 3]) == on).collect();
        of.iter().filter(|(_, _, _, boundary)| *boundary).count() as f64 / of.len() as f64
    };
    let mut counted = Counted { shares: [share(false), share(true)], ..Counted::default() };
    for ((point, _, lit, boundary), answer) in all.into_iter().zip(ask_on(context, technique, 0, &points, &normals)) {
        match (boundary, lit) {
            (true, _) => counted.boundary += 1,
            (false, true) => counted.lit += 1,
            (false, false) => counted.dark += 1,
        }
        if !boundary && lit && answer < 0.5 {
            counted.false_shadows.push(point);
        }
        if !boundary && !lit && answer > 0.5 {
            counted.leaks.push(point);
        }
    }
    counted
}

/// Returns the normals of the triangles of `points_of`, facing the scene's first light.
fn normals_of(scene: &Scene, mesh: &Mesh, points: &[[f32; 3]]) -> Vec<[f32; 3]> {
    let corner = |v: u32| DVec3::from(mesh.positions[v as usize].map(f64::from));
    let normal = |(i, point): (usize, &[f32; 3])| {
        let [a, b, c] = mesh.triangles[i % mesh.triangles.len()].map(corner);
        let normal = (b - a).cross(c - a).normalize();
        let towards = scene.lights[0].towards(DVec3::from(point.map(f64::from)));
        (normal * normal.dot(towards).signum()).as_vec3().into()
    };
    points.iter().enumerate().map(normal).collect()
}

#[test]
fn occluders_shadow_what_the_reference_says() {
    if crate::support::is_costly("occluders_shadow_what_the_reference_says") {
        return;
    }
    let name = "occluders_shadow_what_the_reference_says";
    gpu_test(name, |context| {
        let specs = specs(name, context);
        for mut scene in lights(&[80.0, 50.0, 20.0], DVec3::ZERO) {
            scene.meshes = plates();
            let of_size = |size| shares_within(&scene, reach(&scene, size, 1), 250);
            let bounds = [("shadow-map:size=64,filter=1,", of_size(64)), ("shadow-map:size=256,opaque=", of_size(256))];
            for text in &specs {
                let counted = counted(context, &scene, built(context, &scene, text).as_ref());
                // The technique must not pass by putting everything in the boundary. Both shares are estimated from samples.
                let shares = bounds.iter().filter(|(start, _)| text.starts_with(start));
                for (within, by_rays) in shares.flat_map(|(_, by_rays)| counted.shares.iter().zip(by_rays)) {
                    println!("{text}: {within:.3} within, {by_rays:.3} by rays");
                    assert!(*within <= by_rays + 0.05, "{text}: {within} within, {by_rays} by rays");
                }
                let kind = scene.lights[0].kind;
                assert_eq!((counted.leaks.len(), counted.false_shadows.len()), (0, 0), "{text}, {kind:?}: {counted:?}");
                println!("{text}, {kind:?}: {} lit, {} dark, {} boundary", counted.lit, counted.dark, counted.boundary);
                assert!(counted.lit > 2000, "{text}, {kind:?}: {counted:?}");
                // A map of 64 texels with a filter nine texels wide resolves little of these plates.
                assert!(counted.dark > 200 || text.contains("size=64"), "{text}, {kind:?}: {counted:?}");
            }
        }
    });
}

/// Returns the look-ups of `text` at points of light `light`.
fn answers(context: &Context, scene: &Scene, text: &str, light: usize) -> Vec<f32> {
    let points: Vec<_> = scene.meshes.iter().flat_map(|mesh| points_of(mesh, 600)).collect();
    let raised = points.iter().map(|[x, y, z]| [*x, *y, *z + 0.05]);
    let points: Vec<_> = points.iter().copied().chain(raised).collect();
    ask(context, built(context, scene, text).as_ref(), light, &points)
}

/// Each of several lights gives the same look-ups as alone, except for one point in a thousand, because a rasterizer may round a depth
/// differently if the map lies elsewhere in the image.
#[test]
fn lights_do_not_disturb_each_other() {
    let name = "opaque::lights_do_not_disturb_each_other";
    gpu_test(name, |context| {
        let mut several = scenes::four_lights();
        (several.particles, several.meshes) = (Vec::new(), plates());
        for text in some(specs(name, context), 5) {
            for (i, light) in several.lights.iter().enumerate() {
                let alone = Scene { lights: vec![*light], ..several.clone() };
                let (alone, together) = (answers(context, &alone, &text, 0), answers(context, &several, &text, i));
                let differ: Vec<_> = alone.iter().zip(&together).enumerate().filter(|(_, (a, b))| a != b).collect();
                // A rasterizer may round a depth differently elsewhere in the image, which flips one of a filter's many comparisons.
                let off: f32 = differ.iter().map(|(_, (a, b))| (*a - *b).abs()).sum();
                assert!(1000.0 * off <= alone.len() as f32, "{text}, light {i}: {} differ: {differ:?}", differ.len());
                let [lit, dark] = [1.0, 0.0].map(|of| alone.iter().filter(|a| **a == of).count());
                assert!(lit < alone.len() && lit > 0, "{text}, light {i}: {lit} lit and {dark} dark prove nothing");
            }
        }
    });
}

#[test]
fn nothing_casts_nothing() {
    let name = "nothing_casts_nothing";
    gpu_test(name, |context| {
        for text in specs(name, context) {
            for scene in lights(&[60.0], DVec3::ZERO) {
                let mut random = Random::new(3);
                let points: Vec<_> = (0..200).map(|_| random.point(-3.0, 3.0)).collect();
                let answers = ask(context, built(context, &scene, &text).as_ref(), 0, &points);
                assert!(answers.iter().all(|a| *a == 1.0), "{text}");
            }
            // Smoke without meshes is refused: a perfect score for doing nothing would be a lie.
            let smoke = scenes::random();
            let world = World::new(context, &smoke).expect("room for the scene");
            let opened = open(context, &world, &spec(&text)).map(|_| ());
            if spec(&text).entry.casts.particles {
                assert!(opened.is_ok(), "{text} sees smoke: {opened:?}");
                continue;
            }
            let refused = opened.expect_err("smoke alone");
            let words = "refused: needs meshes in the scene, and random has none";
            assert_eq!((refused.to_string().as_str(), matches!(refused, Error::Refused(_))), (words, true));
        }
    });
}

/// After meshes and lights have moved, look-ups equal those of a technique opened for that world, to the bit.
#[test]
fn a_moved_world_is_a_new_world() {
    let name = "a_moved_world_is_a_new_world";
    gpu_test(name, |context| {
        let mut first = scenes::directional("moves", [0.4, 0.2, -0.8], Vec::new());
        first.meshes = plates();
        let spot = LightKind::Spot { position: DVec3::new(2.0, 1.0, 5.0), direction: DVec3::NEG_Z, cone_degrees: 80.0 };
        first.lights.extend([light(spot), light(LightKind::Point { position: DVec3::new(0.0, 0.0, 3.0) })]);
        let mut second = first.clone();
        second.meshes[1].positions.iter_mut().for_each(|p| *p = [p[0] + 3.0, p[1] + 2.0, p[2] + 1.0]);
        let direction = DVec3::new(-0.3, 0.5, -1.0).normalize();
        second.lights = vec![
            light(LightKind::Directional { direction }),
            light(LightKind::Spot { position: DVec3::new(-3.0, 0.0, 4.0), direction, cone_degrees: 100.0 }),
            light(LightKind::Point { position: DVec3::new(-0.5, -1.0, 2.5) }),
        ];
        let points: Vec<_> = second.meshes.iter().flat_map(|mesh| points_of(mesh, 600)).collect();
        for text in some(specs(name, context), 5) {
            let mut world = World::new(context, &first).expect("room for the scene");
            let mut moving = opened(open(context, &world, &spec(&text)), &text);
            moving.build(&world).expect("built");
            let before: Vec<_> = (0..3).map(|light| ask(context, moving.technique.as_ref(), light, &points)).collect();
            world.replace(&second).expect("it fits");
            let passes = moving.build(&world).expect("built again").passes;
            assert!(!passes.is_empty() || context.features().timestamp_valid_bits == 0, "{text}: it was not built");
            let fresh = built(context, &second, &text);
            assert!(moving.technique.inspect().maps() == fresh.inspect().maps(), "{text}: maps");
            for (light, before) in before.iter().enumerate() {
                let [moved, fresh] =
                    [moving.technique.as_ref(), fresh.as_ref()].map(|of| ask(context, of, light, &points));
                assert!(moved == fresh, "{text}, light {light}");
                assert!(*before != fresh, "{text}, light {light}: nothing has changed");
            }
            let passes = moving.build(&world).expect("nothing to do").passes;
            assert!(passes.is_empty(), "{text}: an unchanged world is built again");
        }
    });
}

/// Facts report bytes and a path, and no nodes, which these techniques do not have.
#[test]
fn facts_are_there() {
    let name = "facts_are_there";
    gpu_test(name, |context| {
        let mut scene = scenes::directional("facts", [0.4, 0.2, -0.8], Vec::new());
        scene.meshes = plates();
        for text in specs(name, context) {
            let facts = built(context, &scene, &text).inspect().facts().expect("facts");
            assert!(facts.bytes_resident > 0 && facts.nodes.is_none() && !facts.path.is_empty(), "{text}: {facts:?}");
        }
    });
}
