//! Volumes: their cells on the device against the twins, techniques against the exact field, and files of dense grids.

mod ground;
mod lit;
mod picture;
mod sequences;
mod spheres;
use crate::support::{ask, built, gpu_test, scenes, some};
use flate2::{Compression, write::GzEncoder};
use glam::{DQuat, DVec3, Vec3};
use gobo::gpu::Context;
use gobo::reference::truth::{Casters, space_points};
use gobo::reference::twin::cell;
use gobo::reference::twin::grid::Place;
use gobo::reference::twin::media::{Media, UNITS};
use gobo::scene::{Field, Placed, Scene, Volume};
use gobo::technique::density_grid::{Direction, March, Settings};
use gobo::technique::{DensityGrid, Opened};
use gobo::world::World;
use std::io::Write;
use std::sync::Arc;

/// A soft ball with `count`³ samples, extinction 4 at its centre, 1.6 world units wide, rotated.
fn ball(count: i32, side: u32) -> Volume {
    let middle = 0.5 * f64::from(count - 1);
    let density = |place: [i32; 3]| {
        let far = DVec3::from_array(place.map(f64::from)).distance(DVec3::splat(middle)) / middle;
        (1.0 - far * far).max(0.0).powi(2) as f32
    };
    let places = (0..count.pow(3)).map(|i| [i % count, i / count % count, i / count / count]);
    let field = Field::new(places.map(|place| (place, density(place)))).expect("a field");
    let turn = DQuat::from_euler(glam::EulerRot::XYZ, 0.4, -0.7, 1.1);
    let steps = [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| turn * axis * 0.8 / middle);
    let origin = DVec3::new(0.05, -0.1, 0.02) - middle * (steps[0] + steps[1] + steps[2]);
    let placed = Placed { origin, steps, extinction: 4.0, color: [0.9, 0.5, 0.2], side };
    Volume::new(Arc::new(field), placed).expect("a volume")
}

fn scene(volume: Volume) -> Scene {
    Scene { volumes: vec![volume], ..scenes::directional("ball", [0.3, 0.2, -1.0], Vec::new()) }
}

fn deposited(context: &Context, scene: &Scene) -> (Vec<u32>, Place) {
    let settings = Settings { size: 64, march: March::Exact, steps: 64, direction: Direction::None, opaque: None };
    let world = World::new(context, scene).expect("room for the scene");
    let technique = DensityGrid::new(context, &world, &settings).expect("opens");
    let mut opened = Opened::new(context, Box::new(technique), true);
    opened.build(&world).expect("built");
    let data = opened.technique.grid().data().expect("read");
    let place = Place { origin: data.origin, voxel: data.voxel, per_unit: data.per_unit, size: data.size };
    (opened.technique.grid().media().expect("read").expect("there is smoke").0, place)
}

/// The voxels equal the twin's up to the device's rounding of shapes, and their total equals the field's, however cells are aligned to
/// voxels.
#[test]
fn volumes_fill_voxels_as_their_twin() {
    gpu_test("volumes_fill_voxels_as_their_twin", |context| {
        for (count, side) in [(24, 1), (12, 1), (48, 4)] {
            let scene = scene(ball(count, side));
            let (voxels, place) = deposited(context, &scene);
            let twin = Media::deposit(&scene.casters(), &place);
            let sum = |of: &[u32]| of.iter().map(|v| f64::from(*v)).sum::<f64>() / f64::from(UNITS);
            let apart = |(a, b): (&u32, &u32)| f64::from(a.abs_diff(*b)) / f64::from(UNITS);
            let off = voxels.iter().zip(&twin.voxels).map(apart).fold(0.0, f64::max);
            let volume = &scene.volumes[0];
            // The mass of a placed field is a sum over samples, each a hat function with a cell's volume.
            let cell = volume.placed().steps.map(DVec3::length).into_iter().product::<f64>();
            let middle = 0.5 * f64::from(count - 1);
            let samples = (0..count.pow(3)).map(|i| [i % count, i / count % count, i / count / count]);
            let hat = |place: [i32; 3]| {
                let far = DVec3::from_array(place.map(f64::from)).distance(DVec3::splat(middle)) / middle;
                (1.0 - far * far).max(0.0).powi(2)
            };
            let mass = samples.map(hat).sum::<f64>() * cell * 4.0;
            let found = sum(&voxels) * f64::from(place.voxel).powi(2);
            println!("{count} {side}: off {off:.1e}, mass {found:.5} of {mass:.5}");
            assert!(off < 2e-5, "{count} {side}: {off}");
            assert!((found / mass - 1.0).abs() < 0.005, "{count} {side}: {found}, not {mass}");
        }
    });
}

