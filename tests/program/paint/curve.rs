//! `gobo curve`: the truth along a ray, lines on it, nodes on their line.

use crate::support::{self, gpu_test_needing, opened, shared_data, spec};
use glam::{DVec2, DVec3};
use gobo::gpu::{Context, Requirement};
use gobo::measure::{LightRay, RayLine};
use gobo::reference::truth::Casters;
use gobo::scene::{Scene, View};
use gobo::technique::{Opened, open};
use gobo::world::World;

/// The exact list, whose line is the truth, first.
const SPECS: [&str; 6] = [
    "uncompressed:",
    "avsm:path=binned,nodes=4,curve=linear,",
    "avsm:path=binned,nodes=8,",
    "avsm:path=two-pass,nodes=16,nudge=off,",
    "avsm:path=binned,nodes=16,storage=packed,",
    "avsm:path=binned,nodes=8,storage=tight,",
];

/// Each built for the scene, with maps of `size` texels a side.
fn built(context: &Context, scene: &Scene, size: u32) -> Vec<Opened> {
    let world = World::new(context, scene).expect("room for the scene");
    let of = |text: &&str| {
        let text = format!("{text}size={size}");
        let mut opened = opened(open(context, &world, &spec(&text)), &text);
        opened.build(&world).expect(&text);
        opened
    };
    SPECS.iter().map(of).collect()
}

/// How far a line is from a node, up and down: 0 where it leaps past it.
fn off_the_line(line: &RayLine, (depth, through): (f64, f64)) -> f64 {
    let after = line.points.partition_point(|(at, _)| *at < depth).clamp(1, line.points.len() - 1);
    let [(from, high), (to, low)] = [line.points[after - 1], line.points[after]];
    assert!(depth < from || depth > to || to - from < 1e-4, "{from} to {to} is no point of the line at {depth}");
    (through - high.max(low)).max(high.min(low) - through).max(0.0)
}

/// On rays of every map that covers something: the device's view is the f64 fit, the truth is what the casters between light and
/// point leave, the line of the exact list is the truth, and each node is on its line. Beside meshes, outside the boundary.
#[test]
fn curves_are_true_and_nodes_are_on_their_line() {
    gpu_test_needing("curves_are_true_and_nodes_are_on_their_line", &[Requirement::FragmentStores], |context| {
        let of = |name: &str| Scene::load(name, 20.0).expect("built in");
        let mut scenes = vec![of("three-emitters"), of("lantern"), of("hair")];
        if let Some(data) = shared_data("curves_are_true_and_nodes_are_on_their_line, plume_8k") {
            scenes.push(of(data.join("plume_8k.toml").to_str().expect("UTF-8")));
        }
        let size = 128;
        for scene in &scenes {
            let start = std::time::Instant::now();
            let opened = built(context, scene, size);
            println!("built {:?}", start.elapsed());
            let casters = Casters::new(scene);
            println!("casters {:?}", start.elapsed());
            let views = View::volumes(scene, size);
            for (light, map) in (0..scene.lights.len())
                .flat_map(|light| (0..scene.lights[light].map_count()).map(move |face| (light, face)))
                .map(|(light, face)| (light, scene.first_map(light) + face))
            {
                let mut worst = [0.0f64; 4];
                let mut counts = [0; 3];
                for texel in [[64, 40], [40, 64], [70, 70], [52, 90], [85, 33], [64, 64], [30, 100]] {
                    let Ok(ray) = LightRay::new(context, &casters, &opened, map, texel) else { continue };
                    counts[0] += 1;
                    for (a, b) in [(ray.view.near, views[map].near), (ray.view.far, views[map].far)] {
                        worst[0] = worst[0].max(f64::from((a - b).abs()));
                    }
                    let along = ray.view.ray(DVec2::new(texel[0].into(), texel[1].into()) + 0.5);
                    let resolution = opened[0].technique.resolution()[map];
                    let outside = |depth: f64| !casters.in_boundary(light, &resolution, along.at(ray.view.z(depth)));
                    for (i, (depth, truth)) in ray.truth.iter().enumerate() {
                        let independent = casters.visibility(light, along.at(ray.view.z(*depth)));
                        worst[1] = worst[1].max((independent - truth).abs());
                        let off = (ray.lines[0].points[i].1 - truth).abs();
                        if off > worst[2] && outside(*depth) {
                            worst[2] = off;
                        }
                    }
                    for line in &ray.lines[1..] {
                        for node in &line.nodes {
                            counts[1] += 1;
                            let off = off_the_line(line, *node);
                            if off > worst[3] && outside(node.0) {
                                worst[3] = off;
                                println!("{off} {texel:?} {node:?}");
                            }
                        }
                    }
                }
                println!("{} light {light} map {map}: {counts:?} {worst:?}, {:?}", scene.name, start.elapsed());
            }
        }
    });
}
