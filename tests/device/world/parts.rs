//! Only what changed is rebuilt: the passes of a build after each kind of change, for every path of every technique. The look-ups equal
//! those of a technique opened at that point.

use crate::support::{all, every_path, gpu_test, scenes, skipped, spec};
use crate::world::{answers, build, is_exact, largest_difference, names, opened, points, world};
use glam::DVec3;
use gobo::Error;
use gobo::gpu::Context;
use gobo::scene::{Light, LightKind, Particle, Scene, Strand};
use gobo::technique::{self, Name, REGISTRY, Spec, ism};
use gobo::world::World;

/// Parts of a world that the test changes one at a time.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Part {
    Meshes,
    Particles,
    Strands,
    Light,
    Camera,
    /// Color of a light or of a mesh: light and shadow stay in place.
    Color,
    /// Particles leave the box around all casters.
    Box,
}

use Part::{Box, Camera, Color, Light as OneLight, Meshes, Particles, Strands};

/// Smoke and hair between a ground and a lid to one side, with a plate amid them, under two lights of a kind that the technique supports.
fn all_of_it(spec: &Spec) -> Scene {
    let smoke = |i: u8| Particle {
        position: [0.1 * f32::from(i) - 0.5, 0.3, 0.05 * f32::from(i)],
        radius: 0.2,
        extinction: 2.0,
    };
    let mut scene = scenes::directional("all of it", [0.3, 0.2, -0.9], (0..10).map(smoke).collect());
    let hair = |i: u8| {
        let x = 0.08 * f32::from(i) - 0.4;
        Strand { start: [x, -0.4, 0.8], radius: 0.03, end: [x + 0.1, -0.5, -0.6], opacity: 0.7 }
    };
    scene.strands = (0..10).map(hair).collect();
    let plates = [(-1.2, 2.0, [0.0, 0.0]), (1.4, 0.3, [1.6, 1.6]), (0.1, 0.3, [0.6, -0.5])];
    scene.meshes = plates.map(|(height, half, at)| scenes::level(height, half, at)).to_vec();
    let light = |kind| Light { kind, radiance: [1.0; 3], radius: f64::INFINITY };
    let seen_from = |position: DVec3, normal| light(LightKind::Virtual { position, normal, nearest: 0.05 });
    let position = DVec3::new(0.5, -0.6, 3.0);
    scene.lights = match spec.entry.name {
        "ism" => {
            vec![seen_from(DVec3::new(0.1, 0.2, 1.3), DVec3::NEG_Z), seen_from(DVec3::new(-1.0, 0.3, 0.9), DVec3::X)]
        }
        _ => vec![scene.lights[0], light(LightKind::Spot { position, direction: DVec3::NEG_Z, cone_degrees: 70.0 })],
    };
    scene
}

/// Returns the scene after one change.
fn after(part: Part, before: &Scene) -> Scene {
    let mut scene = before.clone();
    match part {
        Meshes => scene.meshes[2].positions.iter_mut().for_each(|p| p[1] += 0.4),
        Particles => scene.particles.iter_mut().for_each(|p| p.position[0] += 0.3),
        Strands => scene.strands.iter_mut().for_each(|s| (s.start[1], s.end[1]) = (s.start[1] + 0.3, s.end[1] + 0.3)),
        OneLight => {
            let turned = DVec3::new(-0.5, 0.3, -0.8).normalize();
            match &mut scene.lights[1].kind {
                LightKind::Directional { direction } => *direction = turned,
                LightKind::Spot { position, .. }
                | LightKind::Virtual { position, .. }
                | LightKind::Point { position } => {
                    position.y += 0.2;
                }
            }
        }
        Camera => scene.camera.position += DVec3::new(0.2, -0.9, 0.4),
        Color => scene.lights[0].radiance = [0.3, 0.2, 0.1],
        Box => scene.particles[0].position[2] = 2.5,
    }
    scene
}

