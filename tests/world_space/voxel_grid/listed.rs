//! `cell=triangles`: lists equal their twin, and rays hit the same triangles as in f64, up to rounding.

use super::{PLAIN, Settings, all, built, place, shapes, triangles};
use crate::support::scenes::{self, Random, cuboid, directional};
use crate::support::{ask, gpu_test, some, spec};
use glam::DVec3;
use gobo::gpu::Context;
use gobo::grid::Voxelizer;
use gobo::query::{PointBatch, Query};
use gobo::reference::truth::{Casters, surface_points};
use gobo::reference::twin::lists::lists;
use gobo::scene::{Light, LightKind, Mesh, Scene, View};
use gobo::technique::{Opened, Technique, VoxelGrid, open};
use gobo::world::World;

const LISTED: Settings = Settings { voxelizer: Voxelizer::Listed, ..PLAIN };

fn mesh(triangles: &[[[f32; 3]; 3]]) -> Mesh {
    let positions = triangles.as_flattened().to_vec();
    let triangles = (0..triangles.len() as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    Mesh { name: "triangles".into(), positions, triangles, albedo: [0.5; 3], solid: false, alpha: None }
}

/// Returns a square of side `side` at (x, y) and a height, with `parts` squares per side.
fn tiles([x, y]: [f32; 2], height: f32, side: f32, parts: u32) -> Mesh {
    let step = side / parts as f32;
    let corner = |i: u32, j: u32| [x + i as f32 * step, y + j as f32 * step, height];
    let quad = |i: u32, j: u32| {
        let [a, b, c, d] = [corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)];
        [[a, b, c], [a, c, d]]
    };
    mesh(&(0..parts * parts).flat_map(|i| quad(i % parts, i / parts)).collect::<Vec<_>>())
}

/// Side of a scene in whose grid of 64 each voxel is 1/32 wide and begins at a multiple of 1/32.
const WIDE: f32 = 62.0 / 32.0;

/// Hard cases, in which triangle edges and planes coincide with voxel faces: plates within voxel faces, triangles that share sides and
/// corners, many copies of one triangle, many around one corner, slivers, degenerate triangles.
fn adversarial() -> Scene {
    let mut random = Random::new(21);
    let fan = (0..200).map(|i| {
        let at = |i: i32| {
            let (sin, cos) = (i as f32 * std::f32::consts::TAU / 200.0).sin_cos();
            [1.5 + 0.3 * cos, 1.5 + 0.3 * sin, 0.45]
        };
        [[1.5, 1.5, 0.5], at(i), at(i + 1)]
    });
    let same = [[0.3, 1.4, 0.3], [0.6, 1.45, 0.35], [0.4, 1.7, 0.9]];
    let slivers = (0..60).map(|i| {
        let (a, b) = (random.point(0.1, 1.8), random.point(0.1, 1.8));
        let thin = 10f32.powi(-2 - i % 6);
        [a, b, [b[0] + thin, b[1], b[2] - thin]]
    });
    let slivers: Vec<_> = slivers.collect();
    let flat = (0..20).map(|i| {
        let (a, b) = (random.point(0.1, 1.8), random.point(0.1, 1.8));
        if i % 2 == 0 { [a, b, a] } else { [a, [0, 1, 2].map(|i| 0.5 * (a[i] + b[i])), b] }
    });
    let flat: Vec<_> = flat.collect();
    let meshes = vec![
        tiles([0.0; 2], 0.0, WIDE, 8),
        tiles([0.25; 2], 1.0, 1.0, 8),
        tiles([WIDE - 0.125; 2], WIDE, 0.125, 1),
        cuboid([1.0, 0.25, 0.5], [1.5, 0.5, 0.75]),
        mesh(&fan.collect::<Vec<_>>()),
        mesh(&[same; 600]),
        mesh(&slivers),
        mesh(&flat),
    ];
    let mut scene = Scene { meshes, ..directional("adversarial", [0.0, 0.0, -1.0], Vec::new()) };
    let towards = [[-1.0, 0.0, 0.0], [1.0, 1.0, -1.0], [0.0, 1.0, -1.0], [0.4, 0.35, -0.8], [1e-5, -1e-7, -1.0]];
    let direction = |d: [f64; 3]| LightKind::Directional { direction: DVec3::from(d).normalize() };
    let places = [[0.5, 0.75, 1.5], [1.0, 1.0, 2.0], [0.3, 1.2, 30.0]].map(DVec3::from);
    let kinds = towards.map(direction).into_iter().chain(places.map(|position| LightKind::Point { position }));
    scene.lights.extend(kinds.map(light));
    scene
}

