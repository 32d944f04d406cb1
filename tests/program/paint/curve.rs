//! `gobo curve`: the truth along a ray, the exact list's line, nodes on their lines, and all of them in the SVG.

use super::plot::Plot;
use crate::support::{all, gpu_test_needing, opened, some, spec};
use crate::{folder, ok, small_scene, text};
use glam::DVec2;
use gobo::bench::{LightRay, RayLine};
use gobo::gpu::{Context, Requirement};
use gobo::reference::truth::Casters;
use gobo::scene::{Scene, View};
use gobo::technique::{Opened, open};
use gobo::world::World;

/// The exact list comes first; its line is the truth.
const SPECS: [&str; 8] = [
    "uncompressed:",
    "avsm:path=binned,nodes=4,curve=linear,",
    "avsm:path=binned,nodes=8,",
    "avsm:path=two-pass,nodes=16,nudge=off,",
    "avsm:path=binned,nodes=16,storage=packed,",
    "avsm:path=binned,nodes=8,storage=tight,",
    "avsm:path=binned,nodes=8,detail=adaptive,",
    "avsm:path=binned,nodes=8,filter=gaussian,radius=2,",
];

/// Opens and builds each technique for the scene, with maps of `size` texels per side.
fn built(context: &Context, scene: &Scene, specs: &[&str], size: u32) -> Vec<Opened> {
    let world = World::new(context, scene).expect("room for the scene");
    let of = |text: &&str| {
        let text = format!("{text}size={size}");
        let mut opened = opened(open(context, &world, &spec(&text)), &text);
        assert!(opened.technique.inspect().maps().is_empty(), "{text}: nobody plots in maps that no build has fitted");
        opened.build(&world).expect(&text);
        opened
    };
    specs.iter().map(of).collect()
}

/// Returns the vertical distance of a node from a line; 0 where the line jumps across it.
fn off_the_line(line: &RayLine, (depth, through): (f64, f64)) -> f64 {
    let after = line.points.partition_point(|(at, _)| *at < depth).clamp(1, line.points.len() - 1);
    let [(from, high), (to, low)] = [line.points[after - 1], line.points[after]];
    assert!(depth < from || depth > to || to - from < 1e-4, "{from} to {to} is no point of the line at {depth}");
    (through - high.max(low)).max(high.min(low) - through).max(0.0)
}

/// Returns, for each map of each light, the light and the index of the map among all maps.
fn maps(scene: &Scene) -> Vec<(usize, usize)> {
    let of = |light: usize| (0..scene.lights[light].map_count()).map(move |face| (light, face));
    let faces = (0..scene.lights.len()).flat_map(of);
    faces.map(|(light, face)| (light, scene.first_map(light) + face)).collect()
}

/// What was found on the rays of a scene.
#[derive(Debug, Default)]
struct Found {
    rays: usize,
    nodes: usize,
    /// Number of points on the exact list's line.
    points: usize,
    /// Number of outliers, among these points and the nodes, in the boundary of a mesh's shadow, where the answer is ambiguous.
    in_boundary: usize,
    /// Largest distance of the exact list's line from the truth.
    off_the_truth: f64,
    /// Largest distance of a node from its line.
    off_the_line: f64,
    darkest: f64,
}

/// Texels of a 128² map; in each map that contains casters, some of them are covered.
const TEXELS: [[u32; 2]; 7] = [[64, 40], [40, 64], [70, 70], [52, 90], [85, 33], [64, 64], [30, 100]];

