//! A world that moves: for every path of every technique, a technique opened earlier gives the same look-ups as one opened for the world as
//! it is now, and nothing is rebuilt without need.

mod alpha;
mod buffers;
mod failed;
mod gathered;
mod lights;
mod lights_gathered;
mod lights_of_buffers;
mod parts;
mod pictured;
mod refused;
mod splats;
mod threads;
mod time;
mod volumes;

use crate::support::scenes::{self, Random};
use crate::support::{all, all_paths, ask, every_path, gpu_test, runs, skipped, some, spec};
use gobo::gpu::{Context, PassTime};
use gobo::query::{Query, QueryKernel};
use gobo::scene::{Light, LightKind, Particle, Scene};
use gobo::technique::{self, Avsm, Built, Lifetime, Name, Opened, Spec, Technique};
use gobo::world::World;

/// Texels per side; not a multiple of the tile size.
const SIZE: &str = "28";

fn world(context: &Context, scene: &Scene) -> World {
    World::new(context, scene).expect("room for the scene")
}

fn opened(context: &Context, world: &World, spec: &Spec) -> Opened {
    crate::support::opened(technique::open(context, world, spec), &spec.short())
}

fn build(opened: &mut Opened, world: &World, what: &str) -> Built {
    opened.build(world).unwrap_or_else(|e| panic!("{what}: {e}"))
}

/// Returns every path, and AVSM's other ways to build curves.
fn specs(test: &str, context: &Context) -> Vec<Spec> {
    let mut specs = every_path(test, context);
    specs.push(spec("avsm:path=binned,resolve=streaming"));
    if all() {
        specs.push(spec("avsm:path=two-pass,storage=packed,skip=off"));
        specs.push(spec("avsm:path=two-pass,resolve=whole"));
        specs.push(spec("psm:path=raster,coverage=tiles,assign=split"));
        specs.push(spec("psm:path=raster,coverage=viewport"));
        specs.extend(every_path(test, context).into_iter().map(|mut spec| {
            spec.set(Name::SKIP, "off");
            spec
        }));
    }
    specs.retain(|spec| spec.entry.lifetime == Lifetime::Frame && runs(test, context, &spec.short()));
    specs.iter_mut().for_each(|spec| spec.set(Name::SIZE, SIZE));
    specs
}

/// Casters over a plate, under a directional light and, amid the casters, a point light.
fn scattered(count: usize, radius: [f32; 2], depth: f32, seed: u64) -> Scene {
    let mut random = Random::new(seed);
    let particles = (0..count)
        .map(|_| {
            let radius = random.between(radius[0], radius[1]);
            Particle { position: random.point(-1.0, 1.0), radius, extinction: depth / (2.0 * radius) }
        })
        .collect();
    let mut scene = scenes::directional("scattered", [0.5, 0.3, -0.81], particles);
    scene.lights.extend(scenes::inside().lights);
    scene.meshes.push(scenes::level(-1.2, 1.5, [0.1, 0.0]));
    scene
}

const COUNT: usize = 200;

/// Tiny casters, far apart: few segments, few tiles.
fn tiny() -> Scene {
    scattered(COUNT, [0.004, 0.01], 0.3, 1)
}

/// The same number of casters, but large and dense: each covers most of a map.
fn large() -> Scene {
    scattered(COUNT, [0.5, 0.9], 0.05, 2)
}

/// Fewer casters than there is room for, in other places.
fn fewer() -> Scene {
    scattered(COUNT / 2, [0.05, 0.4], 0.3, 3)
}

/// The same casters, with every light and the plate moved.
fn lights_moved() -> Scene {
    let mut scene = fewer();
    let kinds = [
        LightKind::Spot {
            position: glam::DVec3::new(2.0, -1.0, 3.0),
            direction: glam::DVec3::new(-2.0, 1.0, -3.0).normalize(),
            cone_degrees: 70.0,
        },
        LightKind::Point { position: glam::DVec3::new(-0.3, 0.2, 2.4) },
    ];
    scene.lights = kinds.map(|kind| Light { kind, radiance: [0.5; 3], radius: f64::INFINITY }).to_vec();
    scene.meshes = vec![scenes::level(-0.1, 0.7, [0.2, -0.3])];
    scene
}

/// No casters except the plate.
fn empty() -> Scene {
    let mut scene = lights_moved();
    scene.particles.clear();
    scene
}

fn points() -> Vec<[f32; 3]> {
    let mut random = Random::new(41);
    (0..1000).map(|_| random.point(-1.4, 1.4)).collect()
}

