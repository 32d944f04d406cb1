//! `shadow-map`: the look-up against its twin, sizes in bytes, and refusals.

use crate::opaque::{lights, normals_of, plates, points_of};
use crate::support::{ask, ask_on, built, gpu_test, opened, scenes, spec};
use glam::{DVec3, Vec3};
use gobo::Error;
use gobo::maps::{Map, opaque_corner};
use gobo::reference::twin::receiver::{Receiver, moved};
use gobo::reference::twin::shadow_map::visibility;
use gobo::scene::{Camera, Light, LightKind, Mesh, Scene};
use gobo::technique::{Opened, ShadowMap, Technique, open};
use gobo::world::World;

/// Upper bound on the rounding of a position, in texels: closer to a texel's edge, the neighbour may be read.
const PLACE_ROUNDING: f32 = 1e-3;

/// Look-ups with every filter equal the twin's, computed from the depths read back: all texels of the filter are read, with equal weight.
/// Every other point is queried as a point in space.
#[test]
fn the_look_up_equals_its_twin() {
    gpu_test("shadow_map::the_look_up_equals_its_twin", |context| {
        for mut scene in lights(&[50.0], DVec3::ZERO) {
            scene.meshes = plates();
            let on = |mesh: &Mesh| {
                let points = points_of(mesh, 1000);
                let normals = normals_of(&scene, mesh, &points);
                points.into_iter().zip(normals).collect::<Vec<_>>()
            };
            let all = scene.meshes.iter().flat_map(on).enumerate();
            let all = all.map(|(i, (point, normal))| (point, if i % 2 == 0 { normal } else { [0.0; 3] }));
            let (points, normals): (Vec<_>, Vec<_>) = all.unzip();
            for (filter, bits) in [(1, 32), (3, 16), (5, 32), (7, 16), (9, 32), (9, 16)] {
                let text = format!("shadow-map:size=96,filter={filter},bits={bits}");
                let world = World::new(context, &scene).expect("room for the scene");
                let map = opened(ShadowMap::new(context, &world, &spec(&text).settings()), &text);
                let mut opened = Opened::new(context, Box::new(map), true);
                opened.build(&world).expect("built");
                let technique = opened.technique;
                let depths: Vec<f32> = if bits == 16 {
                    let codes = technique.image().read::<u16>().expect("the depths");
                    codes.into_iter().map(|code| f32::from(code) / 65535.0).collect()
                } else {
                    technique.image().read().expect("the depths")
                };
                let across = technique.image().size()[0];
                let (mut between, mut compared) = (0, 0);
                let answers = ask_on(context, technique.as_ref(), 0, &points, &normals);
                for ((point, normal), answer) in points.iter().zip(&normals).zip(answers) {
                    let (point, normal) = (Vec3::from(*point), Vec3::from(*normal));
                    let aimed = technique.inspect().maps()[scene.lights[0].map_at(point.into())].opaque;
                    let point = moved(&aimed, point, normal, 0.15 * filter as f32);
                    let map = scene.lights[0].map_at(point.into());
                    let view = technique.inspect().maps()[map].opaque;
                    let (at, z) = view.project(point.as_dvec3());
                    let at = at.as_vec2();
                    let receiver = Receiver::new(&view, point, normal);
                    if (at - at.round()).abs().min_element() < PLACE_ROUNDING || z <= f64::from(view.near) {
                        continue;
                    }
                    let corner = opaque_corner(technique.image(), [96, 96], map as u32);
                    let hit = |texel: glam::IVec2| {
                        let inside = texel.min_element() >= 0 && texel.max_element() < 96;
                        let texel = texel.max(glam::IVec2::ZERO).as_uvec2() + glam::UVec2::from(corner);
                        inside.then(|| depths[(texel.y * across + texel.x) as usize])
                    };
                    // Error bound of a depth: the offset from the view's origin takes four rounded operations, a depth near 1 about ten.
                    let range = view.far - view.near;
                    let rounding = 3e-7 * (point - Vec3::from(view.origin)).length() / range + 1e-6;
                    let of = |sign: f32| {
                        let (depth, least) =
                            (receiver.depth + sign * rounding, receiver.least - sign * rounding * range);
                        let mut receiver = receiver;
                        (receiver.depth, receiver.least) = (depth.min(1.0), least);
                        visibility(filter, at, |hit, apart| receiver.is_ended(hit, apart), hit)
                    };
                    let (low, high) = if receiver.is_turned() { (0.0, 0.0) } else { (of(1.0), of(-1.0)) };
                    // Vulkan allows a division error of 2.5 units in the last place.
                    let (low, high) = (low - 2e-7, high + 2e-7);
                    assert!(
                        (low..=high).contains(&answer) && (0.0..=1.0).contains(&answer),
                        "{text} at {point:?}: {answer}, not {low} to {high}"
                    );
                    compared += 1;
                    between += usize::from(high - low < 1e-6 && (0.01..0.99).contains(&answer));
                }
                let kind = scene.lights[0].kind;
                println!("{text}, {kind:?}: {compared} compared, {between} between light and dark");
                assert!(compared > 4000 && (filter < 5 || between > 100), "{text}, {kind:?}: {compared}, {between}");
            }
        }
    });
}