/// The look-up of `grid-query` equals the transmittance of the twin's boxes, one per cell.
#[test]
fn volumes_are_asked_as_their_twin() {
    gpu_test("volumes_are_asked_as_their_twin", |context| {
        for scene in [scene(ball(12, 1)), scenes::point([0.2, 1.7, 0.9], scene(ball(12, 1)))] {
            let technique = built(context, &scene, "grid-query:size=64");
            let points = space_points(&scene, 0, 600);
            let cells = scene.casters();
            let mut off = 0;
            for (point, answer) in points.iter().zip(ask(context, technique.as_ref(), 0, &points)) {
                let at = Vec3::from(*point);
                let light = &scene.lights[0];
                let towards = light.towards(at.as_dvec3());
                let way = light.position().map_or(towards, |place| place - at.as_dvec3()).as_vec3();
                let end = if light.position().is_some() { 1.0 } else { f32::INFINITY };
                let inside = |z: [f32; 3]| (z[1].min(end) - z[0].max(0.0)).max(0.0);
                let of = |c| cell::overlap((at, way), c).map_or(0.0, inside) * c.density * way.length();
                let expected = (-cells.iter().map(of).sum::<f32>()).exp();
                off += usize::from((answer - expected).abs() > 2e-4);
            }
            assert!(off * 100 <= points.len(), "{off} of {}", points.len());
        }
    });
}

/// Bound on the mean error of a technique's look-ups.
enum Held {
    /// The error of cells: the technique queries the cells themselves.
    Cells,
    /// The error of cells, plus the variation of light within this many world units, the technique's own step, over which its look-up is a
    /// mean.
    Near(f64),
    /// A quarter of the error without volumes: the technique stores a few numbers, which cannot represent a whole curve.
    Shape,
}

/// Returns the mean absolute difference.
fn mean_apart(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).sum::<f64>() / a.len() as f64
}

/// Returns each point's transmittance towards a directional light, a product over cells. Twin: `grid-query`.
fn left_by_cells(scene: &Scene, points: &[[f32; 3]]) -> Vec<f64> {
    let (cells, towards) = (scene.casters(), scene.lights[0].towards(DVec3::ZERO).as_vec3());
    let depth = |at: Vec3, cell| {
        let z = cell::overlap((at, towards), cell).map_or(0.0, |z| (z[1] - z[0].max(0.0)).max(0.0));
        f64::from(z * cell.density)
    };
    points.iter().map(|at| (-cells.iter().map(|cell| depth(Vec3::from(*at), cell)).sum::<f64>()).exp()).collect()
}