/// Returns the look-ups at `points` for every light.
fn answers(context: &Context, technique: &dyn Technique, lights: usize, points: &[[f32; 3]]) -> Vec<Vec<f32>> {
    (0..lights).map(|light| ask(context, technique, light, points)).collect()
}

/// Queries with kernels created before the world moved: they read buffers that have grown since.
struct PointBatch(Vec<(Query, QueryKernel)>);

impl PointBatch {
    fn new(context: &Context, technique: &dyn Technique, lights: usize, points: &[[f32; 3]]) -> Self {
        let query = |light| {
            let query = Query::new(context, light, points).expect("room for the points");
            let kernel = query.kernel(&technique.answer()).expect("a kernel");
            (query, kernel)
        };
        Self((0..lights).map(query).collect())
    }

    fn answers(&self) -> Vec<Vec<f32>> {
        let ask = |(query, kernel): &(Query, QueryKernel)| {
            query.query(kernel).expect("asked");
            query.answers().expect("answered")
        };
        self.0.iter().map(ask).collect()
    }
}

fn largest_difference(a: &[Vec<f32>], b: &[Vec<f32>]) -> f32 {
    a.iter().flatten().zip(b.iter().flatten()).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
}

/// Returns whether two builds of the same world give the same bytes. Lists do not: they are summed in the order of capture, which may vary.
fn is_exact(spec: &Spec) -> bool {
    spec.entry.name != "uncompressed"
}

fn bytes(technique: &dyn Technique) -> u64 {
    let facts = technique.inspect().facts().expect("counted");
    facts.bytes_resident + facts.bytes_transient
}

/// Returns whether anything in a scene casts in a technique.
fn casts_in(spec: &Spec, scene: &Scene) -> bool {
    let casts = spec.entry.casts;
    casts.meshes && !scene.meshes.is_empty()
        || casts.particles && !scene.particles.is_empty()
        || casts.strands && !scene.strands.is_empty()
}

/// Takes one technique through all states of its world, and compares it at each with one opened for that state.
#[test]
fn a_world_that_moved_is_a_new_world() {
    if crate::support::is_costly("a_world_that_moved_is_a_new_world") {
        return;
    }
    let name = "a_world_that_moved_is_a_new_world";
    gpu_test(name, |context| {
        let points = points();
        let states = [
            ("large", large()),
            ("fewer, other lights", lights_moved()),
            ("the first lights again", fewer()),
            ("empty", empty()),
            ("tiny again", tiny()),
        ];
        let states = some(states, 2);
        for spec in specs(name, context) {
            let mut world = world(context, &tiny());
            let mut moved = opened(context, &world, &spec);
            build(&mut moved, &world, &spec.short());
            let asked = PointBatch::new(context, moved.technique.as_ref(), 2, &points);
            let small = bytes(moved.technique.as_ref());
            let mut before = asked.answers();
            for (state, scene) in &states {
                let what = format!("{}, {state}", spec.short());
                if !casts_in(&spec, scene) {
                    skipped(name, &format!("{what}: nothing casts"));
                    continue;
                }
                world.replace(scene).expect(&what);
                build(&mut moved, &world, &what);
                let new_world = self::world(context, scene);
                let mut fresh = opened(context, &new_world, &spec);
                build(&mut fresh, &new_world, &what);
                assert_eq!(moved.technique.inspect().maps(), fresh.technique.inspect().maps(), "{what}");
                let (now, expected) = (asked.answers(), answers(context, fresh.technique.as_ref(), 2, &points));
                let difference = largest_difference(&now, &expected);
                assert!(difference <= if is_exact(&spec) { 0.0 } else { 1e-6 }, "{what}: {difference}");
                let [facts, expected] = [&moved, &fresh].map(|o| o.technique.inspect().facts().expect("counted"));
                assert_eq!(facts.counters, expected.counters, "{what}");
                assert!(now != before, "{what}: nothing has changed");
                if *state == "large" {
                    let dark = now[0].iter().filter(|v| **v < 0.2).count();
                    assert!(dark > 100, "{what}: {dark} points are dark");
                    // Paths that store segments, or casters per tile, had to grow.
                    let large = bytes(moved.technique.as_ref());
                    assert!(large > small || !holds_all(&spec, facts.path), "{what}: {large} bytes, as before");
                }
                before = now;
            }
        }
    });
}

/// Returns whether the path stores something for each caster in each texel or tile.
fn holds_all(spec: &Spec, path: &str) -> bool {
    spec.entry.name == "uncompressed" || ["two-pass", "binned", "fused"].contains(&path)
}