/// Returns whether a pass depends on the changed part: in techniques that cast from it all passes do, except these.
fn depends(spec: &Spec, pass: &str, part: Part) -> bool {
    let casters = [Particles, Strands, Box];
    let any = |parts: &[Part]| parts.contains(&part);
    let starts = |with: &[&str]| with.iter().any(|with| pass.starts_with(with));
    let casts = spec.entry.casts;
    let cast = match part {
        Particles | Box => casts.particles,
        Strands => casts.strands,
        Meshes => casts.meshes,
        OneLight | Camera | Color => true,
    };
    if !cast || part == Color {
        return false;
    }
    if part == Camera {
        // Adaptive points also depend on the camera for the choice, but not for their possible positions.
        return spec.settings::<ism::Settings>().adaptive
            && starts(&[
                "ism.adapt",
                "ism.clear",
                "ism.tiled",
                "ism.splat",
                "ism.cull",
                "ism.draw",
                "ism.gather",
                "ism.fill",
            ]);
    }
    match spec.entry.name {
        "voxel-grid" if starts(&["grid.clear_media", "grid.deposit"]) => any(&casters),
        "voxel-grid" => any(&[Meshes, Box]),
        "density-grid" | "optical-depth-grid" if starts(&["maps."]) => any(&[Meshes, OneLight]),
        "density-grid" => any(&casters),
        "marched" if starts(&["grid."]) => any(&casters),
        "marched" if starts(&["marched."]) => any(&casters) || any(&[OneLight]),
        "optical-depth-grid" if starts(&["grid."]) => any(&casters),
        "optical-depth-grid" => any(&casters) || any(&[OneLight]),
        "grid-query" if starts(&["grid.casters"]) => any(&casters),
        "grid-query" => any(&[Meshes, Box]),
        "ray-query" if starts(&["ray_query.boxes"]) => any(&casters),
        "ray-query" => any(&[Meshes]),
        "ism" if starts(&["ism.areas", "ism.scale", "ism.sums", "ism.offsets", "ism.points", "ism.clusters"]) => {
            any(&[Meshes])
        }
        _ if starts(&["maps.opaque"]) => any(&[Meshes, OneLight]),
        _ if starts(&["order."]) => any(&casters) || any(&[OneLight]),
        // These passes draw casters whether or not meshes hide them.
        "uncompressed" if starts(&["list."]) => !any(&[Meshes]),
        "psm" if starts(&["psm.clear", "psm.voxelize", "psm.propagate"]) => !any(&[Meshes]),
        _ if starts(&["translucency_map.multiply", "beer_shadow_map.blend"]) => !any(&[Meshes]),
        "fourier" | "moments" | "wavelet"
            if starts(&["sums.clear", "sums.ends"]) || [".raster", ".pack"].iter().any(|end| pass.ends_with(end)) =>
        {
            !any(&[Meshes])
        }
        "layers" if starts(&["sums.clear", "sums.ends", "layers.raster", "layers.pack"]) => !any(&[Meshes]),
        "stochastic" if starts(&["stochastic.draw", "stochastic.clear"]) => !any(&[Meshes]),
        _ => true,
    }
}

/// Returns every path that this device runs, including those with evenly spread ISM points.
fn specs(test: &str, context: &Context) -> Vec<Spec> {
    let mut specs = every_path(test, context);
    // Techniques for meshes alone refuse the scene of one sphere with which `every_path` decides.
    for entry in REGISTRY.iter().filter(|entry| entry.casts.meshes && !entry.casts.particles && entry.name != "ism") {
        specs.extend(entry.paths.iter().map(|path| {
            let mut spec = spec(entry.name);
            spec.set(Name::PATH, path.name);
            spec
        }));
    }
    for path in ["tiled", "tiled,adaptive=off", "atomic", "quads"] {
        specs.push(spec(&format!("ism:points=1024,size=32,path={path}")));
    }
    for spec in &mut specs {
        match spec.entry.name {
            "ism" | "voxel-grid" | "grid-query" => {}
            "density-grid" | "optical-depth-grid" => spec.set(Name::SIZE, "64"),
            "voxelized" => spec.set(Name::SIZE, "64"),
            _ => spec.set(Name::SIZE, "28"),
        }
    }
    let runs = |spec: &Spec| match technique::open(context, &world(context, &all_of_it(spec)), spec) {
        Ok(_) => true,
        Err(Error::Refused(needs)) => {
            skipped(test, &format!("{}: needs {needs}", spec.short()));
            false
        }
        Err(error) => panic!("{}: {error}", spec.short()),
    };
    specs.retain(runs);
    specs
}