/// Every technique that sees volumes comes close to the exact field, and those that do not name what they miss.
#[test]
fn volumes_cast_in_techniques() {
    if crate::support::is_costly("volumes_cast_in_techniques") {
        return;
    }
    gpu_test("volumes_cast_in_techniques", |context| {
        let scene = scene(ball(24, 1));
        let truth = Casters::new(&scene);
        let points = space_points(&scene, 0, 1500);
        let light = |at: DVec3| truth.visibility(0, at);
        let place = |p: &[f32; 3]| DVec3::from(p.map(f64::from));
        let expected: Vec<f64> = points.iter().map(|p| light(place(p))).collect();
        assert!(expected.iter().any(|v| *v < 0.2), "there is a shadow");
        let of_cells = mean_apart(&left_by_cells(&scene, &points), &expected);
        let unshadowed = mean_apart(&vec![1.0; points.len()], &expected);
        // Largest difference in light between a point and the corners of a cube around it, averaged.
        let differs = |half: f64| {
            let corner = |i: u32| DVec3::from([0, 1, 2].map(|axis| if i >> axis & 1 == 1 { half } else { -half }));
            let of_point = |(p, here): (&[f32; 3], &f64)| {
                (0..8).map(|i| (light(place(p) + corner(i)) - here).abs()).fold(0.0, f64::max)
            };
            points.iter().zip(&expected).map(of_point).sum::<f64>() / points.len() as f64
        };
        let texel = 2.0 / f64::from(crate::support::views(context, &scene, 96)[0].scale_x.abs()) / 96.0;
        let voxel = f64::from(deposited(context, &scene).1.voxel);
        println!("cells {of_cells:.5}; without shadows {unshadowed:.4}; texels {texel:.4}, voxels {voxel:.4}");
        let specs = [
            ("uncompressed:size=96", Held::Near(texel), 0.0025),
            ("density-grid:size=64", Held::Near(voxel), 0.003),
            ("grid-query:size=64", Held::Cells, 0.0025),
            ("avsm:size=96,nodes=16", Held::Shape, 0.0025),
            ("layers:size=96", Held::Shape, 0.003),
            ("optical-depth-grid:size=64,cells=64", Held::Near(2.0 * voxel), 0.003),
            ("psm:size=96", Held::Shape, 0.006),
            ("moments:size=96", Held::Shape, 0.01),
            ("fourier:size=96", Held::Shape, 0.0025),
            ("wavelet:size=96", Held::Shape, 0.003),
            ("deep-shadow-map:size=96", Held::Shape, 0.004),
            ("beer-shadow-map:size=96", Held::Shape, 0.04),
            ("marched:size=96", Held::Shape, 0.006),
        ];
        for (spec, held, before) in some(specs, 6) {
            if !crate::support::runs("volumes_cast_in_techniques", context, spec) {
                continue;
            }
            let technique = built(context, &scene, spec);
            let answers: Vec<f64> = ask(context, technique.as_ref(), 0, &points).into_iter().map(f64::from).collect();
            assert!(answers.iter().all(|a| (-1e-6..=1.0 + 1e-6).contains(a)), "{spec}: no share of light");
            let mean = mean_apart(&answers, &expected);
            let most = match held {
                // Rounding of f32 sums over some thousand cells: volumes_are_asked_as_their_twin.
                Held::Cells => of_cells + 2e-4,
                Held::Near(step) => of_cells + differs(step),
                Held::Shape => 0.25 * unshadowed,
            };
            println!("{spec}: {mean:.5} of {most:.5}, and of {before}");
            assert!(mean < most, "{spec}: {mean}, not below {most}");
            // Not derived: at most twice a former value, so that regressions show.
            assert!(mean < before, "{spec}: {mean}, and it was below {before}");
        }
        let unseen = crate::support::spec("shadow-map").entry.casts.unseen_of(scene.kinds());
        assert_eq!(unseen, ["volumes"]);
    });
}

/// Coarser cells have larger errors, at most in proportion to the square of their sides: a trilinear density equals its mean except for
/// terms odd about a cell's centre, which cancel along rays through it, and for curvature, which scales with the square.
#[test]
fn volumes_of_coarse_cells_are_coarse() {
    gpu_test("volumes_of_coarse_cells_are_coarse", |context| {
        let mean = |side: u32| {
            let scene = scene(ball(32, side));
            let truth = Casters::new(&scene);
            let points = space_points(&scene, 0, 800);
            let technique = built(context, &scene, "grid-query:size=64");
            let answers = ask(context, technique.as_ref(), 0, &points);
            let error =
                |(p, a): (&[f32; 3], &f32)| (f64::from(*a) - truth.visibility(0, DVec3::from(p.map(f64::from)))).abs();
            points.iter().zip(&answers).map(error).sum::<f64>() / points.len() as f64
        };
        let errors = [1, 2, 4].map(mean);
        println!("{errors:?}");
        let rises = [errors[1] / errors[0], errors[2] / errors[1]];
        assert!(rises.iter().all(|by| (2.0..4.0).contains(by)), "{errors:?}");
    });
}

const SIZE: [usize; 3] = [3, 2, 4];

/// Encodes a grid whose samples are distinct multiples of 1/255.
fn samples(encode: impl Fn(u8) -> Vec<u8>) -> Vec<u8> {
    (0..SIZE.iter().product::<usize>() as u8).flat_map(|i| encode(10 * i)).collect()
}

fn loaded(files: &[(&str, &[u8])], name: &str) -> gobo::Result<Scene> {
    let folder = tempfile::tempdir().expect("a folder");
    files.iter().for_each(|(name, bytes)| std::fs::write(folder.path().join(name), bytes).expect("written"));
    Scene::load(folder.path().join(name).to_str().expect("UTF-8"), 0.0)
}

fn sidecar(kind: &str, more: &str) -> String {
    format!(
        "file = \"a.raw\"\nsize = [3, 2, 4]\ntype = \"{kind}\"\nspacing = [0.5, 1.0, 2.0]\norigin = [7, 8, 9]\n{more}"
    )
}