/// Compares the curves themselves, with skip=off, because skip=on does not write tiles without casters.
#[test]
fn curves_of_a_world_that_moved() {
    if crate::support::is_costly("curves_of_a_world_that_moved") {
        return;
    }
    let name = "curves_of_a_world_that_moved";
    gpu_test(name, |context| {
        let specs = all_paths().into_iter().filter(|spec| spec.entry.name == "avsm");
        for mut spec in specs.filter(|spec| runs(name, context, &spec.short())) {
            spec.set(Name::SIZE, "24");
            spec.set(Name::SKIP, "off");
            let open = |world: &World| {
                let avsm = crate::support::opened(Avsm::new(context, world, &spec.settings()), &spec.short());
                Opened::new(context, Box::new(avsm), false)
            };
            let curves = |avsm: &Opened<Avsm>| -> Vec<u32> {
                avsm.technique.curves().read(7 * 24 * 24 * 8 * 2).expect("the curves")
            };
            let mut world = world(context, &tiny());
            let mut moved = open(&world);
            moved.build(&world).expect("built");
            for scene in [large(), fewer(), lights_moved()] {
                world.replace(&scene).expect("room for as many");
                moved.build(&world).expect("built");
                let new_world = self::world(context, &scene);
                let mut fresh = open(&new_world);
                fresh.build(&new_world).expect("built");
                assert!(curves(&moved) == curves(&fresh), "{}: other curves", spec.short());
            }
        }
    });
}

/// A world that started without casters has no room for any, yet its lights and meshes move.
#[test]
fn a_world_without_casters_moves() {
    if crate::support::is_costly("a_world_without_casters_moves") {
        return;
    }
    let name = "a_world_without_casters_moves";
    gpu_test(name, |context| {
        let points = points();
        let mut before = fewer();
        before.particles.clear();
        for spec in specs(name, context) {
            let what = spec.short();
            if !casts_in(&spec, &before) {
                skipped(name, &format!("{what}: nothing casts"));
                continue;
            }
            let mut world = world(context, &before);
            let mut moved = opened(context, &world, &spec);
            build(&mut moved, &world, &what);
            world.replace(&empty()).expect(&what);
            build(&mut moved, &world, &what);
            let new_world = self::world(context, &empty());
            let mut fresh = opened(context, &new_world, &spec);
            build(&mut fresh, &new_world, &what);
            let [now, expected] = [&moved, &fresh].map(|o| answers(context, o.technique.as_ref(), 2, &points));
            assert!(now == expected, "{what}");
            assert!(now.iter().flatten().any(|v| *v == 0.0), "{what}: the plate casts no shadow");
        }
    });
}

/// Hair that returns casts shadows again, also in techniques opened while it was absent.
#[test]
fn hair_comes_back() {
    let name = "hair_comes_back";
    gpu_test(name, |context| {
        let points = points();
        let [mut smoke, mut hair] = [scenes::random(), scenes::strands()];
        smoke.particles.truncate(200);
        hair.strands.truncate(200);
        for spec in specs(name, context) {
            let what = spec.short();
            let mut world = world(context, &hair);
            world.replace(&smoke).expect("as many casters");
            let mut moved = opened(context, &world, &spec);
            build(&mut moved, &world, &what);
            world.replace(&hair).expect("as it began");
            build(&mut moved, &world, &what);
            let new_world = self::world(context, &hair);
            let mut fresh = opened(context, &new_world, &spec);
            build(&mut fresh, &new_world, &what);
            let [now, expected] = [&moved, &fresh].map(|o| answers(context, o.technique.as_ref(), 1, &points));
            let difference = largest_difference(&now, &expected);
            assert!(difference <= 1e-5, "{what}: {difference}");
        }
    });
}

/// Before the first build there is nothing to count, which is no error.
#[test]
fn facts_come_before_the_first_build() {
    let name = "facts_come_before_the_first_build";
    gpu_test(name, |context| {
        let world = world(context, &fewer());
        for spec in specs(name, context) {
            let facts = opened(context, &world, &spec).technique.inspect().facts().expect("no counts");
            assert!(!facts.counters.contains_key("culled_casters"), "{}: {:?}", spec.short(), facts.counters);
        }
    });
}

