//! `none`: full light everywhere, and the resulting error.

use crate::support::{gpu_test, scenes, spec};
use gobo::bench::{Effort, Extent, Frames, Status, with_case};
use gobo::reference::truth::{Casters, picture};
use gobo::scene::View;
use gobo::shading::{Lighting, Renderer, Shading, Tiled};
use gobo::technique;
use gobo::world::World;

/// The error is exactly the light that the truth absorbs: each dark point is a leak, no point is a false shadow, and no point is within the
/// resolution. The technique records no pass, costs no time and no memory, and reports the casters that it ignores.
#[test]
fn leaving_shadows_out_costs_what_shadows_take() {
    gpu_test("leaving_shadows_out_costs_what_shadows_take", |context| {
        let mut scene = scenes::random();
        // A plate over a ground.
        scene.meshes = vec![scenes::level(-0.9, 2.0, [0.0, 0.0]), scenes::level(0.3, 0.6, [0.0, 0.0])];
        let effort = Effort {
            frames: 2,
            warm_up: 0,
            space_points: 512,
            seen_points: 512,
            lookups: 0,
            picture: [32, 18],
            footprints: false,
            counts: false,
            turning: false,
            truth: Extent::Sample,
        };
        let scene = [scene];
        let row = with_case(context, Frames::from(&scene[..]), effort, |case| {
            let (none, _) = case.measure(&spec("none"));
            let (exact, _) = case.measure(&spec("beer-shadow-map:size=16"));
            let points = |row: &gobo::bench::Row| row.error.clone().and_then(|e| e.surface).expect("asked").points;
            assert_eq!(points(&none), points(&exact), "the same points");
            Ok(none)
        })
        .expect("measured");
        assert_eq!((row.status, &row.path[..]), (Status::Ok, "lit"), "{}", row.reason);
        assert_eq!(row.unseen, ["smoke", "meshes"]);
        assert_eq!((row.bytes_resident, row.bytes_transient, row.passes.len()), (Some(0), Some(0), 0));
        let timed = context.features().timestamp_valid_bits > 0;
        assert_eq!(row.build_ns.map(|timing| timing.median), timed.then_some(0.0));
        let error = row.error.expect("a truth");
        assert!(error.map.is_none(), "it has no maps");
        for points in [error.space, error.surface].map(|points| points.expect("asked")) {
            assert!(points.mean_abs > 0.05 && points.bias == Some(points.mean_abs), "{points:?}");
            assert!(points.leaks > Some(0) && points.false_shadows == Some(0), "{points:?}");
            assert!(points.within.is_none_or(|within| within.points == 0), "{points:?}");
        }
    });
}

/// With any shading, the picture equals the reference's where nothing casts: the meshes' plain colors.
#[test]
fn a_picture_without_shadows_is_one_of_what_casts_nothing() {
    gpu_test("a_picture_without_shadows_is_one_of_what_casts_nothing", |context| {
        let mut scene = scenes::four_lights();
        scene.particles.clear();
        scene.meshes = vec![scenes::level(0.0, 20.0, [0.0, 0.0])];
        scene.camera.position = glam::DVec3::new(2.0, -3.0, 7.0);
        // A ground that fills the picture and shadows none of it, so the reference is fully lit too.
        scene.lights.truncate(1);
        let camera = View::camera(&scene.camera, &scene, [24, 16]);
        let truth = picture(&Casters::new(&scene), &scene, &camera);
        let world = World::new(context, &scene).expect("room for the scene");
        let none = technique::open(context, &world, &spec("none")).expect("opened");
        let renderer = Renderer::new(context, &world, &camera).expect("a renderer");
        for shading in [Shading::Forward, Shading::Deferred, Shading::Tiled(Tiled::BARE)] {
            let drawn = renderer.picture(&none.technique.answer(), shading, Lighting::Fragment).expect("drawn");
            for (i, (drawn, truth)) in drawn.pixels.iter().zip(&truth.pixels).enumerate() {
                assert!(
                    (0..3).all(|c| (drawn[c] - truth[c]).abs() < 2e-3),
                    "{shading:?}, {i}: {drawn:?}, not {truth:?}"
                );
            }
        }
    });
}
