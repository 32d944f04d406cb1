//! Point lights in every direction, including the edges and corners of the cube, and several lights at once.

use crate::support::{ask, built, every_path, gpu_test, gpu_test_needing, scenes, some, spec};
use glam::DVec3;
use gobo::gpu::Requirement;
use gobo::query::{PointBatch, Query};
use gobo::reference::truth::Casters;
use gobo::scene::{Particle, Scene, gutter_texels};
use gobo::technique::{self, Name};
use gobo::world::World;

/// Position of the light; no coordinate is a short binary fraction.
const LIGHT: [f64; 3] = [0.3, -1.1, 0.7];

fn light() -> DVec3 {
    DVec3::from(LIGHT).as_vec3().as_dvec3()
}

/// A point light and one sphere.
fn sphere(centre: DVec3, radius: f32, extinction: f32) -> Scene {
    let particle = Particle { position: centre.as_vec3().into(), radius, extinction };
    scenes::point(LIGHT, scenes::directional("sphere", [0.0, 0.0, -1.0], vec![particle]))
}

/// Returns unit vectors: the axes, the cube's edges and corners exactly and a hair to each side, and random ones.
fn directions() -> Vec<DVec3> {
    let mut all = Vec::new();
    let signs = [-1.0, 0.0, 1.0];
    for (x, y, z) in signs.iter().flat_map(|x| signs.iter().flat_map(move |y| signs.map(|z| (*x, *y, z)))) {
        let corner = DVec3::new(x, y, z);
        if corner == DVec3::ZERO {
            continue;
        }
        all.push(corner);
        for hair in [1e-6, 1e-3] {
            all.extend([DVec3::X, DVec3::Y, DVec3::Z].map(|axis| corner + hair * axis));
        }
    }
    let mut random = scenes::Random::new(21);
    // Along the edges: two coordinates equal and largest.
    for _ in 0..200 {
        let [a, b, c] = random.point(-1.0, 1.0).map(f64::from);
        all.extend([DVec3::new(a, a, a * b), DVec3::new(a * b, a, -a), DVec3::new(-a, a * c, a)]);
        all.push(DVec3::new(a, b, c));
    }
    all.retain(|d| d.length() > 1e-3);
    all.into_iter().map(DVec3::normalize).collect()
}

/// A sphere around the light: the transmittance is exp(−σ d) at distance d inside and exp(−σ r) behind it, in every direction. Behind it
/// all rays of a map have the same value, so no filter changes anything unless it reads past the edge of a face.
#[test]
fn a_sphere_around_a_point_light_has_a_closed_form() {
    gpu_test("a_sphere_around_a_point_light_has_a_closed_form", |context| {
        let (radius, extinction) = (1.25f32, 0.9f32);
        let scene = sphere(light(), radius, extinction);
        let casters = Casters::new(&scene);
        let behind: Vec<_> = directions().iter().map(|d| light() + *d * f64::from(radius) * 2.5).collect();
        let expected = (-f64::from(radius) * f64::from(extinction)).exp();
        for point in &behind {
            assert!((casters.visibility(0, *point) - expected).abs() < 1e-6, "the reference at {point}");
        }
        let points: Vec<_> = behind.iter().map(|p| p.as_vec3().to_array()).collect();
        for text in [
            "uncompressed:size=4",
            "uncompressed:size=33",
            "uncompressed:size=24,filter=box",
            "uncompressed:size=72,filter=gaussian,radius=8",
            "avsm:size=32,nodes=4,path=two-pass",
            "avsm:size=32,nodes=8,path=binned",
            "avsm:size=72,path=two-pass,filter=box,radius=8",
        ] {
            let answers = ask(context, built(context, &scene, text).as_ref(), 0, &points);
            for (answer, point) in answers.iter().zip(&points) {
                assert!((f64::from(*answer) - expected).abs() < 1e-5, "{text} at {point:?}: {answer}, not {expected}");
            }
        }

        // Along the rays of texel centres, the path through the sphere equals the distance, inside it too.
        const SIZE: u32 = 32;
        let technique = built(context, &scene, &format!("uncompressed:size={SIZE}"));
        let (mut points, mut expected) = (Vec::new(), Vec::new());
        for (face, view) in technique.inspect().maps().iter().map(|m| m.caster_view).enumerate() {
            for (x, y, share) in
                (4..28).flat_map(|x| (4..28).map(move |y| (x, y, 0.05 + 0.03 * f64::from((x + y) % 29))))
            {
                let ray = view.ray(glam::DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5));
                let distance = share * f64::from(radius);
                let point = ray.at(distance / ray.direction.length()).as_vec3().to_array();
                assert_eq!(scene.lights[0].map_at(point), face, "within 45 degrees");
                points.push(point);
                expected.push((-distance * f64::from(extinction)).exp());
            }
        }
        let answers = ask(context, technique.as_ref(), 0, &points);
        for ((answer, expected), point) in answers.iter().zip(expected).zip(&points) {
            assert!((f64::from(*answer) - expected).abs() < 1e-5, "at {point:?}: {answer}, not {expected}");
        }
    });
}