fn light(kind: LightKind) -> Light {
    Light { kind, radiance: [1.0; 3], radius: f64::INFINITY }
}

fn words(opened: &Opened<VoxelGrid>) -> (Vec<u64>, Vec<u32>) {
    (opened.technique.grid().bits().expect("read"), opened.technique.grid().listed().expect("read"))
}

/// Bits and lists equal the twin's word for word, in every build, in whatever order the threads run.
#[test]
fn lists_equal_their_twin() {
    if crate::support::is_costly("lists_equal_their_twin") {
        return;
    }
    gpu_test("lists_equal_their_twin", |context| {
        for scene in all().into_iter().chain([adversarial()]) {
            for size in some([64, 256], 1) {
                let (world, mut opened) = built(context, &scene, Settings { size, ..LISTED });
                let at = place(&opened.technique);
                let among = triangles(&scene).into_iter().map(|t| t.map(|corner| at.voxels(corner)));
                let (bits, expected) = lists(among, size);
                let first = words(&opened);
                assert!(first.0 == bits.words, "{}, size {size}: bits", scene.name);
                assert!(first.1 == expected, "{}, size {size}: {} words", scene.name, expected.len());
                let totals = opened.technique.grid().list_totals().expect("it has lists");
                let used = bits.words[..(size / 4).pow(3) as usize].iter().map(|word| word.count_ones()).sum::<u32>();
                assert_eq!(totals.voxels, used, "{}", scene.name);
                opened.rebuild(&world).expect("built again");
                assert!(words(&opened) == first, "{}, size {size}: another build", scene.name);
            }
        }
    });
}

/// Returns whether a box, whose sides are multiples of a sixteenth of a voxel, contains a position in that voxel.
fn has(word: u32, place: DVec3) -> bool {
    (0..3).all(|i| {
        let [last, before] = [word >> (5 * i) & 15, word >> (15 + 5 * i) & 15].map(f64::from);
        (15.0 - before..=last + 1.0).contains(&(16.0 * place[i]))
    })
}

/// For random points of every triangle, the list of the point's voxel in f64 contains the triangle, however thin, and the point lies in
/// both the triangle's box and the list's box.
#[test]
fn no_triangle_is_missing() {
    gpu_test("no_triangle_is_missing", |context| {
        let mut random = Random::new(17);
        for scene in [adversarial(), shapes::soup(), shapes::wires(true)] {
            let (_, opened) = built(context, &scene, LISTED);
            let (at, (bits, lists)) = (place(&opened.technique), words(&opened));
            let origin = DVec3::from(at.origin.map(f64::from));
            for (i, triangle) in (0..).zip(triangles(&scene)) {
                let [a, b, c] = triangle.map(|corner| DVec3::from(corner.map(f64::from)));
                if (b - a).cross(c - a).length() < 1e-9 {
                    continue;
                }
                for _ in 0..40 {
                    let [mut u, mut v] = [(); 2].map(|()| f64::from(random.bits() % 1000) / 999.0);
                    if u + v > 1.0 {
                        (u, v) = (1.0 - u, 1.0 - v);
                    }
                    let p = (a + (b - a) * u + (c - a) * v - origin) * f64::from(at.per_unit);
                    let [x, y, z] = p.to_array().map(|c| c.floor() as usize);
                    let (brick, bit) = ((z / 4 * 16 + y / 4) * 16 + x / 4, x % 4 + 4 * (y % 4) + 16 * (z % 4));
                    let below = (bits[brick] & ((1 << bit) - 1)).count_ones();
                    let start = lists[brick] as usize + 2 * below as usize;
                    let list = &lists[lists[start] as usize..lists[start + 2] as usize];
                    let listed = list.chunks_exact(2).find(|listed| listed[1] == i);
                    let boxes = [Some(lists[start + 1]), listed.map(|listed| listed[0])];
                    let is_there = boxes.into_iter().all(|listed| listed.is_some_and(|listed| has(listed, p.fract())));
                    assert!(bits[brick] >> bit & 1 == 1 && is_there, "{}: {triangle:?} at {p}", scene.name);
                }
            }
        }
    });
}