/// Applies each change in turn, on top of the previous one.
#[test]
fn what_did_not_change_is_not_built() {
    if crate::support::is_costly("what_did_not_change_is_not_built") {
        return;
    }
    let name = "what_did_not_change_is_not_built";
    gpu_test(name, |context| {
        if context.features().timestamp_valid_bits == 0 {
            return skipped(name, "the device has no timestamps");
        }
        let points = points();
        for spec in specs(name, context) {
            let mut scene = all_of_it(&spec);
            let mut world = world(context, &scene);
            let mut moved = opened(context, &world, &spec);
            let first = build(&mut moved, &world, &spec.short()).passes;
            let mut counts = vec![first.len()];
            for part in [Particles, Meshes, Camera, OneLight, Strands, Color, Box] {
                let what = format!("{}, {part:?}", spec.short());
                scene = after(part, &scene);
                world.replace(&scene).expect(&what);
                let passes = build(&mut moved, &world, &what).passes;
                let expected: Vec<_> = names(&first).into_iter().filter(|pass| depends(&spec, pass, part)).collect();
                assert_eq!(names(&passes), expected, "{what}");
                counts.push(passes.len());
                assert!(build(&mut moved, &world, &what).passes.is_empty(), "{what}: once more");

                // Anything that an earlier change wrongly skipped is still missing at the last change.
                if part != Box && !all() {
                    continue;
                }
                let new_world = World::new(context, &scene).expect("room for the scene");
                let mut fresh = opened(context, &new_world, &spec);
                build(&mut fresh, &new_world, &what);
                let [now, then] = [&moved, &fresh].map(|o| answers(context, o.technique.as_ref(), 2, &points));
                let difference = largest_difference(&now, &then);
                assert!(difference <= if is_exact(&spec) { 0.0 } else { 1e-6 }, "{what}: {difference}");
                assert_eq!(moved.technique.inspect().resolution(), fresh.technique.inspect().resolution(), "{what}");
            }
            // Replacing the scene with itself is no change; requesting everything runs all passes except those that follow from the casters
            // alone.
            world.replace(&scene).expect("the same");
            assert!(build(&mut moved, &world, "the same").passes.is_empty(), "{}", spec.short());
            let follows =
                |pass: &str| ["maps.aim", "maps.bounds", "maps.fit"].contains(&pass) || pass.starts_with("order.");
            let mut rest = names(&first);
            rest.retain(|pass| !follows(pass));
            let all = moved.rebuild(&world).expect("built").passes;
            assert_eq!(names(&all), rest, "{}", spec.short());
            println!("{}: {counts:?} passes", spec.short());
        }
    });
}

/// Casters written by the device's own passes are not compared with the host's scene.
#[test]
fn casters_that_the_device_wrote_are_replaced() {
    gpu_test("casters_that_the_device_wrote_are_replaced", |context| {
        let spec = spec("avsm:size=24");
        let scene = all_of_it(&spec);
        let mut world = world(context, &scene);
        let mut avsm = opened(context, &world, &spec);
        build(&mut avsm, &world, "first");
        let before = answers(context, avsm.technique.as_ref(), 2, &points());
        let casters = world.buffers().casters.clone();
        let written = |world: &mut World| {
            // Fills the casters with zeros: no extinction and no radius is left.
            world.write_casters(|commands| commands.pass("test", |pass| pass.fill(&casters, 0))).expect("written");
        };
        written(&mut world);
        build(&mut avsm, &world, "written");
        assert!(answers(context, avsm.technique.as_ref(), 2, &points()) != before, "nothing is gone");
        // Exactly the scene that the host still has.
        world.replace(&scene).expect("the same");
        build(&mut avsm, &world, "replaced");
        assert!(answers(context, avsm.technique.as_ref(), 2, &points()) == before);
    });
}