/// Level plates at many heights, straight below the light, do not shadow themselves, although no slope bias applies and with 16 bits some
/// depths round down and some up.
#[test]
fn depths_between_two_codes() {
    gpu_test("shadow_map::depths_between_two_codes", |context| {
        let mut scene = scenes::directional("steps", [0.0, 0.0, -1.0], Vec::new());
        let mut random = scenes::Random::new(4);
        let place = |i: u16| [f32::from(i % 8), f32::from(i / 8)];
        scene.meshes = (0..64).map(|i| scenes::level(random.between(-2.0, 2.0), 0.4, place(i))).collect();
        let points: Vec<_> = scene.meshes.iter().flat_map(|mesh| points_of(mesh, 20)).collect();
        for text in ["shadow-map:bits=16", "shadow-map:bits=32", "shadow-map:bits=16,filter=5,size=128"] {
            for (point, answer) in points.iter().zip(ask(context, built(context, &scene, text).as_ref(), 0, &points)) {
                assert_eq!(answer, 1.0, "{text} at {point:?}");
            }
        }
    });
}

/// With cascades no flat receiver shadows itself, and a caster that only the narrowest map resolves casts a shadow. A missing camera or
/// another kind of light is refused with a reason.
#[test]
fn cascades() {
    gpu_test("shadow_map::cascades", |context| {
        let mut scene = scenes::directional("cascades", [0.4, 0.3, -0.5], Vec::new());
        scene.meshes = vec![scenes::level(0.0, 5.0, [0.0, 0.0])];
        (scene.camera.position, scene.camera.target) = (DVec3::new(0.0, 0.0, 0.5), DVec3::new(1.0, 1.0, 0.0));
        let points = points_of(&scene.meshes[0], 4000);
        let normals = vec![[0.0, 0.0, 1.0]; 4000];
        for text in ["shadow-map:size=64,cascades=4", "shadow-map:size=32,cascades=3,filter=5"] {
            let map = built(context, &scene, text);
            let lit = ask_on(context, map.as_ref(), 0, &points, &normals);
            assert!(lit.iter().all(|answer| *answer == 1.0), "{text}");
        }
        // Thinner than a texel of the widest map, and wider than one of the narrowest.
        scene.meshes.push(scenes::level(0.4, 0.03, [0.613, 0.587]));
        let below = [[0.613 + 0.4 * 0.8, 0.587 + 0.3 * 0.8, 0.0]];
        let of = |text: &str| {
            let map = built(context, &scene, text);
            let bytes = map.inspect().facts().expect("facts").bytes_resident;
            (ask_on(context, map.as_ref(), 0, &below, &[[0.0, 0.0, 1.0]])[0], bytes)
        };
        assert_eq!(of("shadow-map:size=64,cascades=4"), (0.0, 4 * 4 * 64 * 64));
        assert_eq!(of("shadow-map:size=64").1, 4 * 64 * 64);
        // Under two suns each has its own cascades, which follow the camera: behind it no narrow map sees the caster.
        let mut two = scene.clone();
        let other = LightKind::Directional { direction: DVec3::new(-0.4, 0.3, -0.5).normalize() };
        two.lights.push(Light { kind: other, ..two.lights[0] });
        let beside = [[0.613 - 0.4 * 0.8, 0.587 + 0.3 * 0.8, 0.0]];
        let up = [[0.0, 0.0, 1.0]];
        let mut world = World::new(context, &two).expect("room for the scene");
        let mut opened = open(context, &world, &spec("shadow-map:size=64,cascades=4")).expect("two suns");
        opened.build(&world).expect("built");
        let asked = |map: &dyn Technique| {
            [(0, below), (1, beside), (1, below), (0, beside)].map(|(l, p)| ask_on(context, map, l, &p, &up)[0])
        };
        assert_eq!(asked(opened.technique.as_ref()), [0.0, 0.0, 1.0, 1.0]);
        let away = Camera { position: DVec3::new(-4.0, -4.0, 0.5), target: DVec3::new(-5.0, -5.0, 0.0), ..two.camera };
        world.set_camera(away);
        opened.build(&world).expect("built anew");
        let widest = built(context, &two, "shadow-map:size=64");
        assert_eq!(asked(opened.technique.as_ref()), asked(widest.as_ref()));
        assert_ne!(asked(widest.as_ref()), [0.0, 0.0, 1.0, 1.0], "the widest sees it too");
        let scene = scenes::point([0.0, 0.0, 3.0], scene);
        let world = World::new(context, &scene).expect("room for the scene");
        let error = open(context, &world, &spec("shadow-map:cascades=2")).map(|_| ()).expect_err("a point light");
        let error = error.to_string();
        assert!(
            error.starts_with("refused: needs directional lights alone") && error.contains("cascades=2"),
            "{error}"
        );
    });
}

