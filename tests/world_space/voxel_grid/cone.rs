//! `march=cone`: counts and cones against their twins, and cones against expected results.

use crate::support::{ask, gpu_test, scenes, scenes::Random, some};
use crate::voxel_grid::{PLAIN, all, built, place, shapes, twin, way};
use glam::DVec3;
use gobo::reference::twin::cone::Cells;
use gobo::scene::Scene;
use gobo::technique::voxel_grid::Plan as Settings;

const NARROW: Settings = Settings { cone: Some(0.0), ..PLAIN };

#[test]
fn cells_equal_their_twin() {
    if crate::support::is_costly("cells_equal_their_twin") {
        return;
    }
    gpu_test("cells_equal_their_twin", |context| {
        for scene in all() {
            for size in some([64, 256, 128], 2) {
                let (_, opened) = built(context, &scene, Settings { size, ..NARROW });
                let bits = twin(&scene, &place(&opened.technique));
                let counts = opened.technique.grid().cells().expect("read");
                assert!(counts == Cells::new(&bits, size).counts(), "{}, size {size}", scene.name);
                assert_eq!(
                    counts.last(),
                    Some(&bits.words[..size.pow(3) as usize / 64].iter().map(|w| w.count_ones()).sum())
                );
            }
        }
        let (_, opened) = built(context, &shapes::houses(), PLAIN);
        assert!(opened.technique.grid().cells().expect("read").is_empty(), "nobody asks for them");
    });
}

/// Look-ups differ only where rounding changes a step or a level, which is rare.
#[test]
fn cones_equal_their_twin() {
    gpu_test("cones_equal_their_twin", |context| {
        let mut scenes = all();
        scenes.truncate(5);
        for scene in scenes {
            for slope in [0.0, 0.03, 0.4] {
                let (_, opened) = built(context, &scene, Settings { cone: Some(slope), ..PLAIN });
                let at = place(&opened.technique);
                let bits = twin(&scene, &at);
                let cells = Cells::new(&bits, at.size);
                let points = shapes::about(&scene, 2000);
                let answers = ask(context, opened.technique.as_ref(), 0, &points);
                assert!(answers.iter().all(|a| (0.0..=1.0).contains(a)), "{}", scene.name);
                let (mut differ, mut shadowed) = (0, 0);
                for (point, answer) in points.iter().zip(answers) {
                    let (from, way) = way(&at, &scene, *point);
                    let expected = cells.march_cone(&bits, from, way, slope);
                    differ += usize::from((answer - expected).abs() > 2e-3);
                    shadowed += usize::from(expected < 0.5);
                }
                assert!(differ < 20 && shadowed > 30, "{}, slope {slope}: {differ} differ, {shadowed}", scene.name);
            }
        }
    });
}

/// A cone of zero width is a ray: full light if no voxel that it could sample, within one and a half voxels, is occupied; and none behind a
/// wall, where every ray within that distance is blocked.
#[test]
fn a_narrow_cone_is_a_ray() {
    gpu_test("a_narrow_cone_is_a_ray", |context| {
        for scene in shapes::seen() {
            let (_, opened) = built(context, &scene, NARROW);
            let at = place(&opened.technique);
            let bits = twin(&scene, &at);
            let points = shapes::about(&scene, 4000);
            let answers = ask(context, opened.technique.as_ref(), 0, &points);
            let (mut free, mut walled) = (0, 0);
            for (point, answer) in points.iter().zip(answers) {
                let (from, way) = way(&at, &scene, *point);
                let steps = [-1.6f32, -0.8, 0.0, 0.8, 1.6];
                let about = steps.iter().flat_map(|x| steps.iter().flat_map(move |y| steps.map(|z| [*x, *y, z])));
                let met = about.filter(|by| bits.march_exact([0, 1, 2].map(|i| from[i] + by[i]), way)).count();
                match met {
                    0 => {
                        free += 1;
                        assert_eq!(answer, 1.0, "{}, lit at {point:?}", scene.name);
                    }
                    125 => {
                        walled += 1;
                        assert!(answer <= 0.05, "{}, behind a wall at {point:?}: {answer}", scene.name);
                    }
                    _ => {}
                }
            }
            assert!(free > 500 && walled > 30, "{}: {free} free, {walled} behind walls", scene.name);
        }
    });
}

/// Below a plate's edge, light returns over a distance as wide as the cone there plus the cells' width.
#[test]
fn a_cone_has_a_penumbra() {
    gpu_test("a_cone_has_a_penumbra", |context| {
        let mut scene = scenes::directional("edge", [0.0, 0.0, -1.0], Vec::new());
        scene.meshes = vec![scenes::level(0.5, 1.0, [-1.0, 0.0]), scenes::level(-0.5, 1.0, [1.0, 0.0])];
        let slope = 0.2;
        let (_, opened) = built(context, &scene, Settings { cone: Some(slope), size: 256, ..PLAIN });
        let at = place(&opened.technique);
        // Half-width of the cone from a point this far below the edge; cells are at most as wide as the cone.
        let (below, voxel) = (0.6, f64::from(at.voxel));
        let reach = below * f64::from(slope) * (1.0 + 1.5 * 2.0) + 2.0 * voxel;
        let places: Vec<_> = (0..200).map(|i| 2.0 * reach * (f64::from(i) / 100.0 - 1.0)).collect();
        let points: Vec<_> = places.iter().map(|x| [*x as f32, 0.03, (0.5 - below) as f32]).collect();
        let answers = ask(context, opened.technique.as_ref(), 0, &points);
        for (x, answer) in places.iter().zip(&answers) {
            if x.abs() > reach {
                let expected = if *x > 0.0 { 1.0 } else { 0.0 };
                assert!((f64::from(*answer) - expected).abs() < 0.01, "{x}: {answer}");
            }
        }
        let rises = answers.windows(2).all(|pair| pair[1] >= pair[0] - 1e-3);
        let between = answers.iter().filter(|a| (0.1..0.9).contains(*a)).count() as f64 * 0.02 * reach;
        println!("penumbra of {between}, the cone is {} wide", 2.0 * below * f64::from(slope));
        assert!(rises && between > 0.25 * below * f64::from(slope), "{between}: {answers:?}");
    });
}

/// A flat surface facing the light does not shadow itself, wherever it is.
#[test]
fn a_flat_receiver_is_lit() {
    gpu_test("a_flat_receiver_is_lit", |context| {
        let mut random = Random::new(71);
        for _ in 0..some(0..12, 6).len() {
            let direction =
                DVec3::new(f64::from(random.between(-0.3, 0.3)), f64::from(random.between(-0.3, 0.3)), -1.0);
            let scene: Scene = shapes::flat(direction.to_array(), false);
            let (_, opened) = built(context, &scene, Settings { cone: Some(0.035), ..PLAIN });
            let voxel = place(&opened.technique).voxel;
            // Offset from the surface as light_receiver does it.
            let points: Vec<_> =
                (0..500).map(|_| [random.between(-0.9, 0.9), random.between(-0.9, 0.9), 1.501 * voxel]).collect();
            let answers = ask(context, opened.technique.as_ref(), 0, &points);
            assert!(answers.iter().all(|a| *a == 1.0), "{direction}: {answers:?}");
        }
    });
}
