//! The project's own data, where it is there.

use crate::support::shared_data;
use crate::*;
use gobo::scene::{Side, sides};

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

/// Houses are closed, one by one, although they stand in each other; leaves and, unless it says so, the ground are open.
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