/// The largest number of maps that fits in the commands arrives completely.
#[test]
fn many_lights_move() {
    gpu_test("many_lights_move", |context| {
        let most = 65536 / size_of::<gobo::maps::Map>();
        let mut scene = scenes::nested();
        scene.meshes.clear();
        let light = |i: usize, turn: f64| {
            let angle = turn + i as f64;
            let direction = glam::DVec3::new(angle.cos(), angle.sin(), -1.0).normalize();
            Light { kind: LightKind::Directional { direction }, radiance: [1.0; 3], radius: f64::INFINITY }
        };
        scene.lights = (0..most).map(|i| light(i, 0.0)).collect();
        let mut world = world(context, &scene);
        let spec = spec("avsm:path=binned,size=8");
        let mut moved = opened(context, &world, &spec);
        build(&mut moved, &world, "as many as travel");
        scene.lights = (0..most).map(|i| light(i, 0.4)).collect();
        world.replace(&scene).expect("as many");
        build(&mut moved, &world, "moved");
        let points = points();
        for i in [0, most / 2, most - 1] {
            let alone = Scene { lights: vec![scene.lights[i]], ..scene.clone() };
            let alone_world = self::world(context, &alone);
            let mut alone = opened(context, &alone_world, &spec);
            build(&mut alone, &alone_world, "alone");
            let now = ask(context, moved.technique.as_ref(), i, &points);
            assert!(now == ask(context, alone.technique.as_ref(), 0, &points), "light {i} of {most}");
            assert!(now.iter().any(|v| *v < 0.5), "light {i} casts shadows");
        }
    });
}

fn names(passes: &[PassTime]) -> Vec<&str> {
    passes.iter().map(|p| p.name.as_str()).collect()
}

/// Nothing is built twice for the same world, nor after replacing it with the same.
#[test]
fn an_unchanged_world_takes_no_pass() {
    if crate::support::is_costly("an_unchanged_world_takes_no_pass") {
        return;
    }
    let name = "an_unchanged_world_takes_no_pass";
    gpu_test(name, |context| {
        let timed = context.features().timestamp_valid_bits > 0;
        let scene = fewer();
        for mut spec in specs(name, context) {
            spec.set(Name::SKIP, "on");
            let what = spec.short();
            let mut world = world(context, &scene);
            let mut opened = opened(context, &world, &spec);
            let first = build(&mut opened, &world, &what).passes;
            assert_eq!(first.is_empty(), !timed, "{what}");
            for _ in 0..2 {
                let again = build(&mut opened, &world, &what);
                assert!(again.passes.is_empty() && again.host_ns == 0.0, "{what}: {again:?}");
            }
            world.replace(&scene).expect("the same");
            assert!(build(&mut opened, &world, &what).passes.is_empty(), "{what}");
            // Nothing has moved, so neither the fit nor the order is recomputed.
            let follows =
                |pass: &&str| ["maps.aim", "maps.bounds", "maps.fit"].contains(pass) || pass.starts_with("order.");
            let mut rest = names(&first);
            rest.retain(|pass| !follows(pass));
            let rebuilt = opened.rebuild(&world).expect(&what).passes;
            assert_eq!(names(&rebuilt), rest, "{what}");
            // Techniques outside light space have none of these passes; grids of smoke have opaque maps, but no maps of their own.
            let opaque_alone = ["density-grid", "optical-depth-grid"].contains(&spec.entry.name);
            let fits = opaque_alone || !opened.technique.inspect().maps().is_empty();
            assert_eq!(rest.len() < first.len(), timed && fits, "{what}");
        }
    });
}

/// The six maps of a point light are built by the same passes as another light's single map, and so are the maps of four lights.
#[test]
fn six_maps_cost_one_chain() {
    if crate::support::is_long("six_maps_cost_one_chain") {
        return;
    }
    let name = "six_maps_cost_one_chain";
    gpu_test(name, |context| {
        if context.features().timestamp_valid_bits == 0 {
            return crate::support::skipped(name, "the device has no timestamps");
        }
        let mut one = scenes::random();
        one.meshes.push(scenes::level(-0.9, 2.0, [0.0, 0.0]));
        let with = |lights: Vec<Light>| Scene { lights, ..one.clone() };
        let scenes = [one.clone(), with(scenes::inside().lights), with(scenes::four_lights().lights)];
        for spec in specs(name, context) {
            let passes = scenes.each_ref().map(|scene| {
                let world = world(context, scene);
                let mut opened = opened(context, &world, &spec);
                let built = build(&mut opened, &world, &spec.short());
                let mut passes = names(&built.passes);
                // A directional light's map sees all meshes, so nothing has to be culled.
                passes.retain(|pass| *pass != "maps.opaque_cull");
                passes.join(" ")
            });
            println!("{}: {}", spec.short(), passes[0]);
            assert!(!passes[0].is_empty(), "{}", spec.short());
            assert_eq!(passes[0], passes[1], "{}: a point light", spec.short());
            assert_eq!(passes[0], passes[2], "{}: four lights", spec.short());
        }
    });
}