/// A sphere across an edge and one across a corner of the cube. Behind it, a look-up is a mean over the rays of the four texels around the
/// point. Each ray passes the sphere's centre at a distance that differs from the point's own by at most the reach of these texels, so the
/// look-up lies between the values for those distances, whichever face it comes from. Two points on either side of an edge are close enough
/// that this also bounds the seam.
#[test]
fn faces_agree_across_their_edges() {
    gpu_test("faces_agree_across_their_edges", |context| {
        const SIZE: u32 = 96;
        let (radius, extinction, away) = (0.5f64, 2.0f64, 1.3);
        let texel = 2.0 / (f64::from(SIZE) - 2.0 * f64::from(gutter_texels(SIZE)));
        // The centres of the four texels are less than one texel away in x and in y, and an angle is at most its tangent.
        let reach = away * texel * 2.0f64.sqrt();
        let chord = |b: f64| 2.0 * (radius * radius - b * b).max(0.0).sqrt();
        let through = |b: f64| (-extinction * chord(b)).exp();
        for towards in [DVec3::new(1.0, -1.0, 0.2), DVec3::new(-1.0, 1.0, 1.0), DVec3::new(0.0, -1.0, -1.0)] {
            let centre = light() + towards.normalize() * away;
            let scene = sphere(centre, radius as f32, extinction as f32);
            let mut random = scenes::Random::new(5);
            let mut points = Vec::new();
            for direction in directions() {
                points.push(light() + direction * 3.0);
            }
            // Most of these points lie behind the sphere, on both sides of the cube's edges.
            while points.len() < 4000 {
                let near = towards.normalize() + 0.5 * DVec3::from(random.point(-1.0, 1.0).map(f64::from));
                let far = near.abs().max_element();
                let on_edge = near.map(|c| if c.abs() > 0.8 * far { c.signum() * far } else { c });
                let hair = 1e-6 * DVec3::from(random.point(-1.0, 1.0).map(f64::from));
                points.extend([near, on_edge + hair, on_edge - hair].map(|d| light() + d.normalize() * 3.0));
            }
            let asked: Vec<_> = points.iter().map(|p| p.as_vec3().to_array()).collect();
            for text in ["uncompressed", "avsm:nodes=16,path=two-pass", "avsm:nodes=16,path=binned"] {
                let text =
                    if text.contains(':') { format!("{text},size={SIZE}") } else { format!("{text}:size={SIZE}") };
                let answers = ask(context, built(context, &scene, &text).as_ref(), 0, &asked);
                let mut shadowed = 0;
                for (answer, point) in answers.iter().zip(&asked) {
                    let offset = DVec3::from(point.map(f64::from)) - light();
                    let to_centre = centre.as_vec3().as_dvec3() - light();
                    let passes = if to_centre.dot(offset) > 0.0 {
                        to_centre.reject_from(offset).length()
                    } else {
                        f64::INFINITY
                    };
                    let (low, high) = (through((passes - reach).max(0.0)), through(passes + reach));
                    let fits = (low - 1e-5..=high + 1e-5).contains(&f64::from(*answer));
                    assert!(fits, "{text} at {point:?}: {answer}, not {low} to {high}");
                    shadowed += u32::from(*answer < 0.5);
                }
                assert!(shadowed > 500, "{text}: {shadowed} points in shadow");
            }
        }
    });
}

