//! Limits listed by `requirements` match those for which a technique is refused if the device has one less.

use crate::support::{log, scenes, skipped, spec};
use glam::DVec3;
use gobo::gpu::{Context, Limit, Options, Testing};
use gobo::scene::{Light, LightKind, Particle, Scene};
use gobo::technique::{self, REGISTRY, Spec, requirements};
use gobo::world::World;

/// Everything that some technique casts from, under a light that it supports.
fn scene(spec: &Spec) -> Scene {
    let mut scene = scenes::opaque();
    scene.meshes.push(scenes::level(-1.5, 2.0, [0.0, 0.0]));
    scene.particles.push(Particle { position: [0.0; 3], radius: 1.0, extinction: 1.0 });
    if spec.entry.name == "ism" {
        let kind = LightKind::Virtual { position: DVec3::new(0.0, 0.0, 3.0), normal: DVec3::NEG_Z, nearest: 0.1 };
        scene.lights = vec![Light { kind, radiance: [1.0; 3], radius: f64::INFINITY }];
    }
    scene
}

/// Returns why a spec is refused on a device whose limit is one less, or `None` if it opens.
fn refused(spec: &Spec, limit: Limit) -> Option<String> {
    Testing::just_below(limit, || {
        let context = match Context::new(&Options::default()) {
            Ok(context) => context,
            Err(error) => return Some(error.to_string()),
        };
        let world = World::new(&context, &scene(spec)).expect("room");
        technique::open(&context, &world, spec).err().map(|error| error.to_string())
    })
}

/// Refusals name each limit of each path, with default settings; limits common to all paths are tested once.
#[test]
fn one_less_than_a_limit_is_refused_by_its_name() {
    const TEST: &str = "one_less_than_a_limit_is_refused_by_its_name";
    gobo::cli::test_hooks();
    let (device, mut asked) = (Context::new(&Options::default()).expect("a device"), Vec::new());
    for (entry, path) in REGISTRY.iter().copied().flat_map(|entry| entry.paths.iter().map(move |path| (entry, path))) {
        let key = if entry.name == "shadow-map" { "opaque" } else { "path" };
        let text = match entry.keys.iter().any(|has| has.name == key) {
            true => format!("{}:{key}={}", entry.name, path.name),
            false => entry.name.to_owned(),
        };
        let (spec, features) = (spec(&text), device.features());
        let of_path: Vec<_> = requirements(&spec).into_iter().filter(|wants| wants.path == path.name).collect();
        let [wants] = &of_path[..] else { panic!("{text}: {of_path:?}") };
        let lacks = path.requires.iter().find_map(|r| features.lacks(*r)).map(str::to_owned);
        if let Some(lacks) = lacks
            .or_else(|| wants.limits.iter().find_map(|limit| limit.lacks(features, "")).map(|needs| needs.to_string()))
        {
            skipped(TEST, &format!("{text}: needs {lacks}"));
            continue;
        }
        for limit in &wants.limits {
            if Limit::FLOOR.contains(limit) && asked.contains(&limit.name) {
                continue;
            }
            let said = refused(&spec, *limit).unwrap_or_else(|| panic!("{text} opens with less of {limit:?}"));
            assert!(said.contains(limit.name), "{text}, {limit:?}: {said}");
            asked.push(limit.name);
        }
    }
    if !["GOBO_TEST_LIMITS", "GOBO_TEST_FEATURES"].iter().any(|name| std::env::var_os(name).is_some()) {
        assert!(asked.contains(&"maxComputeSharedMemorySize") && asked.len() > 6, "{asked:?}");
    }
    log("exercised", TEST, &format!("{}, {} limits", device.features().name, asked.len()));
}
