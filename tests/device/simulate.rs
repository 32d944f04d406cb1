//! Simulated particles: every step equals its twin to the bit, however the device reached it, and no particle goes where it may not.

mod drawn;

use crate::support::{ask, gpu_test, scenes::Random, some, spec};
use glam::DVec3;
use gobo::animate::{AnimatedScene, Simulation};
use gobo::gpu::Context;
use gobo::reference::twin::simulate::{Rules, bodies};
use gobo::scene::{Body, Caster, Fountain, Scene};
use gobo::world::World;

/// A fountain with its particles on the device.
struct Running {
    fountain: Fountain,
    rules: Rules,
    world: World,
    simulation: Simulation,
}

fn scene(particles: u32) -> AnimatedScene {
    AnimatedScene::load(&format!("fountain:particles={particles}"), 0.0).expect("in range")
}

fn running(context: &Context, particles: u32) -> Running {
    running_in(context, &scene(particles))
}

fn running_in(context: &Context, animated: &AnimatedScene) -> Running {
    let (scene, fountain) = (&animated.scene, animated.fountain().expect("a fountain"));
    let world = World::new(context, scene).expect("room");
    let simulation = Simulation::new(context, &world, fountain).expect("room");
    Running { fountain, rules: Rules::of(&fountain, &scene.meshes), world, simulation }
}

impl Running {
    /// Moves the particles to a time, and returns the number of steps that the device reports.
    fn go(&mut self, time_s: f64) -> usize {
        self.simulation.move_to(&mut self.world, time_s).expect("in range").len()
    }

    fn bodies(&self) -> Vec<Body> {
        self.simulation.bodies().read(self.fountain.particles as usize).expect("read")
    }

    fn casters(&self) -> Vec<Caster> {
        self.world.buffers().casters.read(self.world.caster_count() as usize).expect("read")
    }

    fn twin(&self, time_s: f64) -> Vec<Body> {
        bodies(&self.fountain, &self.rules, self.fountain.step_at(time_s))
    }
}

/// Returns the first pair that differs, with its index.
fn difference(a: &[Body], b: &[Body]) -> Option<(usize, Body, Body)> {
    assert_eq!(a.len(), b.len());
    let pairs = a.iter().zip(b).enumerate();
    pairs.map(|(i, (a, b))| (i, *a, *b)).find(|(_, a, b)| bytemuck::bytes_of(a) != bytemuck::bytes_of(b))
}

#[test]
fn steps_equal_their_twin() {
    if crate::support::is_costly("steps_equal_their_twin") {
        return;
    }
    gpu_test("steps_equal_their_twin", |context| {
        for particles in some([3000, 1, 64, 65, 40_000], 4) {
            let mut running = running(context, particles);
            // Steps through half a life, then jumps to arbitrary times.
            for time_s in [0.0, 0.1, 1.0, 2.0, 20.0, 3.5, 3600.0] {
                running.go(time_s);
                let different = difference(&running.bodies(), &running.twin(time_s));
                assert_eq!(different, None, "{particles} particles at {time_s} s");
                let seen = Scene::load(&format!("fountain:particles={particles}"), time_s).expect("in range");
                assert!(running.casters() == seen.casters(), "{particles} particles at {time_s} s");
            }
        }
    });
}