fn nrrd(kind: &str, more: &str, data: &[u8]) -> Vec<u8> {
    let header = format!(
        "NRRD0004\n# a comment\ntype: {kind}\ndimension: 3\nsizes: 3 2 4\n{more}space directions: (0.5,0,0) (0,1,0) (0,0,2)\n\
        space origin: (7,8,9)\nkey:=value\n\n"
    );
    [header.as_bytes(), data].concat()
}

fn zipped(bytes: &[u8]) -> Vec<u8> {
    let mut gzip = GzEncoder::new(Vec::new(), Compression::default());
    gzip.write_all(bytes).expect("into memory");
    gzip.finish().expect("into memory")
}

#[test]
fn volumes_of_every_file_are_the_same() {
    let [u8s, u16s] = [samples(|v| vec![v]), samples(|v| (u16::from(v) * 257).to_le_bytes().to_vec())];
    let floats = samples(|v| (f32::from(v) / 255.0).to_le_bytes().to_vec());
    let big = samples(|v| (f32::from(v) / 255.0).to_be_bytes().to_vec());
    let of_raw = |kind: &str, more: &str, raw: &[u8]| {
        loaded(&[("a.volume", sidecar(kind, more).as_bytes()), ("a.raw", raw)], "a.volume").expect(kind)
    };
    let of_nrrd = |bytes: Vec<u8>| loaded(&[("a.nrrd", &bytes)], "a.nrrd").expect("a grid");
    let first = of_raw("u8", "", &u8s);
    let volume = &first.volumes[0];
    let [low, high] = volume.field().range();
    assert_eq!((low, high, first.kinds().volumes), ([-8; 3], [8; 3], true));
    assert_eq!(volume.placed().origin, DVec3::new(7.0, 8.0, 9.0));
    assert_eq!(volume.placed().steps, [0.5 * DVec3::X, DVec3::Y, 2.0 * DVec3::Z]);
    // Hat functions of all samples: 10 · (0 + … + 23) / 255, each one world unit large, up to the rounding of sides.
    let mass: f64 = volume.cells().iter().map(|cell| f64::from(cell.density)).sum();
    assert!((mass - 2760.0 / 255.0).abs() < 0.003 * mass, "{mass}");
    for (name, other) in [
        ("u16", of_raw("u16", "", &u16s)),
        ("f32", of_raw("f32", "", &floats)),
        ("big", of_raw("f32", "endian = \"big\"", &big)),
        ("nrrd", of_nrrd(nrrd("uchar", "encoding: raw\n", &u8s))),
        ("nrrd f32", of_nrrd(nrrd("float", "encoding: raw\nendian: little\n", &floats))),
        ("nrrd big", of_nrrd(nrrd("float", "encoding: raw\nendian: big\n", &big))),
        ("nrrd gzip", of_nrrd(nrrd("ushort", "encoding: gzip\nendian: little\n", &zipped(&u16s)))),
    ] {
        let other = &other.volumes[0];
        assert_eq!(other.placed(), volume.placed(), "{name}");
        let near = |(a, b): (&gobo::scene::Caster, &gobo::scene::Caster)| {
            a.position == b.position && (a.density - b.density).abs() < 1e-6
        };
        assert!(other.cells().iter().zip(volume.cells()).all(near), "{name}");
    }
}