/// Meshes that moved away leave nothing behind, even when lists grow.
#[test]
fn moved_lists_are_new_lists() {
    gpu_test("moved_lists_are_new_lists", |context| {
        let scene = adversarial();
        let (mut wide, mut low) = (scene.clone(), scene.clone());
        for (i, mesh) in low.meshes.iter_mut().enumerate() {
            mesh.positions.iter_mut().for_each(|p| p[i % 3] *= 0.4);
        }
        for mesh in &mut wide.meshes {
            mesh.positions.iter_mut().for_each(|p| *p = [p[0], 1.9 * p[2], p[1]]);
        }
        let (mut world, mut opened) = built(context, &scene, LISTED);
        for moved in [&wide, &low, &scene] {
            world.replace(moved).expect("as many of all");
            opened.build(&world).expect("built");
            let (_world, fresh) = built(context, moved, LISTED);
            assert!(words(&opened) == words(&fresh), "{}", moved.name);
            let points = shapes::about(moved, 500);
            let [moved, fresh] = [&opened, &fresh].map(|of| ask(context, of.technique.as_ref(), 0, &points));
            assert!(moved == fresh);
        }
    });
}

/// Numbers of points queried, of wrong look-ups, and of points within the resolution.
#[derive(Debug, Default)]
struct Counted {
    asked: usize,
    wrong: usize,
    within: usize,
}

/// Compares look-ups at points in space and on surfaces: none beyond the resolution may be wrong. Surfaces that the light just grazes
/// receive none, and do not count.
fn compared(context: &Context, scene: &Scene, technique: &VoxelGrid, light: usize, points: &[[f32; 3]]) -> Counted {
    let casters = Casters::new(scene);
    let (resolution, kind) = (technique.inspect().resolution()[0], scene.lights[light].kind);
    let mut counted = Counted::default();
    let mut count = |point: DVec3, cosine: f64, lit: bool, within: bool, answer: f32| {
        let wrong = lit != (answer > 0.5);
        assert!(!wrong || within, "{}, {kind:?} at {point}, cosine {cosine}: {answer}", scene.name);
        if cosine.abs() < 1e-6 {
            return;
        }
        counted.asked += 1;
        counted.wrong += usize::from(wrong);
        counted.within += usize::from(within);
    };
    for (point, answer) in points.iter().zip(ask(context, technique, light, points)) {
        let at = DVec3::from(point.map(f64::from));
        count(at, 1.0, casters.unblocked(light, at), casters.in_boundary(light, &resolution, at), answer);
    }
    let camera = View::camera(&scene.camera, scene, [320, 180]);
    let surface = surface_points(&casters, scene, light, &camera, 1500);
    let points: Vec<[f32; 3]> = surface.iter().map(|p| p.position.as_vec3().into()).collect();
    let facing = |p: &gobo::reference::truth::SurfacePoint| p.facing(scene.lights[light].towards(p.position));
    let normals: Vec<[f32; 3]> = surface.iter().map(|p| facing(p).as_vec3().into()).collect();
    let query = Query::of_lights(context, &[PointBatch { light, points: &points, normals: &normals }]).expect("room");
    for (p, answer) in surface.iter().zip(query.ask(&technique.answer()).expect("answered")) {
        let within = casters.in_surface_boundary(light, &resolution, p.position, facing(p));
        let cosine = p.normal.dot(scene.lights[light].towards(p.position));
        count(p.position, cosine, casters.unblocked(light, p.position), within, answer);
    }
    counted
}

/// All but one in ten thousand random points are right, and hardly any is within the resolution.
#[test]
fn rays_meet_what_the_truth_meets() {
    gpu_test("rays_meet_what_the_truth_meets", |context| {
        let mut all_of_them = Counted::default();
        for mut scene in [adversarial(), shapes::houses(), shapes::soup(), shapes::extremes(), shapes::wires(true)] {
            if scene.lights.len() == 1 {
                scene.lights.push(light(LightKind::Point { position: DVec3::new(0.1, -0.7, 0.8) }));
            }
            for size in some([64, 256], 1) {
                let (_world, opened) = built(context, &scene, Settings { size, ..LISTED });
                for light in 0..scene.lights.len() {
                    let points = shapes::about(&scene, 1500);
                    let counted = compared(context, &scene, &opened.technique, light, &points);
                    println!("{}, {size}, {:?}: {counted:?}", scene.name, scene.lights[light].kind);
                    all_of_them.asked += counted.asked;
                    all_of_them.wrong += counted.wrong;
                    all_of_them.within += counted.within;
                }
            }
        }
        let Counted { asked, wrong, within } = all_of_them;
        println!("{all_of_them:?}");
        assert!(asked > 20_000 && wrong * 10_000 <= asked && within * 500 <= asked, "{all_of_them:?}");
    });
}