/// An active attractor draws the particles to its side, and less gravity lifts them; on the device as on its twin.
#[test]
fn particles_go_where_they_are_pulled() {
    if crate::support::is_costly("particles_go_where_they_are_pulled") {
        return;
    }
    let (particles, time_s) = (3000, 2.0);
    let pulled = |at: Option<[f64; 3]>, gravity: f64| {
        scene(particles).pulled(at.map(DVec3::from), gravity, time_s).expect("in range")
    };
    let mean = |scene: &Scene| {
        let sum: DVec3 = scene.particles.iter().map(|p| DVec3::from(p.position.map(f64::from))).sum();
        sum / f64::from(particles)
    };
    let usual = Scene::load(&format!("fountain:particles={particles}"), time_s).expect("in range");
    assert_eq!(pulled(None, 1.0).scene, usual, "what pulls as ever changes nothing");
    for at in [[1.2, 0.0, 2.8], [-1.2, 0.0, 2.8], [0.0, 1.2, 2.8], [0.0, -1.2, 2.8]] {
        let place = DVec3::from(at);
        let [to, from] = [at, [-at[0], -at[1], at[2]]].map(|at| mean(&pulled(Some(at), 1.0).scene));
        println!("{at:?}: {to} {from}");
        let flat = DVec3::new(place.x, place.y, 0.0).normalize();
        assert!(to.dot(flat) > from.dot(flat) + 0.3, "{at:?}: {to} {from}");
        // Horizontal distance only, because attracted particles fall as well.
        let across = |mean: DVec3| (mean - place).truncate().length();
        assert!(across(to) < across(mean(&usual)) - 0.2, "{at:?}: {to}");
    }
    let heights = [0.0, 0.5, 1.0, 3.0].map(|gravity| mean(&pulled(None, gravity).scene).z);
    assert!(heights.windows(2).all(|two| two[0] > two[1] + 0.05), "{heights:?}");
    gpu_test("particles_go_where_they_are_pulled", |context| {
        for scene in [pulled(Some([1.2, 0.5, 2.8]), 1.0), pulled(None, 0.0), pulled(Some([0.0, 9.0, 0.0]), 10.0)] {
            let mut running = running_in(context, &scene);
            for time_s in [2.0, 2.1, 30.0] {
                running.go(time_s);
                assert_eq!(difference(&running.bodies(), &running.twin(time_s)), None, "{time_s} s");
            }
        }
    });
    for (scene, gravity, words) in [("plume_8k", 2.0, "nothing of it is simulated"), ("fountain", 11.0, "of 0 to 10")] {
        let refused =
            AnimatedScene::load(scene, 0.0).expect("built in").pulled(None, gravity, 0.0).expect_err("refused");
        assert!(refused.to_string().contains(words), "{refused}");
    }
}

/// Bodies that no jet produces: fast, slow, on the box, inside the obstacles, at the attractor.
#[test]
fn any_body_takes_its_twins_step() {
    gpu_test("any_body_takes_its_twins_step", |context| {
        let mut random = Random::new(5);
        let mut running = running(context, 8192);
        running.go(1.0);
        let law = running.fountain.law();
        let step = running.fountain.step_at(1.0) + 1;
        let attractor = running.fountain.attractor(step);
        let mut given: Vec<Body> = (0..8192)
            .map(|i| {
                let mut place = [0, 1, 2].map(|axis| random.between(law.low[axis], law.high[axis]));
                let fast = [1e-6, 0.01, law.fastest, 100.0][i % 4];
                let mut speed = [(); 3].map(|()| random.between(-fast, fast));
                match i % 7 {
                    0 => place[i % 3] = if i % 2 == 0 { law.low[i % 3] } else { law.high[i % 3] },
                    1 => place = attractor,
                    2 => speed[i % 3] = 0.0,
                    // On the face of a voxel.
                    3 => place[i % 3] = (place[i % 3] * 16.0).round() / 16.0,
                    _ => {}
                }
                Body { place: [place[0], place[1], place[2], 0.05], speed: [speed[0], speed[1], speed[2], 0.5] }
            })
            .collect();
        running.simulation.bodies().write(&given).expect("room");
        let before = given.clone();
        assert_eq!(running.go(1.0 + 1.0 / 60.0), usize::from(context.features().timestamp_valid_bits > 0));
        for (i, body) in (0..).zip(&mut given) {
            running.rules.step(i, step, attractor, body);
        }
        assert_eq!(difference(&running.bodies(), &given), None);
        let entered = before.iter().zip(&given).filter(|(before, after)| {
            let [from, to] = [before, after].map(|b| [b.place[0], b.place[1], b.place[2]]);
            !running.rules.is_solid(from) && running.rules.is_solid(to)
        });
        assert_eq!(entered.count(), 0, "none entered what is solid");
        let solid = before.iter().filter(|b| running.rules.is_solid([b.place[0], b.place[1], b.place[2]])).count();
        assert!(solid > 50, "{solid} began in what is solid");
    });
}

