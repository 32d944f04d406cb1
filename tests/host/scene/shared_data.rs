//! The project's shared data, if available.

use crate::scene::*;
use crate::support::shared_data;
use glam::DVec3;
use gobo::animate::AnimatedScene;
use gobo::scene::{Particle, Scene, Side, sides};

#[test]
fn shared_scenes_load() {
    let Some(folder) = shared_data("shared_scenes_load") else { return };
    for (file, count) in [("plume_8k", 8_192), ("plume_64k", 65_536)] {
        let scene = load(&folder.join(file).with_extension("toml")).expect("a scene of the project");
        assert_eq!((scene.name.as_str(), scene.particles.len()), (file, count));
        assert!(scene.particles.iter().all(|particle| particle.position[2] < 121.0));
    }
}

#[test]
fn shared_meshes_load() {
    let Some(folder) = shared_data("shared_meshes_load") else { return };
    for (file, vertices, triangles) in [("bunny.ply", 35_947, 69_451), ("terrain.gltf", 10_404, 5_202)] {
        let path = folder.join(file);
        let scene = scene_file(&format!("[[meshes]]\nfile = {path:?}\n{LIGHT}{CAMERA}")).expect("a mesh");
        assert_eq!((scene.meshes[0].positions.len(), scene.meshes[0].triangles.len()), (vertices, triangles));
    }
}

