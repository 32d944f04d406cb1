//! Pipelines created before rows are measured, on all processors.

use crate::support::{gpu_test, scenes, spec};
use gobo::bench::{Effort, Extent, Row, Status, with_case};

/// Maximum number of pipelines, out of some fifty, that are not prepared, because only a build or a picture without shadows requests them.
const LATER: usize = 6;

/// Rows give the same results with preparation as without, and create few more pipelines: those that a build finds it needs. Refused specs
/// do no harm.
#[test]
fn what_is_prepared_is_not_made_again() {
    if crate::support::is_costly("what_is_prepared_is_not_made_again") {
        return;
    }
    gpu_test("what_is_prepared_is_not_made_again", |context| {
        let mut scene = scenes::random();
        scene.meshes = vec![scenes::level(-0.9, 2.0, [0.0, 0.0])];
        let effort = Effort {
            frames: 1,
            warm_up: 0,
            space_points: 512,
            seen_points: 512,
            lookups: 0,
            picture: [32, 18],
            footprints: false,
            counts: false,
            turning: false,
            truth: Extent::Choice,
        };
        let specs = [
            "none",
            "avsm:path=binned,size=16",
            "beer-shadow-map:path=binned,size=16",
            "layers:path=binned,size=16",
            "grid-query:size=64",
            "ray-query",
        ]
        .map(spec);
        let scene = [scene];
        let measured = |prepares: bool| {
            let mut rows: Vec<Row> = Vec::new();
            let mut made = [context.pipelines(); 3];
            with_case(context, &scene[..], effort, |case| {
                if prepares {
                    case.prepare(&specs.iter().collect::<Vec<_>>())?;
                }
                made[1] = context.pipelines();
                rows.extend(specs.iter().map(|spec| case.measure(spec).0));
                made[2] = context.pipelines();
                Ok(())
            })
            .expect("measured");
            (rows, [made[1] - made[0], made[2] - made[1]])
        };
        let (prepared, [before, during]) = measured(true);
        println!("{before} pipelines are made before, and {during} while rows are measured");
        // A device that other tests have used already has some of the pipelines.
        assert!(during <= LATER, "{before} pipelines are made before, and {during} while rows are measured");
        assert!(prepared.iter().filter(|row| row.status == Status::Ok).count() >= 3);
        let (again, [_, none]) = measured(false);
        assert_eq!(none, 0, "a pipeline is made twice");
        for (one, other) in prepared.iter().zip(&again) {
            assert_eq!((one.status, &one.error), (other.status, &other.error), "{}", one.spec());
            assert!(one.status != Status::Failed, "{}", one.reason);
            // A row measured only to choose a technique has a picture's error, and no errors that do not affect the choice.
            let Some(error) = &one.error else { continue };
            assert!(error.image.is_some() && error.seen.is_some_and(|seen| seen.points == 512), "{error:?}");
            assert!(error.map.is_none() && error.space.is_none() && error.surface.is_none(), "{error:?}");
            assert!(one.lookup_ns_per_million.is_none() && error.casters.is_none());
        }
    });
}