/// Step by step, at once, backwards, on another device buffer: the same bytes; and if no time passes, no work is done.
#[test]
fn the_way_to_a_time_does_not_matter() {
    gpu_test("the_way_to_a_time_does_not_matter", |context| {
        let timed = context.features().timestamp_valid_bits > 0;
        let mut first = running(context, 2000);
        for frame in 0..=20 {
            let before = first.world.generations().particles;
            let steps = first.go(5.0 + f64::from(frame) / 30.0);
            // Two steps per frame; the first frame jumps, and only its last step is timed.
            assert_eq!(
                steps,
                if !timed {
                    0
                } else if frame == 0 {
                    1
                } else {
                    2
                }
            );
            assert!(first.world.generations().particles > before);
        }
        let time_s = 5.0 + 20.0 / 30.0;
        let before = first.world.generations().clone();
        assert_eq!((first.go(time_s), first.world.generations()), (0, &before));
        let stepwise = (first.bodies(), first.casters());
        let mut second = running(context, 2000);
        second.go(time_s);
        assert!(stepwise == (second.bodies(), second.casters()), "at once");
        second.go(900.0);
        assert!(stepwise.0 != second.bodies());
        second.go(time_s);
        assert!(stepwise == (second.bodies(), second.casters()), "backwards");
    });
}

/// Follows all particles through a whole life, using the device's own numbers.
#[test]
fn nothing_goes_where_it_may_not() {
    gpu_test("nothing_goes_where_it_may_not", |context| {
        let mut running = running(context, 4000);
        let law = running.fountain.law();
        let mut before: Option<Vec<Body>> = None;
        let (mut born, mut turned) = (vec![0; 4000], 0);
        for frame in 0..law.life {
            let time_s = 7.0 + f64::from(frame) / 60.0;
            running.go(time_s);
            let now = running.bodies();
            let step = running.fountain.step_at(time_s);
            for (i, body) in (0..).zip(&now) {
                let [x, y, z, radius] = body.place;
                let is_within = (0..3).all(|axis| (law.low[axis]..=law.high[axis]).contains(&body.place[axis]));
                assert!(is_within, "{i}: {body:?}");
                assert!(!running.rules.is_solid([x, y, z]), "{i} at {step}: {body:?} is in something");
                assert!(body.speed[..3].iter().all(|s| s.abs() <= law.fastest), "{i}: {body:?}");
                assert!(radius > 0.5 * law.radius && radius <= law.radius && body.speed[3] == law.extinction);
                born[i as usize] += u32::from(running.rules.age(i, step).0 == 0);
                let before = before.as_ref().map(|all| all[i as usize]);
                turned += u32::from(before.is_some_and(|b| (0..2).any(|a| b.speed[a] * body.speed[a] < 0.0)));
            }
            for caster in running.casters() {
                assert!(caster.axis == [0.0; 3] && caster.density > 0.0 && caster.density <= law.extinction);
            }
            before = Some(now);
        }
        assert!(born.iter().all(|births| *births == 1), "each is born once in a life");
        assert!(turned > 4000, "{turned} turns");
    });
}

/// Compares one step with the same step in f64, far from anything that reflects a particle.
#[test]
fn a_free_particle_falls_and_is_pulled() {
    let scene = scene(1000);
    let fountain = scene.fountain().expect("a fountain");
    let (law, rules) = (fountain.law(), Rules::of(&fountain, &scene.scene.meshes));
    let far = [100.0; 3];
    let mut random = Random::new(8);
    for attractor in [far, [0.4, -0.3, 4.2]] {
        for i in 0..300 {
            let place = [random.between(-1.0, 1.0), random.between(-1.0, 1.0), random.between(3.9, 5.0)];
            let speed = [(); 3].map(|()| random.between(-0.1, 0.1));
            // A step in which the particle is not born.
            let step = (1000..).find(|step| rules.age(i, *step).0 > 0).expect("most");
            let mut body =
                Body { place: [place[0], place[1], place[2], 0.1], speed: [speed[0], speed[1], speed[2], 1.0] };
            rules.step(i, step, attractor, &mut body);
            let way = [0, 1, 2].map(|a| f64::from(attractor[a]) - f64::from(place[a]));
            let square: f64 = way.iter().map(|w| w * w).sum();
            let pull = f64::from(law.pull) * (1.0 - square * f64::from(law.reach)).max(0.0);
            for axis in 0..3 {
                let gravity = if axis == 2 { f64::from(law.gravity) } else { 0.0 };
                let expected = (f64::from(speed[axis]) + pull * way[axis] - gravity) * f64::from(law.drag);
                assert!((f64::from(body.speed[axis]) - expected).abs() < 1e-7, "{body:?}, {expected}");
                let to = f64::from(place[axis]) + expected;
                assert!((f64::from(body.place[axis]) - to).abs() < 1e-6, "{body:?}, {to}");
            }
        }
    }
    // Reflected at the box: the speed is as the law says, and the position along that axis does not change.
    let mut body = Body { place: [3.7, 0.0, 5.0, 0.1], speed: [0.1, 0.02, 0.0, 1.0] };
    let step = (1000..).find(|step| rules.age(0, *step).0 > 0).expect("most");
    rules.step(0, step, far, &mut body);
    let [u, v] = [0.1 * law.drag * -law.bounce, 0.02 * law.drag * law.slide];
    assert!((body.speed[0] - u).abs() < 1e-7 && (body.speed[1] - v).abs() < 1e-7, "{body:?}");
    assert!(body.place[0] == 3.7 && body.place[1] > 0.0, "{body:?}");
}

