//! Failed updates and updates that do not fit change nothing, and later builds do not rely on them.

use super::{answers, build, fewer, opened, points, world};
use crate::support::{gpu_test, scenes, spec};
use gobo::Error;
use gobo::gpu::Commands;
use gobo::scene::{Scene, Strand};
use gobo::technique::{Answer, BuildStatus, Inspect, Opened, Technique};
use gobo::world::World;

/// A technique that fails once, half-way through recording.
struct Fails<'a> {
    inner: &'a mut dyn Technique,
    failed: bool,
}

impl Technique for Fails<'_> {
    fn record(&mut self, commands: &mut Commands, world: &World) -> gobo::Result<()> {
        self.inner.record(commands, world)?;
        if std::mem::replace(&mut self.failed, true) {
            return Ok(());
        }
        Err(Error::input("memory", "there is none", "buy some"))
    }

    fn settle(&mut self, frame: u64) -> gobo::Result<BuildStatus> {
        self.inner.settle(frame)
    }

    fn answer(&self) -> Answer<'_> {
        self.inner.answer()
    }

    fn inspect(&self) -> &dyn Inspect {
        self.inner.inspect()
    }
}

/// After failing half-way a technique may believe that it is up to date, so it is not built again, and the error says so.
#[test]
fn a_failed_build_is_not_built_upon() {
    gpu_test("a_failed_build_is_not_built_upon", |context| {
        let world = world(context, &fewer());
        let mut avsm = opened(context, &world, &spec("avsm:size=24"));
        let fails = Fails { inner: avsm.technique.as_mut(), failed: false };
        let mut opened = Opened::new(context, Box::new(fails), true);
        for text in ["there is none", "an earlier build of it ended in an error; open it anew"] {
            let error = opened.build(&world).expect_err(text).to_string();
            assert!(error.contains(text) && !error.contains('\n'), "{error}");
        }
    });
}

/// An update succeeds completely or changes nothing: what does not fit is reported on one line with a way out.
#[test]
fn what_does_not_fit_changes_nothing() {
    gpu_test("what_does_not_fit_changes_nothing", |context| {
        let scene = fewer();
        let mut world = world(context, &scene);
        let spec = spec("avsm:path=two-pass,size=24");
        let mut avsm = opened(context, &world, &spec);
        build(&mut avsm, &world, "as it was made");
        let points = points();
        let before = answers(context, avsm.technique.as_ref(), 2, &points);
        let other = |change: &dyn Fn(&mut Scene)| {
            let mut other = scene.clone();
            change(&mut other);
            // If any of it were written, look-ups would change.
            other.particles.iter_mut().for_each(|p| p.extinction *= 3.0);
            other
        };
        let strand = Strand { start: [0.0; 3], radius: 0.1, end: [0.5; 3], opacity: 0.5 };
        for (what, other) in [
            ("101 casters, and the world has room for 100", other(&|s| s.particles.push(s.particles[0]))),
            ("101 casters, and the world has room for 100", other(&|s| s.strands.push(strand))),
            ("it has strands", other(&|s| s.strands.extend(s.particles.pop().map(|_| strand)))),
            ("meshes or lights", other(&|s| s.meshes.clear())),
            ("meshes or lights", other(&|s| s.meshes.push(scenes::level(0.5, 0.3, [0.0, 0.0])))),
            ("meshes or lights", other(&|s| s.lights.truncate(1))),
            ("meshes or lights", other(&|s| s.lights.push(s.lights[0]))),
            ("meshes or lights", other(&|s| s.lights.reverse())),
        ] {
            let generations = world.generations().clone();
            let error = world.replace(&other).expect_err(what);
            let text = error.to_string();
            assert!(matches!(error, Error::Input { .. }) && text.contains(what), "{text}");
            assert!(text.contains("make a new world") && !text.contains('\n'), "{text}");
            assert_eq!((world.generations(), world.scene().expect("of a scene")), (&generations, &scene), "{what}");
            assert!(build(&mut avsm, &world, what).passes.is_empty(), "{what}: nothing has moved");
            avsm.rebuild(&world).expect(what);
            assert!(answers(context, avsm.technique.as_ref(), 2, &points) == before, "{what}: other answers");
        }
    });
}
