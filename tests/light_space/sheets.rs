//! See-through meshes: stacks of panes in closed form, and cards of all kinds against the truth.

use crate::opaque::lights;
use crate::support::scenes::Random;
use crate::support::{all, ask, built, gpu_test, opened, rows, scenes, some, spec, those_that_run};
use glam::DVec3;
use gobo::bench::Status;
use gobo::gpu::Context;
use gobo::scene::{Alpha, AlphaMode, ExtinctionGroup, Mesh, Scene};
use gobo::technique;
use gobo::world::World;

/// Heights of panes and what each absorbs, from the top.
const PANES: [(f32, f32); 5] = [(0.8, 0.1), (0.5, 0.3), (0.1, 0.5), (-0.3, 0.2), (-0.7, 0.9)];

/// A pane: a level quad that absorbs this share of light. Panes are turned, so that the diagonals of no two coincide.
fn pane(number: usize, height: f32, alpha: f32) -> Mesh {
    let mut mesh = scenes::level(height, 1.6, [0.0, 0.0]);
    let (sin, cos) = (0.3 + number as f32).sin_cos();
    for [x, y, _] in &mut mesh.positions {
        [*x, *y] = [*x * cos - *y * sin, *x * sin + *y * cos];
    }
    mesh.alpha = Some(Alpha::constant(AlphaMode::SeeThrough, alpha, 4));
    mesh
}

/// Points halfway between two panes, above all, and below all, with the light that arrives there.
fn asked() -> (Vec<[f32; 3]>, Vec<f64>) {
    let mut random = Random::new(7);
    let heights: Vec<f32> = PANES.iter().map(|pane| pane.0).collect();
    let between = heights.windows(2).map(|pair| 0.5 * (pair[0] + pair[1]));
    let levels: Vec<f32> = [0.95].into_iter().chain(between).chain([-0.9]).collect();
    let points = (0..300).map(|i| [random.between(-0.5, 0.5), random.between(-0.5, 0.5), levels[i % levels.len()]]);
    let points: Vec<[f32; 3]> = points.collect();
    let left = |point: &[f32; 3]| PANES.iter().filter(|p| p.0 > point[2]).map(|p| 1.0 - f64::from(p.1)).product();
    let expected = points.iter().map(left).collect();
    (points, expected)
}

/// Specs of techniques that store steps, and how far a look-up may be off: between panes, and behind all of them. Where the first is 1, the
/// method decides what it shows between panes. A grid has too little of panes that face the light if it keeps no directions.
const STACKED: [(&str, f64, f64); 22] = [
    ("uncompressed:size=64", 1e-4, 1e-4),
    ("grid-query:size=64", 1e-4, 1e-4),
    ("avsm:size=64,nodes=16", 2e-3, 1e-3),
    ("avsm:size=64,nodes=16,path=interlock", 2e-3, 1e-3),
    ("deep-shadow-map:size=64", 1e-3, 1e-3),
    ("psm:size=64,slices=128", 1e-2, 1e-2),
    ("layers:size=64", 1e-3, 1e-3),
    ("density-grid:size=128,direction=mean", 2e-2, 1e-2),
    ("ray-query", 1e-4, 1e-4),
    ("avsm:size=64,nodes=16,path=two-pass", 2e-3, 1e-3),
    ("avsm:size=64,nodes=16,path=binned,resolve=streaming", 2e-3, 1e-3),
    ("deep-shadow-map:size=64,path=two-pass", 1e-3, 1e-3),
    ("layers:size=64,path=raster", 1e-3, 1e-3),
    ("fourier:size=64", 1.0, 1e-3),
    ("moments:size=64", 0.1, 1e-3),
    ("moments:size=64,moments=6", 0.1, 1e-3),
    ("wavelet:size=64", 1e-3, 1e-3),
    ("beer-shadow-map:size=64", 0.5, 1e-3),
    ("stochastic:size=64", 0.45, 0.15), // 16 samples: 3.6 deviations
    ("translucency-map:size=64", 1.0, 1e-2),
    ("half-angle:size=64", 1.0, 1e-2),
    ("marched:size=64", 1.0, 0.15),
];