/// The obstacles are exactly the cells that the meshes occupy, and all of them are in the grid.
#[test]
fn the_grid_stands_where_it_is_told() {
    gpu_test("the_grid_stands_where_it_is_told", |context| {
        let mut running = running(context, 10);
        running.go(0.0);
        let place = running.fountain.place();
        let data = running.simulation.grid().data().expect("read");
        assert_eq!(
            (data.origin, data.voxel, data.per_unit, data.size),
            (place.origin, place.voxel, place.per_unit, 128)
        );
        assert!(running.simulation.grid().bits().expect("read") == running.rules.solid().words);
        for mesh in &running.world.scene().expect("of a scene").meshes {
            assert!(gobo::scene::sides(mesh).iter().all(|side| side.sign() != 0) || mesh.name == "ground");
            let voxels = mesh.positions.iter().flat_map(|p| place.voxels(*p));
            assert!(voxels.into_iter().all(|v| (1.0..=127.0).contains(&v)), "{}", mesh.name);
        }
    });
}

/// Look-ups in a simulated world equal those in a world created at that time, which knows nothing of a simulation.
#[test]
fn techniques_shadow_with_what_is_simulated() {
    gpu_test("techniques_shadow_with_what_is_simulated", |context| {
        let specs =
            ["avsm:path=binned,size=24", "psm:path=fused,size=16,slices=32", "beer-shadow-map:path=binned,size=24"];
        for text in some(specs, 2) {
            let mut running = running(context, 3000);
            let mut moved = crate::support::opened(gobo::technique::open(context, &running.world, &spec(text)), text);
            moved.build(&running.world).expect(text);
            for time_s in [20.0, 20.05] {
                running.go(time_s);
                moved.build(&running.world).expect(text);
                let points: Vec<_> = {
                    let mut random = Random::new(3);
                    (0..400).map(|_| random.point(-2.0, 2.0)).collect()
                };
                let answers = ask(context, moved.technique.as_ref(), 0, &points);
                running.world.read_back().expect("read");
                let then = Scene::load("fountain:particles=3000", time_s).expect("in range");
                assert!(running.world.scene().expect("of a scene").particles == then.particles, "{time_s} s");
                let fresh = crate::support::built(context, &then, text);
                let begun = ask(context, fresh.as_ref(), 0, &points);
                assert!(answers == begun, "{text} at {time_s} s");
                assert!(answers.iter().any(|a| *a < 0.9), "{text}: no shadow");
            }
        }
    });
}

/// The largest fountain fits the buffer size that every device can bind, and its dispatch fits every device's limits.
#[test]
fn four_million_fit_every_device() {
    let most = 4_000_000u64;
    assert!(most * size_of::<Body>() as u64 <= 128 << 20 && most * size_of::<Caster>() as u64 <= 128 << 20);
    assert!(most.div_ceil(64) <= 65_535);
}

#[test]
fn what_is_not_simulated_says_so() {
    gpu_test("what_is_not_simulated_says_so", |context| {
        let still = AnimatedScene::from(crate::support::scenes::random());
        let world = World::new(context, &still.scene).expect("room");
        assert!(still.fountain().is_none());
        let other = Simulation::new(context, &world, Fountain::new(1_000_000)).map(|_| ()).expect_err("another scene");
        assert!(other.to_string().contains("and the fountain has 1000000"), "{other}");
        let mut running = running(context, 100);
        for time_s in [-0.1, f64::NAN, f64::INFINITY, 3600.1] {
            let error = running.simulation.move_to(&mut running.world, time_s).expect_err("out of range").to_string();
            assert!(error.contains("not in [0, 3600]"), "{error}");
        }
        assert_eq!(running.world.generations().particles, 0);
        running.go(1.0);
        assert_eq!(difference(&running.bodies(), &running.twin(1.0)), None);
    });
}