/// Each house must be closed, although houses intersect; leaves and, unless the scene says otherwise, the ground must be open.
#[test]
fn shared_houses_are_closed() {
    let Some(folder) = shared_data("shared_houses_are_closed") else { return };
    let sides_of = |file: &str| sides(&load(&folder.join(file)).expect("a mesh of the project").meshes[0]);
    let houses = sides_of("houses.ply");
    // A box with a pitched roof: 16 triangles.
    assert_eq!(houses, [Side::Outward; 400 * 16]);
    for open in ["leaves.ply", "ground.ply"] {
        let found = sides_of(open);
        assert!(found.len() > 10_000 && found.iter().all(|side| *side == Side::Open), "{open}");
    }
    for file in ["houses.toml", "leaves.toml"] {
        let scene = load(&Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data").join(file)).expect("a scene");
        let solid: Vec<_> = scene.meshes.iter().map(|mesh| (mesh.name.as_str(), mesh.solid)).collect();
        assert_eq!(solid[..2], [("ground", true), ("houses", false)]);
        assert!(sides(&scene.meshes[0]).iter().all(|side| *side == Side::Outward));
    }
}

/// Built-in scenes must match the data: smoke, ground and houses to the byte, leaves in number, the terrain in its heights, and hairs
/// rounded to a hundredth of a segment.
#[test]
fn built_in_scenes_are_those_of_the_data() {
    let Some(folder) = shared_data("built_in_scenes_are_those_of_the_data") else { return };
    let built_in = |name: &str| Scene::load(name, 0.0).expect("built in");
    assert!(built_in("plume_8k") == load(&folder.join("plume_8k.toml")).expect("a scene"));
    let own = |name: &str| load(&Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data").join(name)).expect("a scene");
    assert!(built_in("houses") == own("houses.toml"));
    assert!(built_in("shafts") == own("shafts.toml"));
    let (leaves, real) = (built_in("leaves"), own("leaves.toml"));
    assert!(leaves.meshes[..2] == real.meshes[..2] && leaves.camera == real.camera);
    assert_eq!(leaves.meshes[2].triangles, real.meshes[2].triangles);
    let area = |scene: &Scene| {
        let corner = |i: u32| DVec3::from(scene.meshes[2].positions[i as usize].map(f64::from));
        let of = |t: &[u32; 3]| (corner(t[1]) - corner(t[0])).cross(corner(t[2]) - corner(t[0])).length() * 0.5;
        scene.meshes[2].triangles.iter().map(of).sum::<f64>()
    };
    assert!((area(&leaves) / area(&real) - 1.0).abs() < 0.05, "{} and {}", area(&leaves), area(&real));

    // Extinction times volume must have the same total and the same distribution.
    let (parts, real) =
        (built_in("plume_64k").particles, load(&folder.join("plume_64k.toml")).expect("a scene").particles);
    assert_eq!(parts.len(), real.len());
    let moments = |all: &[Particle]| {
        let dark = |p: &Particle| f64::from(p.radius).powi(3) * f64::from(p.extinction);
        let total: f64 = all.iter().map(dark).sum();
        let moment = |power| {
            [0, 1, 2]
                .map(|axis| all.iter().map(|p| dark(p) * f64::from(p.position[axis]).powi(power)).sum::<f64>() / total)
        };
        (total, moment(1), moment(2))
    };
    let ((total, first, second), (real_total, real_first, real_second)) = (moments(&parts), moments(&real));
    assert!((total / real_total - 1.0).abs() < 1e-3, "{total} and {real_total}");
    for axis in 0..3 {
        assert!((first[axis] / real_first[axis] - 1.0).abs() < 0.02, "{first:?} and {real_first:?}");
        assert!((second[axis] / real_second[axis] - 1.0).abs() < 0.03, "{second:?} and {real_second:?}");
    }

    let (terrain, real) = (built_in("terrain"), load(&folder.join("terrain.gltf")).expect("a scene"));
    let corners = |scene: &Scene| {
        let mesh = &scene.meshes[0];
        let place = |i: u32| mesh.positions[i as usize].map(|along| (f64::from(along) * 1e5).round() as i64);
        let mut all: Vec<_> = mesh
            .triangles
            .iter()
            .map(|t| t.map(place))
            .map(|mut t| {
                let least = (0..3).min_by_key(|i| t[*i]).expect("three");
                t.rotate_left(least);
                t
            })
            .collect();
        all.sort_unstable();
        all
    };
    assert_eq!(corners(&terrain).len(), 5_202);
    let apart = corners(&terrain)
        .iter()
        .flatten()
        .flatten()
        .zip(corners(&real).iter().flatten().flatten())
        .map(|(a, b)| (a - b).abs())
        .max();
    assert!(apart.is_some_and(|apart| apart <= 1), "{apart:?} of 1e-5");

    let (mohawk, real) = (built_in("mohawk"), load(&folder.join("mohawk.tfx")).expect("a scene"));
    assert_eq!(mohawk.strands.len(), real.strands.len());
    for (a, b) in mohawk.strands.iter().zip(&real.strands) {
        let off = (DVec3::from(a.start.map(f64::from)) - DVec3::from(b.start.map(f64::from))).length();
        assert!(off < 1e-4 && (a.radius / b.radius - 1.0).abs() < 1e-3 && a.opacity == b.opacity, "{a:?} and {b:?}");
    }
}

/// The data project's cases of splats and hair.
#[test]
fn shared_cases_of_splats_and_hair_are_right() {
    let Some(folder) = shared_data("shared_cases_of_splats_and_hair_are_right") else { return };
    for (name, count, told) in [
        ("b02-2dgs-without-scale_2.ply", 400, "400 flat splats"),
        ("b02-2dgs-scale_2-minus-infinity.ply", 400, "400 flat splats"),
        ("b03-opacity-minus-infinity-one.ply", 400, ""),
        ("b04-one-row-then-zeros.ply", 1, "splats are left out; splat 1 (the first is 0): rotation"),
        ("b06-filter_3D.ply", 400, "widened by its filter_3D"),
        ("b07-antialiased-flag-v3.spz", 3, "antialiased"),
        ("b07-comment-mip.ply", 400, "antialiased"),
        ("b08-scale-not-logarithms.ply", 400, "larger than a tenth of the scene"),
        ("b13-all-alike-v3.spz", 100_000, ""),
        ("c01-uv-array-bit-5.hair", 200, "1 array beyond the format's five"),
        ("c01-tangents-indices-box-bits-5-6-7.hair", 200, "3 arrays beyond the format's five"),
        ("c03-thickness-0-everywhere.hair", 200, "no width"),
        ("c04-thickness-1-on-a-head-of-20.hair", 200, "wide on a longest side"),
    ] {
        let path = folder.join("cases").join(name);
        let loaded = AnimatedScene::load(path.to_str().expect("UTF-8"), 0.0);
        let loaded = loaded.unwrap_or_else(|error| panic!("{name}: {error}"));
        let found = loaded.scene.splats.len() + loaded.scene.strands.len();
        assert_eq!(found, count, "{name}");
        let notes: Vec<_> = loaded.notes.iter().filter(|note| !note.contains("taken for up")).collect();
        let is_told = if told.is_empty() { notes.is_empty() } else { notes.iter().any(|note| note.contains(told)) };
        assert!(is_told, "{name}: {:?}", loaded.notes);
    }
}

/// The data project's cases of OpenVDB: versions, slightly negative densities, and grids that are no density.
#[test]
fn shared_cases_of_volumes_are_right() {
    let Some(folder) = shared_data("shared_cases_of_volumes_are_right") else { return };
    let path = |name: &str| folder.join("cases").join(name);
    let loaded = |name: &str| AnimatedScene::load(path(name).to_str().expect("UTF-8"), 0.0).expect(name);
    let (old, new) = (loaded("a01-version-224-same.vdb"), loaded("a01-version-225.vdb"));
    assert!(old.scene.volumes == new.scene.volumes && !new.scene.volumes[0].cells().is_empty());
    let negative = loaded("a06-one-tiny-negative.vdb");
    assert!(negative.notes[0].ends_with("1 slightly negative density counts as 0"), "{:?}", negative.notes);
    let mass = |scene: &Scene| {
        let of = |cell: &gobo::scene::Caster| f64::from(cell.density) * f64::from(cell.radius).powi(3);
        let all = || scene.volumes.iter().flat_map(|volume| volume.cells());
        let total: f64 = all().map(of).sum();
        let along = |axis: usize| all().map(|cell| of(cell) * f64::from(cell.position[axis])).sum::<f64>() / total;
        (total, DVec3::new(along(0), along(1), along(2)))
    };
    let (one, middle) = mass(&new.scene);

    // Three of a name, side by side.
    let several = loaded("a04-three-named-density.vdb");
    let origins: Vec<_> = several.scene.volumes.iter().map(|volume| volume.placed().origin.x).collect();
    assert_eq!(origins, [0.0, 4.0, 8.0]);
    assert!(several.notes.iter().any(|note| note.contains("3 grids named density")), "{:?}", several.notes);
    let named = |grid: &str| {
        let path = path("a04-three-named-density.vdb");
        scene_file(&format!("[[volumes]]\nfile = {path:?}\ngrid = {grid:?}\n{LIGHT}{CAMERA}"))
    };
    let second = named("density[1]").expect("the second");
    assert_eq!((second.volumes.len(), second.volumes[0].placed().origin.x), (1, 4.0));
    assert!((mass(&several.scene).0 / mass(&second).0 - 3.0).abs() < 1e-4);
    message(named("density[3]"), "a04-three-named-density.vdb", "no grid density[3]: 3 are named density");

    // Sheared by a degree: all mass is there, and its middle is where the map has it.
    let sheared = loaded("a10-sheared-1-degree.vdb");
    assert!(sheared.notes.iter().any(|note| note.contains("1.0 degrees off right angles")), "{:?}", sheared.notes);
    let (found, place) = mass(&sheared.scene);
    assert!((found / one - 1.0).abs() < 1e-3, "{found} and {one}");
    let tangent = 1f64.to_radians().tan();
    let by_axes = [[1, 0], [2, 0], [0, 1], [2, 1], [0, 2], [1, 2]];
    let nearest = by_axes.map(|[from, to]| {
        let mut moved = middle;
        moved[to] += tangent * middle[from];
        (moved - place).length()
    });
    assert!(nearest.iter().any(|off| *off < 1e-3 * (1.0 + middle.length())), "{place} for {middle}: {nearest:?}");

    // Numbers of a scanner: what density they are is for the user to say.
    let name = "a14-short-hounsfield.nrrd";
    message(load(&path(name)), name, "window = [-1000.0, 400.0] of [[volumes]]");
    let scene =
        scene_file(&format!("[[volumes]]\nfile = {:?}\nwindow = [-1000.0, 400.0]\n{LIGHT}{CAMERA}", path(name)));
    assert_eq!(scene.expect("a window").volumes.len(), 1);
    let name = "a08-frame-with-temperature-alone.vdb";
    message(load(&path(name)), name, "its only grid of floats, temperature, is no density");
    let text = format!("[[volumes]]\nfile = {:?}\ngrid = \"temperature\"\n{LIGHT}{CAMERA}", path(name));
    assert_eq!(scene_file(&text).expect("asked for").volumes.len(), 1);
}