/// Number of these specs that every run has.
const FEW: usize = 5;

fn stack(context: &Context, scene: &Scene, text: &str, [between, behind]: [f64; 2]) -> bool {
    let (points, expected) = asked();
    let technique = built(context, scene, text);
    let found = ask(context, technique.as_ref(), 0, &points);
    let mut worst = [0.0_f64; 2];
    for ((found, expected), point) in found.iter().zip(&expected).zip(&points) {
        let off = (f64::from(*found) - expected).abs();
        let worst = &mut worst[usize::from(point[2] < -0.7)];
        *worst = worst.max(off);
    }
    println!("{}: {text}: off by {:.5} between panes, {:.5} behind all", scene.name, worst[0], worst[1]);
    worst[0] <= between && worst[1] <= behind
}

/// The light behind a stack of panes is the product of their transmittances, for every technique that stores steps.
#[test]
fn stacks_of_panes_have_their_closed_form() {
    const TEST: &str = "stacks_of_panes_have_their_closed_form";
    gpu_test(TEST, |context| {
        let panes = PANES.iter().enumerate().map(|(i, (height, alpha))| pane(i, *height, *alpha));
        let meshes: Vec<Mesh> = panes.chain([scenes::level(-1.2, 1.6, [0.0, 0.0])]).collect();
        let mut failed = Vec::new();
        // Lights that see each pane from above, all of it.
        let is_above = |scene: &Scene| scene.lights[0].position().is_none_or(|at| at.z > 5.0);
        let above = lights(&[70.0], DVec3::ZERO).into_iter().filter(is_above);
        let scene = |(i, light): (usize, Scene)| Scene { name: format!("panes-{i}"), meshes: meshes.clone(), ..light };
        let scenes: Vec<Scene> = above.enumerate().map(scene).collect();
        for (turn, text) in
            those_that_run(TEST, context, some(STACKED.iter().map(|spec| spec.0), FEW)).into_iter().enumerate()
        {
            let (_, between, behind) = STACKED.iter().find(|spec| spec.0 == text).expect("listed");
            // Lights take turns: a technique is built for each of them only when all cases are asked for. One takes only a sun.
            let lit = if text.starts_with("half-angle") { &scenes[..1] } else { &scenes[..] };
            for (i, scene) in lit.iter().enumerate() {
                if (all() || i == turn % lit.len()) && !stack(context, scene, text, [*between, *behind]) {
                    failed.push(format!("{}: {text}", scene.name));
                }
            }
        }
        assert!(failed.is_empty(), "{failed:?}");
    });
}

/// Cards cut from textures of all kinds, through which light passes: techniques without loss are right, whatever the texture, and maps
/// within their resolution.
#[test]
fn textured_cards_agree_with_the_truth() {
    if crate::support::is_costly("textured_cards_agree_with_the_truth") {
        return;
    }
    gpu_test("textured_cards_agree_with_the_truth", |context| {
        let mut scene = scenes::cards(1);
        scene.meshes.iter_mut().filter_map(|mesh| mesh.alpha.as_mut()).for_each(|a| a.mode = AlphaMode::SeeThrough);
        let mut inked = scene.clone();
        // Panes of three colors.
        for (i, alpha) in inked.meshes.iter_mut().filter_map(|mesh| mesh.alpha.as_mut()).enumerate() {
            alpha.extinction_ratio = [[1.0, 0.4, 0.2], [0.3, 1.0, 0.0], [1.0; 3]][i % 3];
        }
        inked.particles = scenes::random().particles;
        let (red, blue) = ([1.0, 0.4, 0.2], [0.3, 0.5, 1.0]);
        let half = inked.particles.len() / 2;
        let groups = [(half, red), (inked.particles.len() - half, blue)];
        let groups = groups.map(|(casters, ratio)| ExtinctionGroup { casters, ratio });
        let inked = inked.with_inks(&groups).expect("inks");
        for (scene, texts) in [
            (scene, &[("grid-query:size=64", 2e-4), ("ray-query", 2e-4), ("uncompressed:size=512", 0.02)][..]),
            (inked, &[("uncompressed:size=512", 0.003), ("avsm:size=512,nodes=16", 0.004), ("layers:size=512", 0.006)]),
        ] {
            let specs: Vec<&str> = texts.iter().map(|text| text.0).collect();
            for (row, (text, most)) in rows(context, &scene, &specs).into_iter().zip(texts) {
                if row.status == Status::Refused {
                    println!("{text}: {}", row.reason);
                    continue;
                }
                assert_eq!(row.status, Status::Ok, "{text}: {}", row.reason);
                assert!(row.unseen.is_empty(), "{text}: {:?}", row.unseen);
                let error = row.error.expect("a truth");
                let space = error.space.expect("points in space");
                println!("{text}: mean error {} in space, seen {:?}", space.mean_abs, error.seen);
                assert!(space.mean_abs < *most, "{text}: {}", space.mean_abs);
            }
        }
    });
}