fn found(context: &Context, scene: &Scene, opened: &[Opened], size: u32) -> Found {
    let casters = Casters::new(scene);
    let fitted = View::volumes(scene, size);
    let mut found = Found { darkest: 1.0, ..Found::default() };
    for (light, map) in maps(scene) {
        let resolution = opened[0].technique.inspect().resolution()[map];
        for texel in TEXELS.map(|texel| texel.map(|i| i * size / 128)) {
            let ray = match LightRay::new(context, &casters, opened, map, texel) {
                Ok(ray) => ray,
                Err(error) => {
                    assert!(error.to_string().contains("covers it") || error.to_string().contains("margin"), "{error}");
                    continue;
                }
            };
            found.rays += 1;
            // The device's view must equal that of the f64 fit.
            let (view, other, range) = (ray.view, fitted[map], fitted[map].far - fitted[map].near);
            for (a, b) in [(view.near, other.near), (view.far, other.far)] {
                assert!((a - b).abs() < 1e-5 * range, "{}, map {map}: {view:?}, not {other:?}", scene.name);
            }
            let corner = |view: &View| view.ray(DVec2::ZERO).at(view.z(1.0));
            let apart = (corner(&view) - corner(&other)).length();
            assert!(apart < 1e-5 * corner(&view).length().max(range.into()), "{}, map {map}: {apart}", scene.name);

            let along = view.ray(DVec2::from(texel.map(f64::from)) + 0.5);
            let inside = |depth: f64| casters.in_boundary(light, &resolution, along.at(view.z(depth)));
            for ((depth, truth), (at, said)) in ray.truth.iter().zip(&ray.lines[0].points) {
                // Transmittance of the casters between the light and the point.
                let left = casters.visibility(light, along.at(view.z(*depth)));
                assert!((left - truth).abs() < 1e-9 && at == depth, "{}, {texel:?}: {truth}, not {left}", scene.name);
                let off = (said - truth).abs();
                found.points += 1;
                found.darkest = found.darkest.min(*truth);
                match off > found.off_the_truth && inside(*depth) {
                    true => found.in_boundary += 1,
                    false => found.off_the_truth = found.off_the_truth.max(off),
                }
            }
            for (line, node) in ray.lines.iter().flat_map(|line| line.nodes.iter().map(move |node| (line, *node))) {
                let off = off_the_line(line, node);
                found.nodes += 1;
                match off > found.off_the_line && inside(node.0) {
                    true => found.in_boundary += 1,
                    false => found.off_the_line = found.off_the_line.max(off),
                }
            }
        }
    }
    found
}

/// Checks rays in all maps of all kinds of lights.
#[test]
fn lines_are_true_and_nodes_are_on_them() {
    if crate::support::is_costly("lines_are_true_and_nodes_are_on_them") {
        return;
    }
    const NAME: &str = "lines_are_true_and_nodes_are_on_them";
    gpu_test_needing(NAME, &[Requirement::FragmentStores], |context| {
        let of = |name: &str| Scene::load(name, 20.0).expect("loaded");
        let scenes = ["lantern", "hair", "three-emitters", "plume_8k"].map(of);
        let (size, specs) = if all() { (128, &SPECS[..]) } else { (64, &SPECS[..3]) };
        for scene in &scenes {
            let opened = built(context, scene, specs, size);
            let found = found(context, scene, &opened, size);
            println!("{}: {found:?}", scene.name);
            assert!(found.rays >= 3 && found.nodes > 4 * found.rays && found.darkest < 0.3, "{}", scene.name);
            assert!(50 * found.in_boundary < found.points, "{}: {found:?}", scene.name);
            assert!(found.off_the_truth < 1e-5, "{}: {found:?}", scene.name);
            assert!(found.off_the_line < 1e-3, "{}: {found:?}", scene.name);
        }
    });
}

/// Without `--texel`, the plot must choose an informative texel: some light passes through it, and no other such texel has many more
/// casters. Both the terminal and the plot must name it.
#[test]
fn a_texel_is_chosen() {
    gpu_test_needing("a_texel_is_chosen", &[Requirement::FragmentStores], |_| {
        const SIZE: u32 = 64;
        let folder = folder();
        let small = small_scene(folder.path());
        let face = ["--light", "0", "--face", "+y"];
        for (name, map, more) in some([(text(&small), 0, &[][..]), ("plume_8k", 0, &[]), ("lantern", 2, &face)], 2) {
            let out = folder.path().join("curve.svg");
            let technique = format!("uncompressed:size={SIZE}");
            let said = ok(&[&["curve", name, "--technique", &technique, "--out", text(&out)], more].concat());
            let chosen = said.split_once("texel ").and_then(|(_, rest)| rest.split_once(':')).expect("a texel").0;
            assert!(said.contains(&format!("--texel {chosen}")), "{said}");
            let svg = std::fs::read_to_string(&out).expect("a plot");
            assert!(svg.contains(&format!("texel {chosen}:")), "{name}: the plot's title lacks {chosen}");
            let (x, y) = chosen.split_once(',').expect("two numbers");
            let chosen = [x, y].map(|n| n.parse::<u32>().expect("a number"));
            let scene = Scene::load(name, 20.0).expect("loaded");
            let (view, casters) = (View::volumes(&scene, SIZE)[map], Casters::new(&scene));
            let of = |[x, y]: [u32; 2]| {
                let (curve, met) = casters.true_curve(map, &view, &view.ray(DVec2::new(x.into(), y.into()) + 0.5));
                (curve.transmittance(1.0), met)
            };
            let (left, met) = of(chosen);
            assert!(met > 0 && (0.04..0.96).contains(&left), "{name}: {met} casters leave {left}");
            let texels = (0..SIZE * SIZE).map(|i| of([i % SIZE, i / SIZE]));
            let most = texels.filter(|(left, _)| (0.06..0.94).contains(left)).map(|(_, met)| met).max();
            println!("{name}: {met} casters leave {left}; {most:?} at most");
            // The command examines every second texel in each direction.
            assert!(most.is_some_and(|most| 10 * met >= 7 * most), "{name}: {met} casters of {most:?}");
        }
    });
}