/// Each light's look-ups equal those of the light alone, on every path of every technique.
#[test]
fn lights_do_not_disturb_each_other() {
    if crate::support::is_costly("lights_do_not_disturb_each_other") {
        return;
    }
    let name = "lights_do_not_disturb_each_other";
    gpu_test(name, |context| {
        let mut scene = scenes::four_lights();
        scene.meshes.push(scenes::level(-0.9, 2.0, [0.0, 0.0]));
        let mut random = scenes::Random::new(31);
        let points: Vec<_> = (0..4000).map(|_| random.point(-1.3, 1.3)).collect();
        for mut spec in every_path(name, context) {
            spec.set(Name::SIZE, "24");
            let text = spec.short();
            let tolerance = match spec.entry.name {
                "avsm" => 0.0,
                // Samplers may quantize weights to 1/256, and rounding depends on where the layers are in the volume.
                "psm" => 2.0 / 256.0,
                // Lists are summed in the order of capture, which differs from run to run, and so does the rounding.
                _ => 1e-5,
            };
            let all = built(context, &scene, &text);
            let mut answers = Vec::new();
            for light in some(0..scene.lights.len(), 2) {
                let together = ask(context, all.as_ref(), light, &points);
                let alone = Scene { lights: vec![scene.lights[light]], ..scene.clone() };
                let alone = ask(context, built(context, &alone, &text).as_ref(), 0, &points);
                let most = together.iter().zip(&alone).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
                assert!(most <= tolerance, "{text}, light {light}: {most}");
                assert!(together.iter().filter(|t| **t < 0.9).count() > 400, "{text}, light {light} casts shadows");
                answers.push(together);
            }
            assert!(answers.windows(2).all(|a| a[0] != a[1]), "{text}: two lights answer alike");
        }
    });
}

/// Batches for all lights, some of them empty, give the same look-ups as each batch alone, in order.
#[test]
fn lights_are_asked_together() {
    gpu_test("lights_are_asked_together", |context| {
        let mut scene = scenes::four_lights();
        scene.meshes.push(scenes::level(-0.3, 0.6, [0.0, 0.0]));
        let technique = built(context, &scene, "shadow-map:size=64");
        let mut random = scenes::Random::new(37);
        // Some batches extend past the end of a workgroup, some are empty.
        let lists = [(0, 500), (2, 0), (1, 129), (3, 64), (0, 1)]
            .map(|(light, count)| (light, (0..count).map(|_| random.point(-1.3, 1.3)).collect::<Vec<_>>()));
        let asked: Vec<_> =
            lists.iter().map(|(light, points)| PointBatch { light: *light, points, normals: &[] }).collect();
        let query = Query::of_lights(context, &asked).expect("room for the points");
        assert_eq!(query.points(), 694);
        let together = query.ask(&technique.answer()).expect("answered");
        let alone: Vec<_> =
            lists.iter().flat_map(|(light, points)| ask(context, technique.as_ref(), *light, points)).collect();
        assert_eq!(together, alone);
        assert!(together.contains(&0.0) && together.contains(&1.0));
        assert_eq!(
            Query::of_lights(context, &[]).expect("of nothing").ask(&technique.answer()).expect("asked"),
            [0.0; 0]
        );
    });
}

/// Whatever cannot be built is refused by name before anything is allocated.
#[test]
fn limits_of_lights_are_errors() {
    gpu_test_needing("limits_of_lights_are_errors", &[Requirement::FragmentStores], |context| {
        let open = |scene: &Scene, text: &str| {
            let world = World::new(context, scene).expect("room for the scene");
            technique::open(context, &world, &spec(text)).map(|_| ())
        };
        let refused = |scene: &Scene, text: &str| open(scene, text).expect_err(text).to_string();
        let point = scenes::inside();
        for (text, words) in [
            ("uncompressed:size=3", "a size of 4 or more"),
            ("avsm:size=16,filter=box", "a size of 24 or more"),
            ("avsm:size=71,filter=gaussian,radius=8", "a size of 72 or more"),
        ] {
            let error = refused(&point, text);
            assert!(error.contains(words) && !error.contains('\n'), "{text}: {error}");
        }
        // Each map is one workgroup in z, and every device supports this many.
        let most = 65535;
        let mut many = scenes::random();
        many.lights = vec![many.lights[0]; most + 1];
        let error = refused(&many, "avsm:size=8");
        assert!(error.contains(&format!("{} maps", most + 1)) && !error.contains('\n'), "{error}");
        let points = Scene { lights: vec![point.lights[0]; most / 6 + 1], ..point.clone() };
        let error = refused(&points, "avsm:size=8");
        assert!(error.contains(&format!("{} maps", 6 * (most / 6 + 1))), "{error}");
        many.lights.truncate(40);
        let rows = context.features().max_image_dimension_2d / 40 + 1;
        let error = refused(&many, &format!("uncompressed:size={rows}"));
        assert!(error.contains("list.heads") && error.contains("40 maps"), "{error}");
    });
}
