//! Look-ups: against the twin, lit and shadowed points, and refusals.

use crate::ism::maps::stand;
use crate::ism::{PATHS, built, refusal, scenes};
use crate::support::scenes::{Random, cuboid};
use crate::support::{ask, gpu_test};
use glam::DVec3;
use gobo::Need;
use gobo::gpu::Context;
use gobo::query::{PointBatch, Query};
use gobo::reference::truth::{Casters, SurfacePoint, surface_points};
use gobo::reference::twin::ism::look_up::look_up;
use gobo::scene::{Light, LightKind, Mesh, Resolution, Scene, View};
use gobo::technique::{Ism, Technique};

/// Returns random points around the origin.
fn about(count: usize, reach: f32) -> Vec<[f32; 3]> {
    let mut random = Random::new(21);
    (0..count).map(|_| random.point(-reach, reach)).collect()
}

/// Look-ups in the device's own map equal the twin's, in space and on surfaces, including near the light's plane and on surfaces facing
/// away.
#[test]
fn look_ups_equal_their_twin() {
    gpu_test("ism::look_ups_equal_their_twin", |context| {
        for (scene, size, adaptive) in
            [(scenes::soup(), 32, "on"), (scenes::room(), 64, "off"), (scenes::room(), 64, "on")]
        {
            let ism = built(context, &scene, &format!("ism:points=1024,path=atomic,size={size},adaptive={adaptive}"));
            let radius = ism.points().expect("the points").0.radius;
            let points = about(2000, 3.0);
            let mut random = Random::new(22);
            let surfaces: Vec<_> = points
                .iter()
                .map(|p| {
                    let normal = DVec3::from(random.point(-1.0, 1.0).map(f64::from)).normalize_or(DVec3::Z);
                    SurfacePoint { position: DVec3::from(p.map(f64::from)), normal, closed: true }
                })
                .collect();
            for light in 0..8 {
                let map = ism.atlas().map(light).expect("the map");
                let (origin, normal) = stand(&scene, light);
                let (texels, stand) = ((size, radius), [origin, normal]);
                let in_space = points.iter().map(|p| look_up(&map, texels, stand, *p, None));
                let on_surfaces = points
                    .iter()
                    .zip(&surfaces)
                    .map(|(p, surface)| look_up(&map, texels, stand, *p, Some(surface.normal.as_vec3().to_array())));
                let space = ask(context, ism.as_ref(), light, &points);
                let own = ask_on_surfaces(context, &ism, light, &surfaces);
                // Surfaces that face away are dark, even where the same point in space is lit; if the normals did not arrive, both look-ups
                // would be equal.
                let from = DVec3::from(origin.map(f64::from));
                let along = |way: DVec3, p: &SurfacePoint| way.dot((p.position - from).normalize()) > 1e-3;
                let before = DVec3::from(normal.map(f64::from));
                let answers = space.iter().zip(&own).zip(&surfaces);
                let away: Vec<_> = answers.filter(|(_, p)| along(before, p) && along(p.normal, p)).collect();
                assert!(away.iter().all(|((_, own), _)| **own == 0.0), "light {light}: a surface that turns away");
                assert!(away.iter().any(|((space, _), _)| **space > 0.0), "light {light}: all is dark in space");
                let twin = in_space.chain(on_surfaces);
                let others = space
                    .into_iter()
                    .chain(own)
                    .zip(twin)
                    .filter(|(got, wanted)| {
                        assert!((0.0..=1.0).contains(got));
                        (got - wanted).abs() > 1e-3
                    })
                    .count();
                // Look-ups may differ where a distance equals a texel's up to rounding.
                assert!(others <= 8, "{}, light {light}: {others} of {} answers", scene.name, 2 * points.len());
            }
        }
    });
}

