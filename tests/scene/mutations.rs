//! Damaged files: loaded or refused in one line, never a panic.

use crate::*;
use gobo::scene::Scene;
use proptest::prelude::*;

/// Replaces, inserts or removes bytes, then may cut the end off.
fn mutated(bytes: &[u8], edits: &[(prop::sample::Index, u8, u8)], cut: Option<prop::sample::Index>) -> Vec<u8> {
    let mut bytes = bytes.to_vec();
    for (at, kind, value) in edits {
        let at = at.index(bytes.len());
        match kind % 4 {
            0 => bytes[at] = *value,
            1 => bytes.insert(at, *value),
            2 if bytes.len() > 1 => drop(bytes.remove(at)),
            // Digits keep text well formed, so that the damage reaches deeper than the parser.
            _ => bytes[at] = b'0' + value % 10,
        }
    }
    bytes.truncate(cut.map_or(bytes.len(), |cut| cut.index(bytes.len())));
    bytes
}

fn edits() -> impl Strategy<Value = Vec<(prop::sample::Index, u8, u8)>> {
    prop::collection::vec(any::<(prop::sample::Index, u8, u8)>(), 0..6)
}

/// Loaded or refused in one line; whatever is loaded keeps the promises of the types.
fn check_any(result: gobo::Result<Scene>) {
    match result {
        Ok(scene) => {
            for particle in &scene.particles {
                assert!(particle.position.iter().all(|value| value.is_finite()));
                assert!(particle.radius.is_finite() && particle.radius > 0.0);
                assert!(particle.extinction.is_finite() && particle.extinction >= 0.0);
            }
            for strand in &scene.strands {
                assert!(strand.start.iter().chain(&strand.end).all(|value| value.is_finite()));
                assert!(strand.radius.is_finite() && strand.radius > 0.0 && strand.start != strand.end);
                assert!((0.0..=1.0).contains(&strand.opacity));
            }
            for caster in scene.casters() {
                assert!(caster.axis.iter().all(|value| value.is_finite()));
                assert!((0.0..=80.0).contains(&caster.density) || !caster.is_strand());
            }
            for mesh in &scene.meshes {
                assert!(mesh.positions.iter().flatten().all(|value| value.is_finite()));
                assert!(mesh.triangles.iter().flatten().all(|&index| (index as usize) < mesh.positions.len()));
            }
            assert!(!scene.lights.is_empty());
            for light in &scene.lights {
                assert!(light.radiance.iter().all(|channel| channel.is_finite() && *channel >= 0.0));
                let towards = light.towards(glam::DVec3::new(0.3, 0.2, 0.1));
                assert!(towards.is_finite() && towards.length() < 1.001);
            }
            let view = gobo::scene::View::camera(&scene.camera, &scene, [16, 9]);
            assert!([view.origin, view.right, view.up, view.forward].iter().flatten().all(|value| value.is_finite()));
        }
        Err(error) => assert!(!error.to_string().contains(['\n', '\r']), "{error}"),
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 1500, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn mutated_particles_never_panic(kind in 0..3, edits in edits(), cut: Option<prop::sample::Index>) {
        let rows = [[1.0, -2.5, 3.25, 0.5, 0.75], [0.0, 0.125, -4.0, 2.0, 0.0]];
        let bytes = match kind {
            0 => ascii_ply(&FIELDS, &rows),
            1 => binary_ply(Order::Little, "float", &FIELDS, &rows),
            _ => binary_ply(Order::Big, "double", &["x", "y", "z", "radius", "opacity"], &rows),
        };
        check_any(load_caster("particles", "smoke.ply", &mutated(&bytes, &edits, cut), ""));
    }

    #[test]
    fn mutated_hair_never_panics(kind in 0usize..3, edits in edits(), cut: Option<prop::sample::Index>) {
        let bytes = crate::hair_files::samples()[kind].clone();
        check_any(load_caster("hair", "head.hair", &mutated(&bytes, &edits, cut), ""));
    }

    #[test]
    fn mutated_tressfx_never_panics(kind in 0usize..4, edits in edits(), cut: Option<prop::sample::Index>) {
        let bytes = crate::tressfx_files::samples()[kind].clone();
        check_any(load_caster("hair", "head.tfx", &mutated(&bytes, &edits, cut), ""));
    }

    /// By themselves: what is fitted to damaged files is a camera and a light all the same.
    #[test]
    fn mutated_data_files_never_panic(kind in 0..4, edits in edits(), cut: Option<prop::sample::Index>) {
        let (name, bytes) = match kind {
            0 => ("smoke.ply", ascii_ply(&FIELDS, &[[1.0, -2.5, 3.25, 0.5, 0.75]])),
            1 => ("head.tfx", crate::tressfx_files::samples()[0].clone()),
            2 => ("tri.ply", TRIANGLE_PLY.as_bytes().to_vec()),
            _ => ("leaf.gltf", crate::gltf_lights::sample().into_bytes()),
        };
        check_any(crate::data_files::data_file(name, &mutated(&bytes, &edits, cut)));
    }

    #[test]
    fn mutated_meshes_never_panic(kind in 0..3, edits in edits(), cut: Option<prop::sample::Index>) {
        let (name, bytes) = match kind {
            0 => ("tri.ply", TRIANGLE_PLY.as_bytes().to_vec()),
            1 => ("leaf.gltf", gltf(&data_uri()).into_bytes()),
            _ => ("leaf.glb", glb()),
        };
        check_any(load_caster("meshes", name, &mutated(&bytes, &edits, cut), ""));
    }

    #[test]
    fn mutated_scenes_never_panic(edits in edits(), cut: Option<prop::sample::Index>) {
        let text = format!("[[particles]]\nfile = \"smoke.ply\"\nscale = 2.0\n[[meshes]]\nfile = \"tri.ply\"\n{LIGHT}{CAMERA}");
        let bytes = mutated(text.as_bytes(), &edits, cut);
        check_any(scene_file(&String::from_utf8_lossy(&bytes)));
    }
}