#[test]
fn sixteen_bits_are_half_the_bytes() {
    gpu_test("sixteen_bits_are_half_the_bytes", |context| {
        let mut scene = scenes::directional("bytes", [0.0, 0.0, -1.0], Vec::new());
        scene.meshes = plates();
        let bytes = |text: &str| built(context, &scene, text).inspect().facts().expect("facts").bytes_resident;
        assert_eq!(bytes("shadow-map:size=200"), 4 * 200 * 200);
        assert_eq!(bytes("shadow-map:size=200,bits=16"), 2 * 200 * 200);
    });
}

/// A size that exceeds the device's images is refused with the limit's name. A filter too wide for the faces of a point light is an error
/// that says what fits.
#[test]
fn what_does_not_fit_is_one_line() {
    gpu_test("shadow_map::what_does_not_fit_is_one_line", |context| {
        let mut scene = scenes::directional("large", [0.0, 0.0, -1.0], Vec::new());
        scene.meshes = plates();
        let error = |scene: &Scene, text: &str| {
            let world = World::new(context, scene).expect("room for the scene");
            open(context, &world, &spec(text)).map(|_| ()).expect_err(text)
        };
        let limit = context.features().max_image_dimension_2d;
        if limit < 16384 {
            let refused = error(&scene, "shadow-map:size=16384");
            let words = format!("needs maxImageDimension2D of at least 16384 (this device has {limit})");
            assert!(matches!(&refused, Error::Refused(_)) && refused.to_string().contains(&words), "{refused}");
        } else {
            crate::support::skipped("shadow_map: a size past the limit", "this device has maps of 16384 texels");
        }
        let scene = scenes::point([0.0, 0.0, 3.0], scene);
        let refused = error(&scene, "shadow-map:size=39,filter=9").to_string();
        assert!(refused.contains("of size 39") && refused.contains("a size of 40 or more"), "{refused}");
        built(context, &scene, "shadow-map:size=40,filter=9");
        let refused = error(&scene, "shadow-map:size=3").to_string();
        assert!(refused.contains("a size of 4 or more"), "{refused}");
    });
}

/// More maps than fit in one vkCmdUpdateBuffer: each light is shadowed as if it were alone. If no image holds all maps, they are refused
/// with the limit's name.
#[test]
fn maps_of_many_lights() {
    gpu_test("shadow_map::maps_of_many_lights", |context| {
        let mut scene = scenes::directional("many", [0.0, 0.0, -1.0], Vec::new());
        scene.meshes = plates();
        let mut random = scenes::Random::new(17);
        let lamp = |_| scenes::point(random.point(-2.0, 2.0).map(f64::from), scene.clone()).lights[0];
        scene.lights = (0..80).map(lamp).collect();
        assert!(scene.map_count() * size_of::<Map>() > 65536, "all travel in one");
        let points: Vec<_> = scene.meshes.iter().flat_map(|mesh| points_of(mesh, 40)).collect();
        let together = built(context, &scene, "shadow-map:size=16");
        let mut differ = 0;
        for light in [0, 1, 70, 71, 72, 79] {
            let alone = Scene { lights: vec![scene.lights[light]], ..scene.clone() };
            let alone = ask(context, built(context, &alone, "shadow-map:size=16").as_ref(), 0, &points);
            assert_eq!(ask(context, together.as_ref(), light, &points), alone, "light {light}");
            differ += usize::from(alone.contains(&0.0) && alone.contains(&1.0));
        }
        assert!(differ > 3, "lights without shadows");
        // A sixteenth of the limit: an image holds 256 maps, but not 480.
        let size = context.features().max_image_dimension_2d / 16;
        let world = World::new(context, &scene).expect("room for the scene");
        let refused =
            open(context, &world, &spec(&format!("shadow-map:size={size}"))).map(|_| ()).expect_err("too many");
        let words = format!("for 480 opaque maps of {size} × {size} texels");
        assert!(matches!(&refused, Error::Refused(_)) && refused.to_string().contains(&words), "{refused}");
        assert!(refused.to_string().contains("maxImageDimension2D"), "{refused}");
    });
}