/// A plate between light and points: dark behind it, lit beside and in front of it, on every path.
#[test]
fn a_plate_shadows_what_is_behind_it() {
    gpu_test("ism::a_plate_shadows_what_is_behind_it", |context| {
        let plate = cuboid([-1.0, -1.0, 1.0], [1.0, 1.0, 1.02]);
        let scene = scenes::under("plate", vec![plate], vec![scenes::light(DVec3::ZERO, DVec3::Z)]);
        let points = about(4000, 2.0).into_iter().map(|[x, y, z]| [x, y, z + 2.0]).collect::<Vec<_>>();
        for path in PATHS {
            for (culling, adaptive) in [("on", "on"), ("on", "off"), ("off", "on"), ("off", "off")] {
                let text = format!("ism:points=4096,path={path},culling={culling},adaptive={adaptive}");
                if refusal(context, &scene, &text).is_some() {
                    continue;
                }
                let ism = built(context, &scene, &text);
                let answers = ask(context, ism.as_ref(), 0, &points);
                for (answer, [x, y, z]) in answers.into_iter().zip(&points) {
                    let wide = x.abs().max(y.abs()) / z;
                    if *z > 1.3 && wide < 0.8 {
                        assert_eq!(answer, 0.0, "{text}: behind it at {x}, {y}, {z}");
                    } else if wide > 1.25 || *z < 0.8 {
                        assert_eq!(answer, 1.0, "{text}: beside it at {x}, {y}, {z}");
                    }
                }
            }
        }
    });
}

/// Returns surface points with normals that face the light, as the benchmark uses them.
pub fn on_surfaces(casters: &Casters, scene: &Scene, light: usize, count: usize) -> Vec<SurfacePoint> {
    let camera = View::camera(&scene.camera, scene, [64, 64]);
    let mut points = surface_points(casters, scene, light, &camera, count);
    points.iter_mut().for_each(|p| p.normal = p.facing(scene.lights[light].towards(p.position)));
    points
}

/// Returns the look-ups at points with normals.
pub fn ask_on_surfaces(context: &Context, ism: &Ism, light: usize, points: &[SurfacePoint]) -> Vec<f32> {
    let normals: Vec<[f32; 3]> = points.iter().map(|p| p.normal.as_vec3().to_array()).collect();
    let points: Vec<[f32; 3]> = points.iter().map(|p| p.position.as_vec3().to_array()).collect();
    let asked = PointBatch { light, points: &points, normals: &normals };
    Query::of_lights(context, &[asked]).expect("room").ask(&ism.answer()).expect("asked")
}

/// Lights on either side of a single sheet: all of its points seen at more than 30° are lit, whichever sides are culled. Every side of a
/// box that faces away from its light is dark.
#[test]
fn surfaces_shadow_themselves_from_behind_alone() {
    gpu_test("ism::surfaces_shadow_themselves_from_behind_alone", |context| {
        let up = DVec3::new(0.3, -0.2, 1.0).normalize();
        let (right, ahead) = (up.cross(DVec3::Y).normalize(), up.cross(up.cross(DVec3::Y)).normalize());
        let at = |x: f64, y: f64, z: f64| DVec3::new(3.0, 5.0, -7.0) + x * right + y * ahead + z * up;
        let corner = |i: u32| at([-2.0, 2.0][i as usize & 1], [-2.0, 2.0][i as usize >> 1], 0.0).as_vec3().to_array();
        let sheet = Mesh {
            name: "sheet".into(),
            positions: (0..4).map(corner).collect(),
            triangles: vec![[0, 1, 3], [0, 3, 2]],
            albedo: [0.5; 3],
            solid: false,
            alpha: None,
        };
        let mut random = Random::new(33);
        let mut place = || f64::from(random.between(-1.5, 1.5));
        let lights: Vec<_> = (0..12)
            .map(|i| {
                let above = [1.0, -1.0][i % 2] * [1.5, 0.6, 0.3][i % 3];
                let from = at(place(), place(), above);
                scenes::light(from, at(place(), place(), 0.0) - from)
            })
            .collect();
        // Lights far away, where texels are wider than discs.
        let far = [(6.0, 0.0), (3.0, -3.0), (-9.0, 4.0), (0.0, 5.0)].map(|(x, y)| {
            let from = at(x, y, 0.62 * f64::hypot(x, y));
            scenes::light(from, at(place(), place(), 0.0) - from)
        });
        let lights: Vec<_> = lights.into_iter().chain(far).collect();
        let points: Vec<_> = (0..600).map(|_| at(place(), place(), 0.0)).collect();
        let scene = scenes::under("sheet", vec![sheet], lights);
        let each = |adaptive: &str| {
            ["on", "far", "off"]
                .map(|culling| format!("ism:points=1024,path=atomic,fill=off,culling={culling},adaptive={adaptive}"))
        };
        for text in [each("off"), each("on")].concat() {
            let ism = built(context, &scene, &text);
            let (mut lit, mut all) = (0, 0);
            for (light, of) in scene.lights.iter().enumerate() {
                let slanted = |p: &DVec3| up.dot(of.towards(*p)).abs() > 0.5 && of.shines_on(*p);
                let seen = points.iter().filter(|p| slanted(p)).map(|p| {
                    let normal = up * up.dot(of.towards(*p)).signum();
                    SurfacePoint { position: *p, normal, closed: false }
                });
                let answers = ask_on_surfaces(context, &ism, light, &seen.collect::<Vec<_>>());
                (lit, all) = (lit + answers.iter().filter(|a| **a == 1.0).count(), all + answers.len());
            }
            assert!(all > 1000 && lit == all, "{text}: {lit} of {all} are lit");
        }

        let block = cuboid([-0.5; 3], [0.5; 3]);
        let light = scenes::light(DVec3::new(0.0, 0.0, 2.0), DVec3::NEG_Z);
        let scene = scenes::under("block", vec![block], vec![light]);
        let ism = built(context, &scene, "ism:points=1024,path=atomic,size=32");
        let side = |x: f64, y: f64| SurfacePoint { position: DVec3::new(0.5, x, y), normal: DVec3::X, closed: true };
        let sides: Vec<_> = (0..100).map(|_| side(place() / 3.0, place() / 3.0)).collect();
        assert!(ask_on_surfaces(context, &ism, 0, &sides).iter().all(|a| *a == 0.0), "a side that turns away");
    });
}