/// Look-ups are also right at points on vertices, on edges, in triangle planes and on voxel faces, under lights along axes and diagonals.
#[test]
fn ties_are_right_too() {
    gpu_test("ties_are_right_too", |context| {
        let scene = adversarial();
        let (_world, opened) = built(context, &scene, LISTED);
        let mut random = Random::new(3);
        let points: Vec<_> = (0..1500).map(|_| [0; 3].map(|_| (random.bits() % 63) as f32 / 32.0)).collect();
        for light in 0..scene.lights.len() {
            let counted = compared(context, &scene, &opened.technique, light, &points);
            println!("{:?}: {counted:?}", scene.lights[light].kind);
        }
        // No ray gets through a plate of many triangles, not even along their edges and through their vertices.
        let under = |i: u32| [0.25 + (i % 65) as f32 / 64.0, 0.25 + (i / 65 % 65) as f32 / 64.0, 0.96875];
        let points: Vec<_> = (0..65 * 65).map(under).collect();
        let answers = ask(context, opened.technique.as_ref(), 0, &points);
        assert!(answers.iter().all(|answer| *answer == 0.0));
    });
}

/// A closed ball of triangles is light-tight: from inside, every point is dark in every direction.
#[test]
fn a_closed_ball_is_tight() {
    gpu_test("a_closed_ball_is_tight", |context| {
        const RINGS: u32 = 40;
        let place = |ring: u32, step: u32| {
            let (polar, around) = (ring as f32 / RINGS as f32, (step % RINGS) as f32 / RINGS as f32);
            let ((sin, cos), (y, x)) =
                ((polar * std::f32::consts::PI).sin_cos(), (around * std::f32::consts::TAU).sin_cos());
            [sin * x, sin * y, cos]
        };
        let quad = |i: u32| {
            let (ring, step) = (i / RINGS, i % RINGS);
            let [a, b] = [place(ring, step), place(ring, step + 1)];
            let [c, d] = [place(ring + 1, step + 1), place(ring + 1, step)];
            [[a, b, c], [a, c, d]]
        };
        let ball = mesh(&(0..RINGS * RINGS).flat_map(quad).collect::<Vec<_>>());
        let mut scene = Scene { meshes: vec![ball], ..directional("ball", [0.3, 0.5, -0.7], Vec::new()) };
        scene.lights.push(light(LightKind::Point { position: DVec3::new(0.7, 0.9, 1.1) }));
        let (_world, opened) = built(context, &scene, LISTED);
        let mut random = Random::new(8);
        // Points inside the ball, each opposite one of its corners, so that some rays towards the light pass through corners.
        let corners = scene.meshes[0].positions.iter().map(|p| p.map(|c| -0.5 * c));
        let points: Vec<_> = corners.chain((0..20_000).map(|_| random.point(-0.55, 0.55))).collect();
        for light in 0..2 {
            let answers = ask(context, opened.technique.as_ref(), light, &points);
            assert!(answers.iter().all(|answer| *answer == 0.0), "light {light}");
        }
    });
}

/// An unsupported combination is refused in one line that says what is supported.
#[test]
fn what_does_not_go_with_triangles_is_refused() {
    gpu_test("what_does_not_go_with_triangles_is_refused", |context| {
        let world = World::new(context, &shapes::houses()).expect("room for the scene");
        for (with, words) in [
            ("march=steps", "cell=triangles,march=steps: steps and cones ask for whole voxels"),
            ("march=cone", "cell=triangles,march=cone: steps and cones ask for whole voxels"),
            ("path=raster", "refused: needs path=compute for cell=triangles"),
        ] {
            let spec = spec(&format!("voxel-grid:cell=triangles,{with}"));
            let refused = open(context, &world, &spec).map(|_| ()).expect_err(with).to_string();
            assert!(refused.starts_with(words) && !refused.contains('\n'), "{refused}");
        }
    });
}

/// If nothing opaque is in the way, smoke and hair absorb as much as among solid voxels.
#[test]
fn smoke_stands_behind_triangles() {
    gpu_test("smoke_stands_behind_triangles", |context| {
        let scene = Scene { particles: scenes::random().particles, ..shapes::houses() };
        let points = shapes::about(&scene, 2000);
        let of = |settings: Settings| ask(context, built(context, &scene, settings).1.technique.as_ref(), 0, &points);
        let (solid, listed) = (of(PLAIN), of(LISTED));
        assert!(solid.iter().zip(&listed).all(|(solid, listed)| *solid == 0.0 || solid == listed));
        let casters = Casters::new(&scene);
        for (point, answer) in points.iter().zip(&listed) {
            let blocked = !casters.unblocked(0, DVec3::from(point.map(f64::from)));
            assert!(!blocked || *answer == 0.0, "{point:?}: {answer}");
        }
        let thin = listed.iter().filter(|answer| (0.01..0.99).contains(*answer)).count();
        assert!(thin > 20 && listed.iter().filter(|answer| **answer == 0.0).count() > 20, "{thin}");
    });
}