#[test]
fn volumes_are_placed_by_scene_files() {
    let placing = "[[volumes]]\nfile = \"a.volume\"\nextinction = 6.0\nscale = 2.0\nrotate = [0, 0, 1, 90]\ntranslate = [1, 2, 3]\n\
        color = [1, 0, 0.5]\ncells = 2\n[light]\nkind = \"directional\"\ndirection = [0, 0, -1]\n\
        [camera]\nposition = [30, 0, 0]\ntarget = [0, 0, 0]\nup = [0, 0, 1]\nfov_y_degrees = 40\n";
    let raw = samples(|v| vec![v]);
    let of = |text: &str| {
        let files = [
            ("a.volume", sidecar("u8", "").into_bytes()),
            ("a.raw", raw.clone()),
            ("s.toml", text.as_bytes().to_vec()),
        ];
        loaded(&files.each_ref().map(|(name, bytes)| (*name, bytes.as_slice())), "s.toml")
    };
    let scene = of(placing).expect("a scene");
    let placed = scene.volumes[0].placed();
    assert!(placed.origin.distance(DVec3::new(-15.0, 16.0, 21.0)) < 1e-12, "{placed:?}");
    assert!(
        placed.steps[0].distance(DVec3::Y) < 1e-12 && placed.steps[1].distance(-2.0 * DVec3::X) < 1e-12,
        "{placed:?}"
    );
    assert_eq!((placed.extinction, placed.color, placed.side), (3.0, [1.0, 0.0, 0.5], 2));
    for (from, to, word) in [
        ("cells = 2", "cells = 3", "1, 2, 4 or 8"),
        ("[1, 0, 0.5]", "[1, 0, 2.0]", "color"),
        ("[0, 0, 1, 90]", "[0, 0, 0, 90]", "no length"),
        ("scale = 2.0", "scale = 0.0", "scale 0"),
        ("extinction = 6.0", "extinction = -6.0", "extinction -3"),
        ("a.volume", "a.vdb", "No such file"),
        ("a.volume", "a.raw", ".nrrd"),
        ("cells = 2", "grid = \"density\"", "one grid"),
    ] {
        let error = of(&placing.replace(from, to)).expect_err(word).to_string();
        assert!(error.contains(word) && !error.contains('\n'), "{error}");
    }
}

/// Each error is one line, whatever a header promises.
#[test]
fn volumes_that_are_wrong_are_named() {
    let raw = samples(|v| vec![v]);
    let volume = |text: String, raw: &[u8]| loaded(&[("a.volume", text.as_bytes()), ("a.raw", raw)], "a.volume");
    let grid = |bytes: Vec<u8>| loaded(&[("a.nrrd", &bytes)], "a.nrrd");
    let floats = |value: f32| [[0; 92].to_vec(), value.to_le_bytes().to_vec()].concat();
    let million = sidecar("u8", "").replace("[3, 2, 4]", "[1000000, 1000000, 1000000]");
    for (found, words) in [
        (volume(sidecar("u8", ""), &raw[..20]), "20 bytes"),
        (volume(sidecar("u16", ""), &raw), "has 48"),
        (volume(sidecar("f32", ""), &floats(-1.0)), "density -1 at [2, 1, 3]"),
        (volume(sidecar("f32", ""), &floats(f32::NAN)), "density NaN"),
        (volume(sidecar("u8", ""), &[0; 24]), "all densities are 0"),
        (volume(million, &raw), "more than 1073741824 samples"),
        (volume(sidecar("u8", "").replace("[3, 2, 4]", "[3, 0, 4]"), &raw), "no samples"),
        (volume(sidecar("i8", ""), &raw), "none of u8, u16 and f32"),
        (volume(sidecar("u8", "endian = \"odd\""), &raw), "neither little nor big"),
        (volume(sidecar("u8", "extinction = 0"), &raw), "extinction 0"),
        (volume(sidecar("u8", "").replace("0.5, 1.0", "0.0, 1.0"), &raw), "world units"),
        (volume(sidecar("u8", "size = 4"), &raw), "duplicate"),
        (grid(b"NRRX".to_vec()), "no NRRD"),
        (grid(nrrd("uchar", "encoding: raw\n", &raw[..9])), "9 bytes of data"),
        (grid(nrrd("uchar", "encoding: hex\n", &raw)), "raw or gzip"),
        (grid(nrrd("int64", "encoding: raw\n", &raw)), "give an integer of up to 32 bits, float or double"),
        (grid(nrrd("float", "encoding: raw\n", &raw)), "no endian"),
        (grid(nrrd("uchar", "encoding: gzip\n", &raw)), "truncated, or damaged"),
        (grid(nrrd("uchar", "data file: b.raw\n", &raw)), "another file"),
        (grid(nrrd("uchar", "sizes: 1000000 1000000 1000000\n", &raw)), "more than 1073741824 samples"),
        (grid(nrrd("uchar", "sizes: 1024 1024 1024\nencoding: gzip\n", &raw)), "bytes of data"),
        (grid(b"NRRD0004\ntype: uchar\n".to_vec()), "no empty line"),
        (loaded(&[("a.vdb", b"")], "a.vdb"), "no OpenVDB file"),
    ] {
        let error = found.map(|scene| scene.name).expect_err(words).to_string();
        assert!(error.contains(words) && !error.contains('\n') && error.contains("/a."), "{words}: {error}");
    }
}