/// In a room with a table, look-ups in space and on surfaces agree with rays in f64, except near shadow edges. A shadow edge may be
/// displaced, because the map is coarse and discs extend past their mesh by up to their radius r (about a texel here). So look-ups may be
/// wrong in a band of r plus one and a half texels on either side of an edge, and are hardly ever wrong outside it. The displacement is
/// between 0 and r plus half a texel, half of that on average, so at most a sixth of the look-ups in the band are wrong. Another light's
/// map must be useless, and fewer points and texels must do worse.
#[test]
fn a_room_is_about_what_rays_say() {
    gpu_test("ism::a_room_is_about_what_rays_say", |context| {
        let scene = scenes::room();
        let casters = Casters::new(&scene);
        let space: Vec<_> = about(600, 1.9).into_iter().filter(|p| p[2] > -0.2 || p[2] < -0.8).collect();
        // Errors in space and on surfaces, each light queried in the map of the light `shift` places on.
        let error = |text: &str, shift: usize| {
            let ism = built(context, &scene, text);
            let radius = f64::from(ism.points().expect("the points").0.radius);
            let resolution = ism.inspect().resolution();
            let mut found = [Found::default(); 2];
            for light in 0..scene.lights.len() {
                let asked = (light + shift) % scene.lights.len();
                let of = resolution[scene.first_map(light)];
                // The resolution's reach, widened by a disc's radius at that distance.
                let wider = |at: DVec3| {
                    let texel = of.view_about(at).texel_at(at)[0].length();
                    Resolution { reach_texels: of.reach_texels + radius / texel, ..of }
                };
                for (answer, point) in ask(context, ism.as_ref(), asked, &space).into_iter().zip(&space) {
                    let at = DVec3::from(point.map(f64::from));
                    if scene.lights[light].shines_on(at) && !casters.inside(light, at) {
                        found[0].add(answer, casters.visibility(light, at), casters.in_boundary(light, &wider(at), at));
                    }
                }
                let points = on_surfaces(&casters, &scene, light, 200);
                for (answer, p) in ask_on_surfaces(context, &ism, asked, &points).into_iter().zip(&points) {
                    let truth = casters.visibility(light, p.position);
                    let at = p.position;
                    found[1].add(answer, truth, casters.in_surface_boundary(light, &wider(at), at, p.normal));
                }
            }
            println!("{text}, shifted by {shift}: {found:?}");
            found
        };
        let fine = error("ism:points=8192,path=atomic,adaptive=off", 0);
        let other = error("ism:points=8192,path=atomic,adaptive=off", 1);
        let adaptive = error("ism:points=8192,path=atomic,adaptive=on", 0);
        let coarse = error("ism:points=1024,size=32,path=atomic,adaptive=off", 0);
        for kind in [0, 1] {
            let [fine, other, adaptive, coarse] = [fine, other, adaptive, coarse].map(|found| found[kind]);
            for found in [fine, adaptive] {
                let beyond = found.points - found.near;
                assert!(3 * beyond > found.points, "{found:?}");
                assert!((found.off - found.off_near) / f64::from(beyond) < 0.005, "beyond: {found:?}");
                assert!(found.off_near / f64::from(found.near) < 1.0 / 6.0, "within: {found:?}");
            }
            assert!(other.off > 4.0 * fine.off, "another light's map: {other:?}, not {fine:?}");
            assert!(adaptive.off < fine.off, "where lights choose their points: {adaptive:?}, not {fine:?}");
            assert!(coarse.off > 1.5 * fine.off, "of fewer points and texels: {coarse:?}, not {fine:?}");
        }
    });
}