/// Every ray crosses a pane once, through either of its triangles, even where it meets the edge between them: on the diagonal of a pane
/// that is parallel to the axes, and through the centres of a map's texels.
#[test]
fn edges_between_triangles_count_once() {
    const TEST: &str = "edges_between_triangles_count_once";
    gpu_test(TEST, |context| {
        let mut scene = scenes::directional("edges", [0.0, 0.0, -1.0], Vec::new());
        let mut pane = scenes::level(0.5, 1.0, [0.0, 0.0]);
        pane.alpha = Some(Alpha::constant(AlphaMode::SeeThrough, 0.5, 4));
        scene.meshes = vec![pane, scenes::level(-1.0, 1.0, [0.0, 0.0])];
        let points: Vec<[f32; 3]> =
            (0..961).map(|i| [(i % 31) as f32 / 16.0 - 0.9375, (i / 31) as f32 / 16.0 - 0.9375, 0.0]).collect();
        for text in
            those_that_run(TEST, context, ["grid-query:size=64", "ray-query", "uncompressed:size=64", "layers:size=64"])
        {
            let found = ask(context, built(context, &scene, text).as_ref(), 0, &points);
            let off = found.iter().filter(|answer| (**answer - 0.5).abs() > 1e-4).count();
            assert_eq!(off, 0, "{text}: {off} of {} points", points.len());
        }
    });
}

/// Panes that have moved cast where they are.
#[test]
fn panes_that_move_cast_where_they_are() {
    gpu_test("panes_that_move_cast_where_they_are", |context| {
        let panes = PANES.iter().enumerate().map(|(i, (height, alpha))| pane(i, *height, *alpha));
        let mut scene = scenes::directional("panes", [0.2, 0.1, -1.0], scenes::random().particles);
        scene.meshes = panes.collect();
        let mut moved = scene.clone();
        moved
            .meshes
            .iter_mut()
            .flat_map(|mesh| &mut mesh.positions)
            .for_each(|at| *at = [at[0] + 0.7, at[1], at[2] - 0.25]);
        let (points, _) = asked();
        for text in ["grid-query:size=64", "layers:size=64", "density-grid:size=64,direction=mean"] {
            let mut world = World::new(context, &scene).expect("room");
            let mut technique = opened(technique::open(context, &world, &spec(text)), text);
            technique.build(&world).expect("built");
            let before = ask(context, technique.technique.as_ref(), 0, &points);
            world.replace(&moved).expect("moved");
            technique.build(&world).expect("built");
            let after = ask(context, technique.technique.as_ref(), 0, &points);
            let expected = ask(context, built(context, &moved, text).as_ref(), 0, &points);
            assert_eq!(after, expected, "{text}");
            assert_ne!(after, before, "{text}");
        }
    });
}