/// Checks the command's file: the black line must be the truth and each technique's colored line its curve, within a pixel, with dots at
/// its nodes.
#[test]
fn the_svg_shows_the_ray() {
    gpu_test_needing("the_svg_shows_the_ray", &[Requirement::FragmentStores], |context| {
        let folder = folder();
        let small = small_scene(folder.path());
        let face = ["--light", "0", "--face", "+y"];
        let cases = [(text(&small), [20, 20], &[][..]), ("lantern", [17, 19], &face), ("hair", [15, 20], &[])];
        for (name, texel, more) in some(cases, 1) {
            let specs = ["uncompressed:", "avsm:path=binned,nodes=8,"];
            let scene = Scene::load(name, 20.0).expect("loaded");
            let opened = built(context, &scene, &specs, 40);
            let map = if more.is_empty() { 0 } else { 2 };
            let ray = LightRay::new(context, &Casters::new(&scene), &opened, map, texel).expect("covered");

            let (out, at) = (folder.path().join("curve.svg"), format!("{},{}", texel[0], texel[1]));
            let sized = specs.map(|spec| format!("{spec}size=40"));
            let techniques = sized.iter().flat_map(|spec| ["--technique", spec]).collect::<Vec<_>>();
            let said = ok(&[&["curve", name, "--texel", &at, "--out", text(&out)], more, &techniques].concat());
            assert!(said.contains(&format!("{} segments", ray.segments)), "{said}");
            let plot = Plot::read(&out);
            assert_eq!(plot.names.len(), 3, "{:?}", plot.names);
            for (name, starts) in plot.names.iter().zip(["true", "uncompressed", "avsm:"]) {
                assert!(name.starts_with(starts), "{:?}", plot.names);
            }
            let lines = std::iter::once(&ray.truth).chain(ray.lines.iter().map(|line| &line.points));
            let mut dots = 0;
            for ((points, drawn), nodes) in lines.zip(&plot.drawn).zip([&[][..], &[], &ray.lines[1].nodes]) {
                let pixels: Vec<DVec2> = points.iter().map(|point| plot.pixel(*point)).collect();
                let apart = plot.apart(&pixels, &drawn.line);
                let nodes: Vec<DVec2> = nodes.iter().map(|node| plot.pixel(*node)).collect();
                let missing = |node: &DVec2| drawn.dots.iter().all(|dot| (*dot - *node).length() > 1.5);
                let missing = nodes.iter().filter(|node| plot.shows(**node) && missing(node)).count();
                let strange = drawn.dots.iter().filter(|dot| nodes.iter().all(|node| (**dot - *node).length() > 1.5));
                println!("{name}: {apart} pixels apart, {} of {} nodes shown", drawn.dots.len(), nodes.len());
                assert!(apart < 1.5, "{name}: {apart} pixels apart");
                assert_eq!((missing, strange.count()), (0, 0), "{name}");
                assert!(plot.off(&drawn.dots, &drawn.line) < 2.0, "{name}: dots are on their line");
                dots += drawn.dots.len();
            }
            assert!(dots > 2, "{name}: {dots} dots");
            let (high, low) = plot.drawn[0].line.iter().fold((f64::MAX, 0.0f64), |(a, b), p| (a.min(p.y), b.max(p.y)));
            assert!(low - high > 40.0, "{name}: nothing is to be seen");
        }
    });
}