/// Errors of look-ups.
#[derive(Clone, Copy, Debug, Default)]
struct Found {
    points: u32,
    off: f64,
    near: u32,
    off_near: f64,
}

impl Found {
    fn add(&mut self, answer: f32, truth: f64, is_near: bool) {
        let off = (f64::from(answer) - truth).abs();
        self.points += 1;
        self.off += off;
        if is_near {
            self.near += 1;
            self.off_near += off;
        }
    }
}

/// Nothing casts: everything is lit. Degenerate triangles cast nothing and break nothing.
#[test]
fn nothing_casts_nothing() {
    gpu_test("ism::nothing_casts_nothing", |context| {
        let line = |at: [f32; 3]| Mesh {
            name: "line".into(),
            positions: vec![at, [at[0] + 1.0, at[1], at[2]], [at[0] + 2.0, at[1], at[2]], at],
            triangles: vec![[0, 1, 2], [0, 0, 3]],
            albedo: [0.5; 3],
            solid: false,
            alpha: None,
        };
        let scenes = [
            scenes::under("nothing", Vec::new(), scenes::lights(3)),
            scenes::under("lines", vec![line([0.0; 3]), line([1.0, 2.0, 3.0])], scenes::lights(3)),
        ];
        for scene in &scenes {
            for path in PATHS {
                for adaptive in ["off", "on"] {
                    let text = format!("ism:points=1024,path={path},size=32,adaptive={adaptive}");
                    let ism = built(context, scene, &text);
                    let answers = ask(context, ism.as_ref(), 0, &about(200, 3.0));
                    assert!(answers.iter().all(|answer| *answer == 1.0), "{text} of {}", scene.name);
                }
            }
        }
    });
}

/// A light anywhere on a floor: the floor is not in front of it, however its points are rounded, and shadows nothing above it.
#[test]
fn a_floor_does_not_shadow_its_light() {
    gpu_test("ism::a_floor_does_not_shadow_its_light", |context| {
        let mut random = Random::new(31);
        let up = DVec3::new(0.3, -0.2, 1.0).normalize();
        let (right, ahead) = (up.cross(DVec3::Y).normalize(), up.cross(up.cross(DVec3::Y)).normalize());
        for far in [0.0, 100.0] {
            let at = |x: f64, y: f64, z: f64| far * DVec3::ONE + x * right + y * ahead + z * up;
            let corner =
                |i: u32| at([-2.0, 2.0][i as usize & 1], [-2.0, 2.0][i as usize >> 1], 0.0).as_vec3().to_array();
            let floor = Mesh {
                name: "floor".into(),
                positions: (0..4).map(corner).collect(),
                triangles: vec![[0, 1, 3], [0, 3, 2]],
                albedo: [0.5; 3],
                solid: false,
                alpha: None,
            };
            let mut place = || f64::from(random.between(-1.5, 1.5));
            let lights = (0..8).map(|_| scenes::light(at(place(), place(), 0.0), up)).collect();
            let points: Vec<_> = (0..300).map(|i| at(place(), place(), 0.3 + 0.005 * f64::from(i))).collect();
            let points: Vec<_> = points.iter().map(|p| p.as_vec3().to_array()).collect();
            let scene = scenes::under("floor", vec![floor], lights);
            for path in PATHS {
                for (culling, adaptive) in [("on", "on"), ("on", "off"), ("off", "on"), ("off", "off")] {
                    let text = format!("ism:points=1024,path={path},size=32,culling={culling},adaptive={adaptive}");
                    let ism = built(context, &scene, &text);
                    for light in 0..8 {
                        let lit = ask(context, ism.as_ref(), light, &points).iter().filter(|a| **a == 1.0).count();
                        assert_eq!(lit, points.len(), "{text}, {far} units away, light {light}");
                    }
                }
            }
        }
    });
}

