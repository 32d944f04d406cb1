//! The project's own data, where it is there.

use crate::support::shared_data;
use crate::*;

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
