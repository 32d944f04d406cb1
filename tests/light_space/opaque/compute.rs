//! `opaque=compute`: the words of the maps against their twin, for triangles of every kind and for lists that are too short; both ways of
//! drawing against each other; refusals.

use crate::opaque::{lights, normals_of, plates, points_of};
use crate::support::{ask_on, gpu_test, opened, ran, scenes, some, spec};
use glam::DVec3;
use gobo::Error;
use gobo::gpu::Context;
use gobo::maps::{Maps, OpaqueMaps, OpaqueWay, opaque_corner};
use gobo::reference::twin::opaque::draw;
use gobo::scene::{Light, LightKind, Mesh, Scene};
use gobo::technique::{Opened, ShadowMap, Technique, open};
use gobo::world::World;

type Corners = [[f32; 3]; 3];

pub fn mesh(triangles: &[Corners]) -> Mesh {
    Mesh {
        name: "triangles".into(),
        positions: triangles.iter().flatten().copied().collect(),
        triangles: (0..triangles.len() as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect(),
        albedo: [0.5; 3],
        solid: false,
        alpha: None,
    }
}

/// Returns small, medium, large and thin triangles around the origin, some sharing edges.
fn random_triangles(seed: u64) -> Vec<Corners> {
    let mut random = scenes::Random::new(seed);
    let mut all: Vec<Corners> = Vec::new();
    for i in 0..400 {
        let [at, mut first, mut second] = [(); 3].map(|()| random.point(-1.0, 1.0));
        let half = [0.02, 0.1, 0.6, 3.0][i % 4];
        if i % 5 == 0 {
            // Thin: its corners are nearly collinear.
            let thin = [1e-6, 1e-4, 1e-2, 0.0][i / 5 % 4];
            second = [0, 1, 2].map(|c| 0.7 * first[c] + thin * second[c]);
        }
        (first, second) = (first.map(|c| c * half), second.map(|c| c * half));
        let corner = |by: [f32; 3]| [0, 1, 2].map(|c| 2.0 * at[c] + by[c]);
        all.push([corner([0.0; 3]), corner(first), corner(second)]);
    }
    // A folded strip with shared edges.
    let corner = |i: i32, side: f32| [0.3 * i as f32 - 2.0, side, if i % 2 == 0 { 0.4 } else { 0.9 }];
    for i in 0..12 {
        all.push([corner(i, -0.5), corner(i + 1, -0.5), corner(i, 0.6)]);
        all.push([corner(i + 1, -0.5), corner(i + 1, 0.6), corner(i, 0.6)]);
    }
    all
}

/// Triangles around and behind lights at the origin: clipped by the near plane, huge, edge-on, degenerate to a line or a point, coincident.
fn adversarial() -> Vec<Corners> {
    let [a, b, c] = [[0.3, 0.1, 0.2], [0.31, 0.1, 0.2], [0.3, 0.12, 0.21]];
    vec![
        [[-4.0, -4.0, -1.0], [4.0, -4.0, -1.0], [0.0, 4.0, 6.0]],
        [[-1e4, -1e4, 0.3], [1e4, -1e4, 0.3], [0.0, 1e4, 0.3]],
        [[-1e4, 0.1, -1e4], [1e4, 0.1, 1e4], [1e4, 0.2, -1e4]],
        [[-50.0, -2.0, -50.0], [60.0, -2.0, 50.0], [-1.0, -2.0, 70.0]],
        [[1.0, 2.0, 6.0], [1.0, 2.0, -1.0], [1.5, 2.0, 6.0]],
        [a, a, a],
        [a, a, b],
        [a, b, c],
        [a, b, c],
        [c, b, a],
        [[-2.0, 0.0, 0.5], [2.0, 0.0, 0.5], [2.0, 1e-5, 0.5]],
        [[0.0, 0.0, 0.0], [1e-5, 0.0, 0.0], [0.0, 1e-5, 0.0]],
    ]
}

/// Builds a shadow map of that spec, and reads its depths.
fn depths(context: &Context, scene: &Scene, text: &str) -> (Box<ShadowMap>, Vec<f32>) {
    let world = World::new(context, scene).expect("room for the scene");
    let map = opened(ShadowMap::new(context, &world, &spec(text).settings()), text);
    let mut opened = Opened::new(context, Box::new(map), true);
    opened.build(&world).expect("built");
    let depths = opened.technique.image().read().expect("the depths");
    (opened.technique, depths)
}

/// Returns the texels of one map.
fn of_map(technique: &ShadowMap, depths: &[f32], map: usize) -> Vec<f32> {
    let view = technique.inspect().maps()[map].opaque;
    let [x, y] = opaque_corner(technique.image(), [view.width, view.height], map as u32);
    let across = technique.image().size()[0];
    (0..view.height)
        .flat_map(|row| &depths[((y + row) * across + x) as usize..][..view.width as usize])
        .copied()
        .collect()
}

/// Compares each texel with the twin, and returns the number of texels that hold a depth.
fn compare(what: &str, technique: &ShadowMap, depths: &[f32], triangles: &[Corners]) -> usize {
    let mut drawn = 0;
    for (map, views) in technique.inspect().maps().iter().enumerate() {
        let (found, twin) = (of_map(technique, depths, map), draw(&views.opaque, triangles));
        let differ: Vec<_> = (0..twin.len()).filter(|i| found[*i].to_bits() != twin[*i].to_bits()).collect();
        let first = differ.first().map(|i| (*i, found[*i], twin[*i]));
        assert!(differ.is_empty(), "{what}, map {map}: {} of {} differ, {first:?}", differ.len(), twin.len());
        drawn += twin.iter().filter(|depth| **depth < 1.0).count();
    }
    drawn
}

fn of_light(light: &Scene, triangles: &[Corners]) -> Scene {
    Scene { meshes: vec![mesh(triangles)], ..light.clone() }
}

#[test]
fn words_equal_their_twin() {
    gpu_test("opaque_compute::words_equal_their_twin", |context| {
        for (seed, light) in (1..).zip(some(lights(&[90.0, 40.0, 3.0], DVec3::ZERO), 5)) {
            for (size, filter) in some([(96, 1), (73, 9), (300, 3)], 2) {
                let text = format!("shadow-map:opaque=compute,size={size},filter={filter}");
                for triangles in [random_triangles(seed), adversarial()] {
                    let (technique, depths) = depths(context, &of_light(&light, &triangles), &text);
                    let what = format!("{text}, {:?}, {} triangles", light.lights[0].kind, triangles.len());
                    let drawn = compare(&what, &technique, &depths, &triangles);
                    println!("{what}: {drawn} texels");
                    assert!(drawn > 0, "{what}: nothing is drawn");
                }
            }
        }
    });
}

/// Ten layers of triangles that cover the map, with an initial list for two: triangles without room are drawn all the same, and the next
/// build has room for all. The words equal the twin's both times.
#[test]
fn a_list_that_is_too_short_loses_nothing() {
    gpu_test("opaque_compute::a_list_that_is_too_short_loses_nothing", |context| {
        let layers = |i: u16| {
            let z = 0.02 * f32::from(i);
            [[-4.0 + z, -4.0, z], [4.0, -3.0 - z, 0.3 - z], [0.5, 4.0, 0.5 * z]]
        };
        let triangles: Vec<_> = (0..10).map(layers).collect();
        let world = World::new(context, &of_light(&lights(&[70.0], DVec3::ZERO)[0], &triangles)).expect("room");
        let way = OpaqueMaps { size: 256, ..OpaqueMaps::shared(Some(OpaqueWay::Compute)) };
        let mut maps = Maps::with_opaque(context, &world, 8, way).expect("room for the maps");
        let mut bytes = vec![maps.opaque_bytes_transient()];
        for grows in [true, false] {
            let frame = ran(context, |commands| maps.record(commands, &world).expect("its lights"));
            assert_eq!(maps.settle(frame, false).expect("read"), grows);
            bytes.push(maps.opaque_bytes_transient());
            let found: Vec<f32> = maps.opaque_image().read().expect("the depths");
            let twin = draw(&maps.all()[0].opaque, &triangles);
            let apart = |(a, b): &(&f32, &f32)| a.to_bits() != b.to_bits();
            let differ = found.iter().zip(&twin).filter(apart).count();
            let drawn = twin.iter().filter(|depth| **depth < 1.0).count();
            assert!(differ == 0 && drawn > 10_000, "{differ} differ of {drawn}");
        }
        assert!(bytes[0] < bytes[1] && bytes[1] == bytes[2], "{bytes:?}");
    });
}

/// Both ways give the same look-ups, except where an edge passes a texel's centre or the rasterizer's grid is coarser.
#[test]
fn both_ways_draw_the_same_shadows() {
    gpu_test("opaque_compute::both_ways_draw_the_same_shadows", |context| {
        for mut scene in lights(&[60.0], DVec3::ZERO) {
            scene.meshes = plates();
            let on = |mesh: &Mesh| {
                let points = points_of(mesh, 1500);
                let normals = normals_of(&scene, mesh, &points);
                points.into_iter().zip(normals).collect::<Vec<_>>()
            };
            let (points, normals): (Vec<_>, Vec<_>) = scene.meshes.iter().flat_map(on).unzip();
            let parallel = matches!(scene.lights[0].kind, LightKind::Directional { .. });
            let [raster, compute] = ["raster", "compute"].map(|way| {
                let world = World::new(context, &scene).expect("room for the scene");
                let text = format!("shadow-map:opaque={way}");
                let mut technique = opened(open(context, &world, &spec(&text)), &text);
                let passes = technique.build(&world).expect("built").passes;
                let timed = context.features().timestamp_valid_bits != 0;
                let labels = passes.iter().filter(|pass| pass.name.starts_with("maps.opaque")).count();
                assert_eq!(
                    labels,
                    if !timed {
                        0
                    } else if way == "raster" {
                        // The maps of spot lights and of a point light's faces may not see everything: another pass first determines what
                        // they draw.
                        if parallel { 1 } else { 2 }
                    } else {
                        3
                    },
                    "{way}"
                );
                ask_on(context, technique.technique.as_ref(), 0, &points, &normals)
            });
            let differ = raster.iter().zip(&compute).filter(|(a, b)| a != b).count();
            let dark = compute.iter().filter(|answer| **answer == 0.0).count();
            println!("{:?}: {differ} of {} differ, {dark} dark", scene.lights[0].kind, points.len());
            assert!(250 * differ <= points.len() && dark > 200, "{:?}: {differ}, {dark}", scene.lights[0].kind);
        }
    });
}

/// Many maps in one dispatch, some of which see nothing: each equals its twin, and the six maps of a light with everything behind it are
/// empty.
#[test]
fn each_of_many_maps_is_its_own() {
    gpu_test("opaque_compute::each_of_many_maps_is_its_own", |context| {
        let mut random = scenes::Random::new(29);
        let mut scene = scenes::directional("many", [0.0, 0.0, -1.0], Vec::new());
        let lamp = |_| scenes::point(random.point(-2.0, 2.0).map(f64::from), scene.clone()).lights[0];
        let lamps: Vec<Light> = (0..20).map(lamp).collect();
        scene.lights = lamps;
        let triangles = random_triangles(3);
        let (technique, depths) =
            depths(context, &of_light(&scene, &triangles[..200]), "shadow-map:opaque=compute,size=24");
        let drawn = compare("many", &technique, &depths, &triangles[..200]);
        let empty = (0..120).filter(|map| of_map(&technique, &depths, *map).iter().all(|depth| *depth == 1.0)).count();
        println!("{drawn} texels, {empty} empty maps");
        assert!(drawn > 1000, "{drawn}");
        let one = [[[5.0, 0.0, 0.0], [5.0, 1.0, 0.0], [5.0, 0.0, 1.0]]];
        scene.lights.truncate(1);
        let (technique, depths) = depths_of(context, &scene, &one);
        let empty = (0..6).filter(|map| of_map(&technique, &depths, *map).iter().all(|depth| *depth == 1.0)).count();
        assert_eq!(empty, 5, "faces that no triangle meets");
    });
}

fn depths_of(context: &Context, scene: &Scene, triangles: &[Corners]) -> (Box<ShadowMap>, Vec<f32>) {
    depths(context, &of_light(scene, triangles), "shadow-map:opaque=compute,size=64")
}

#[test]
fn sixteen_bits_are_the_rasterizers() {
    gpu_test("opaque_compute::sixteen_bits_are_the_rasterizers", |context| {
        let mut scene = scenes::directional("bits", [0.0, 0.0, -1.0], Vec::new());
        scene.meshes = plates();
        let world = World::new(context, &scene).expect("room for the scene");
        let refused =
            open(context, &world, &spec("shadow-map:bits=16,opaque=compute")).map(|_| ()).expect_err("refused");
        let words = "needs depths of 32 bits (opaque=raster draws those of 16)";
        assert!(matches!(&refused, Error::Refused(_)) && refused.to_string().contains(words), "{refused}");
    });
}