/// An unsupported kind of light, and a device or scene without room: a one-line error names it.
#[test]
fn what_has_no_answer_is_refused() {
    gpu_test("ism::what_has_no_answer_is_refused", |context| {
        let mut scene = scenes::room();
        assert_eq!(refusal(context, &scene, "ism:path=atomic,points=1024"), None);
        let kind = LightKind::Point { position: DVec3::ZERO };
        scene.lights.push(Light { kind, radiance: [1.0; 3], radius: 9.0 });
        let needs = refusal(context, &scene, "ism").expect("a point light");
        assert_eq!(needs, Need::VirtualLights);

        let has = context.features().max_compute_shared_memory_bytes;
        let text = "ism:size=128,path=tiled,points=1024";
        match refusal(context, &scenes::room(), text) {
            Some(needs) => {
                assert!(
                    has < 87360 && needs.to_string().contains("maxComputeSharedMemorySize of at least 87360"),
                    "{needs}"
                )
            }
            None => assert!(has >= 87360, "{has}"),
        }
    });
}

/// A moved world gives the same result as a new one, and its lights do not disturb each other.
#[test]
fn a_moved_world_is_a_new_world() {
    use gobo::technique::Opened;
    use gobo::world::World;
    gpu_test("ism::a_moved_world_is_a_new_world", |context| {
        let mut scene = scenes::room();
        let points = about(500, 1.9);
        for (path, adaptive) in PATHS.into_iter().flat_map(|path| [(path, "on"), (path, "off")]) {
            let text = format!("ism:points=1024,path={path},size=32,adaptive={adaptive}");
            let mut world = World::new(context, &scene).expect("room");
            let ism = Ism::new(context, &world, &crate::ism::spec(&text).settings()).expect("opened");
            let mut opened = Opened::new(context, Box::new(ism), true);
            opened.build(&world).expect("built");
            let before = ask(context, opened.technique.as_ref(), 4, &points);
            scene.lights.rotate_left(1);
            scene.meshes[6].positions.iter_mut().for_each(|p| p[0] += 0.25);
            world.replace(&scene).expect("as many");
            opened.build(&world).expect("built again");
            let new = built(context, &scene, &text);
            for light in [0, 4, 29] {
                let now = ask(context, opened.technique.as_ref(), light, &points);
                assert!(now == ask(context, new.as_ref(), light, &points), "{text}, light {light}");
                assert!(light != 4 || now != before, "{text}: nothing changed");
            }
        }
    });
}

/// Testing normals alone culls points that a light sees and keeps points that it does not see, counted against the exact test.
#[test]
fn facing_by_normals_is_not_exact() {
    gpu_test("ism::facing_by_normals_is_not_exact", |context| {
        let scene: Scene = scenes::room();
        let seen = ["exact", "slide"].map(|facing| {
            let ism = built(context, &scene, &format!("ism:points=4096,path=atomic,adaptive=off,facing={facing}"));
            ism.atlas().seen().expect("counted").into_iter().map(u64::from).sum::<u64>()
        });
        assert!(seen[1] * 10 < seen[0] * 9, "a light on the floor sees no wall's back by its normal: {seen:?}");
    });
}
