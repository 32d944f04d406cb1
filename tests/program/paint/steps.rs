//! `gobo render --steps`: each pixel's color must show its count. tests/world_space/voxelized/steps.rs compares the counts with the twin's.

use super::rgb8;
use crate::support::{all, gpu_test_needing, opened, spec};
use crate::{folder, ok, text};
use glam::DVec2;
use gobo::reference::truth::Meshes;
use gobo::scene::{Scene, View};
use gobo::shading::Renderer;
use gobo::technique::open;
use gobo::world::World;

/// Cividis at the ends and in the middle (Nuñez, Anderton and Renslow 2018).
fn cividis(at: f64) -> [u8; 3] {
    let [dark, middle, bright] = [[0.0, 32.0, 77.0], [124.0, 123.0, 120.0], [255.0, 234.0, 70.0]];
    let mix = |a: [f64; 3], b: [f64; 3], t: f64| [0, 1, 2].map(|i| (a[i] + t * (b[i] - a[i])).round() as u8);
    if at < 0.5 { mix(dark, middle, 2.0 * at) } else { mix(middle, bright, 2.0 * at - 1.0) }
}

const SIZE: [u32; 2] = [96, 54];

/// Pixels must be black exactly where rays hit no mesh; elsewhere they must show the counts, in the printed range.
#[test]
fn colors_are_counts() {
    if crate::support::is_costly("colors_are_counts") {
        return;
    }
    gpu_test_needing("colors_are_counts", &[], |context| {
        let text_of = "voxelized:size=512";
        // Town has a million triangles.
        let name = if all() { "town" } else { "houses" };
        let scene = Scene::load(name, 20.0).expect("built in");
        let world = World::new(context, &scene).expect("room for the scene");
        let mut baked = opened(open(context, &world, &spec(text_of)), text_of);
        baked.build(&world).expect("baked");
        let camera = View::camera(&scene.camera, &scene, SIZE);
        let renderer = Renderer::new(context, &world, &camera).expect("a renderer");
        let counts = renderer.steps(&baked.technique.answer()).expect("counted");

        let folder = folder();
        let out = folder.path().join("steps.png");
        let picture = SIZE.map(|side| side.to_string()).join("x");
        let size = ["--picture", &picture, "--out", text(&out)];
        let said = ok(&[&["render", name, "--technique", text_of, "--steps", "--plain"][..], &size].concat());
        let printed = said.lines().last().expect("the range").split_once(": ").expect("numbers").1;
        let numbers: Vec<f64> = printed.split(' ').filter_map(|word| word.parse().ok()).collect();
        let [least, most, mean] = numbers[..] else { panic!("{said}") };
        let of_mesh: Vec<f64> = counts.iter().flatten().map(|count| f64::from(*count)).collect();
        let range = of_mesh.iter().fold((f64::MAX, 0.0f64), |(low, high), count| (low.min(*count), high.max(*count)));
        assert_eq!((least, most), range, "{said}");
        assert!((of_mesh.iter().sum::<f64>() / of_mesh.len() as f64 - mean).abs() < 0.0051, "{said}");
        assert!(most > least + 2.0, "{said}: the test proves nothing");

        let meshes = Meshes::new(&scene.meshes);
        let (size, pixels) = rgb8(&out);
        assert_eq!(size, SIZE);
        let step = (-f64::from(context.features().sub_pixel_precision_bits)).exp2();
        let (mut black, mut compared, mut of_count) = (0, 0, std::collections::BTreeMap::new());
        for (i, pixel) in pixels.iter().enumerate() {
            let at = DVec2::new((i as u32 % SIZE[0]).into(), (i as u32 / SIZE[0]).into()) + 0.5;
            let meets = |offset: [f64; 2]| {
                let ray = camera.ray(at + DVec2::from(offset));
                meshes.hit(ray.origin, ray.direction).is_some()
            };
            // The rasterizer snaps corners to its grid, so it may hit parts thinner than a grid step that the ray through the centre
            // misses.
            let near =
                (-2..=2).flat_map(|x| (-2..=2).map(move |y| [f64::from(x), f64::from(y)].map(|c| c * step / 2.0)));
            let far = [[-0.25, -0.25], [0.25, -0.25], [-0.25, 0.25], [0.25, 0.25]];
            let middle = meets([0.0; 2]);
            if near.chain(far).all(|offset| meets(offset) == middle) {
                compared += 1;
                assert_eq!(*pixel != [0; 3], middle, "pixel {at}: black is where no mesh is");
            }
            match counts[i] {
                None => black += usize::from(*pixel == [0; 3]),
                Some(count) => {
                    let wanted = cividis((f64::from(count) - least) / (most - least));
                    assert_eq!(*pixel, wanted, "pixel {at}: {count} of {least} to {most}");
                    *of_count.entry(count).or_insert(0) += 1;
                }
            }
        }
        assert!(compared > pixels.len() / 2, "{compared} pixels are far enough from an edge");
        println!("{black} pixels black, {compared} compared, by their counts {of_count:?}");
        assert!(black > 100 && of_count.values().filter(|n| **n > 20).count() > 2, "{black}, {of_count:?}");
    });
}
