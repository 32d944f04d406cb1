//! Virtual point lights: what a light sees, the flux that leaves it, which patches are drawn, and the resulting lights.

mod drawn;
mod stable;
mod viewed;

use crate::support::scenes::{self, level};
use crate::support::{gpu_test, some};
use glam::{DVec2, DVec3, Vec3Swizzles};
use gobo::bench::Status;
use gobo::gpu::{Context, Requirement};
use gobo::lights::indirect::{VPLS, Vpls, VplsBy, VplsSeen, lit_by_vpls};
use gobo::reference::truth::Casters;
use gobo::reference::twin::indirect::{Facet, Patch, light, luminance, patch, place, unit};
use gobo::scene::{Light, LightKind, Mesh, Reserve, Scene, Side, sides};
use gobo::world::World;
use std::f64::consts::PI;

fn made(context: &Context, scene: &Scene, count: u32) -> Vpls {
    let world = World::new(context, scene).expect("room for the scene");
    let mut vpls = crate::support::opened(Vpls::new(context, &world, count), &scene.name);
    vpls.make(&world).expect("made");
    vpls
}

fn seen(context: &Context, scene: &Scene, count: u32) -> VplsSeen {
    made(context, scene, count).seen().expect("read")
}

/// A scene of meshes alone under these lights.
fn lit(name: &str, meshes: Vec<Mesh>, kinds: &[LightKind]) -> Scene {
    let light = |(i, kind): (usize, &LightKind)| Light {
        kind: *kind,
        radiance: [[1.0, 0.75, 0.5], [0.25, 0.5, 1.0], [0.5, 1.0, 0.25]][i % 3],
        radius: if i == 1 { 9.0 } else { f64::INFINITY },
    };
    let lights = kinds.iter().enumerate().map(light).collect();
    Scene { name: name.into(), meshes, lights, ..scenes::directional(name, [0.0, 0.0, -1.0], vec![]) }
}

/// A square ground of this albedo, with half-extent 2.
fn plane(albedo: [f32; 3]) -> Mesh {
    Mesh { albedo, ..level(0.0, 2.0, [0.0, 0.0]) }
}

const RED: [f32; 3] = [0.8, 0.2, 0.1];

/// Scenes with all kinds of light over closed boxes and open leaves, and the plain room.
fn cases() -> Vec<Scene> {
    let mut all = Scene::load("cornell", 0.0).expect("built in");
    all.name = "all kinds".into();
    let slanted = DVec3::new(0.2, 0.9, -0.5).normalize();
    let kinds = [
        LightKind::Directional { direction: slanted },
        LightKind::Point { position: DVec3::new(0.5, -0.1, 1.5) },
        LightKind::Spot { position: DVec3::new(-0.6, -0.8, 1.9), direction: slanted, cone_degrees: 70.0 },
    ];
    all.lights = lit("", vec![], &kinds).lights;
    // An open leaf that the lights see from below and from above.
    all.meshes.push(Mesh { albedo: RED, ..level(0.9, 0.2, [0.7, -0.6]) });
    let cornell = Scene::load("cornell", 0.0).expect("built in");
    let mut ground = plane(RED);
    ground.positions.iter_mut().for_each(|p| *p = [p[0] + 4000.0, p[1] + 9000.0, p[2] + 800.0]);
    let direction = DVec3::new(0.0, -3.0, -5.0).normalize();
    let kind = LightKind::Spot { position: DVec3::new(4000.0, 9003.0, 805.0), direction, cone_degrees: 30.0 };
    let away = lit("far from the origin", vec![ground], &[kind]);
    vec![all, cornell, away]
}

fn facets(scene: &Scene) -> Vec<Facet> {
    let vec = |v: [f32; 3]| DVec3::from(v.map(f64::from));
    let of = |m: &Mesh| -> Vec<Facet> {
        let facet = |(t, side): (&[u32; 3], Side)| Facet {
            corners: t.map(|i| vec(m.positions[i as usize])),
            albedo: vec(m.albedo),
            side: side.sign(),
        };
        m.triangles.iter().zip(sides(m)).map(facet).collect()
    };
    scene.meshes.iter().flat_map(of).collect()
}

/// Returns the light and the face of each map.
fn owners(scene: &Scene) -> Vec<(usize, usize)> {
    let of = |(light, shining): (usize, &Light)| (0..shining.map_count()).map(move |face| (light, face)).collect();
    scene.lights.iter().enumerate().flat_map::<Vec<_>, _>(of).collect()
}

/// Returns the twin's patch of each texel, for the triangles that the device saw.
fn patches(scene: &Scene, seen: &VplsSeen) -> Vec<Option<Patch>> {
    let (facets, owners) = (facets(scene), owners(scene));
    let of = |texel: usize| {
        let (map, at) = place(texel as u32, seen.side_bits);
        let met = seen.triangles[texel];
        let (light, face) = owners[map];
        patch(&seen.maps[map].opaque, &scene.lights[light], face, facets.get(met.checked_sub(1)? as usize)?, at)
    };
    (0..seen.fluxes.len()).map(of).collect()
}

/// Each texel holds the triangle that its light sees there in f64, except at edges, where the rasterizer decides.
#[test]
fn maps_hold_what_a_light_sees() {
    gpu_test("maps_hold_what_a_light_sees", |context| {
        for scene in some(cases(), 2) {
            let seen = seen(context, &scene, 64);
            let (casters, facets) = (Casters::new(&scene), facets(&scene));
            let side = 1usize << seen.side_bits;
            let (mut off, mut met) = (0, 0);
            for texel in (0..seen.triangles.len()).step_by(7) {
                let (map, x, y) = (texel / (side * side), texel % side, texel / side % side);
                let view = &seen.maps[map].opaque;
                let ray = view.ray(DVec2::new(x as f64 + 0.5, y as f64 + 0.5));
                let (near, far) = (f64::from(view.near), f64::from(view.far));
                let hit = casters.meshes.hit(ray.at(near), ray.direction).filter(|hit| near + hit.distance < far);
                let shown = (seen.triangles[texel] as usize).checked_sub(1).and_then(|i| facets.get(i));
                let agrees = match (hit, shown) {
                    (None, None) => true,
                    (Some(hit), Some(facet)) => {
                        let albedo = facet.albedo.as_vec3().to_array();
                        let [a, b, c] = facet.corners;
                        let normal = (b - a).cross(c - a).normalize();
                        let z = (a - ray.origin).dot(normal) / ray.direction.dot(normal);
                        albedo == hit.albedo && (z - near - hit.distance).abs() < 1e-3 * far
                    }
                    _ => false,
                };
                (off, met) = (off + usize::from(!agrees), met + usize::from(hit.is_some()));
            }
            println!("{}: {off} of {met} texels", scene.name);
            assert!(met > 1000 && off * 50 < met, "{}: {off} of {met} texels", scene.name);
        }
    });
}

/// Each texel's flux, up to float rounding, the largest flux, and the lights of the drawn texels all equal the twin's.
#[test]
fn flux_and_lights_equal_their_twin() {
    gpu_test("flux_and_lights_equal_their_twin", |context| {
        for scene in cases() {
            let vpls = made(context, &scene, 512);
            let seen = vpls.seen().expect("read");
            let patches = patches(&scene, &seen);
            let (mut off, mut lit) = (0, 0);
            for (device, twin) in seen.fluxes.iter().zip(&patches) {
                let twin = twin.as_ref().map_or(0.0, |p| luminance(p.flux));
                lit += usize::from(twin > 0.0);
                // Texels at the edge of a light's cone or cube face may differ.
                off += usize::from((f64::from(*device) - twin).abs() > 1e-4 * twin);
            }
            println!("{}: {off} of {lit} lit texels differ", scene.name);
            assert!(lit > 2000 && off * 2000 < lit, "{}: {off} of {lit}", scene.name);
            let most = seen.fluxes.iter().fold(0.0f32, |most, flux| most.max(*flux));
            assert_eq!(seen.greatest, most.to_bits());

            let [low, high] = *seen.starts.last().expect("all");
            let all = (f64::from(high) * 2f64.powi(32) + f64::from(low)) * f64::from(unit(most));
            let share = all / f64::from(seen.picks.len() as u32);
            for (i, (pick, made)) in seen.picks.iter().zip(vpls.read().expect("read")).enumerate() {
                let patch = patches[*pick as usize].as_ref().expect("it has flux");
                let (map, _) = place(*pick, seen.side_bits);
                let origin = DVec3::from(seen.maps[map].opaque.origin.map(f64::from));
                let twin = light(patch, origin, luminance(patch.flux), share);
                let (
                    LightKind::Virtual { position, normal, nearest },
                    LightKind::Virtual { position: at, normal: towards, nearest: within },
                ) = (twin.kind, made.kind)
                else {
                    panic!("{made:?} is no virtual light")
                };
                let scale = position.abs().max_element() + 1.0;
                assert!((position - at).length() < 2e-6 * scale, "{}, {i}: {position} {at}", scene.name);
                assert!((normal - towards).length() < 1e-5 && (nearest / within - 1.0).abs() < 1e-3, "{i}: {made:?}");
                for (twin, made) in twin.radiance.iter().zip(made.radiance) {
                    assert!((twin - made).abs() <= 1e-4 * twin, "{}, {i}: {twin} {made}", scene.name);
                }
                let data = seen.lights[i];
                assert_eq!((data.kind, data.first_map, data.map_count, data.has_opaque), (3, 6 * i as u32, 6, 1));
                assert_eq!(data.cos_cone, 0.0);
            }
        }
    });
}

/// Returns the total radiance of all lights, per channel.
fn sum(lights: &[Light]) -> DVec3 {
    lights.iter().map(|l| DVec3::from(l.radiance.map(f64::from))).sum()
}

/// The virtual lights' total radiance is 1/π times the flux that a plane or the walls of a room reflect, in closed form.
#[test]
fn all_flux_is_kept() {
    gpu_test("all_flux_is_kept", |context| {
        let directional = |x: f64| LightKind::Directional { direction: DVec3::new(x, 0.3, -1.0).normalize() };
        let (height, degrees) = (1.5, 80.0f64);
        let spot = LightKind::Spot { position: DVec3::Z * height, direction: DVec3::NEG_Z, cone_degrees: degrees };
        let radius = height * (degrees.to_radians() / 2.0).tan();
        // A disc: the integral of h / sqrt(h² + r²).
        let disc = 2.0 * PI * height * (height.hypot(radius) - height);
        // One side of a cube of half-extent 2 around the light: the same integral over a square, by the midpoint rule.
        let steps = 600;
        let middle = |i: u32| (f64::from(i) + 0.5) / f64::from(steps) * 4.0 - 2.0;
        let square = |(x, y): (f64, f64)| 2.0 / (4.0 + x * x + y * y).sqrt() * (4.0 / f64::from(steps)).powi(2);
        let side: f64 = (0..steps).flat_map(|i| (0..steps).map(move |j| square((middle(i), middle(j))))).sum();
        let walls: Vec<Mesh> = [DVec3::X, DVec3::Y, DVec3::Z]
            .into_iter()
            .flat_map(|axis| [axis, -axis])
            .map(|out| {
                let (u, v) = (out.zxy(), out.yzx());
                let corner = |[x, y]: [f64; 2]| (2.0 * out + 2.0 * x * u + 2.0 * y * v).as_vec3().to_array();
                let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].map(corner);
                Mesh { albedo: RED, ..scenes::quad(corners, 0.0) }
            })
            .collect();
        let point = LightKind::Point { position: DVec3::ZERO };
        // The plane intercepts rays over 16 square units, times the cosine.
        let slant = |x: f64| 16.0 / (x * x + 0.09 + 1.0).sqrt();
        for (name, meshes, kind, crossed) in [
            ("overhead", vec![plane(RED)], directional(0.0), slant(0.0)),
            ("slanted", vec![plane(RED)], directional(1.3), slant(1.3)),
            ("spot", vec![plane(RED)], spot, disc),
            ("room", walls, point, 6.0 * side),
        ] {
            let scene = lit(name, meshes, &[kind]);
            let expected = DVec3::from(RED.map(f64::from)) * DVec3::new(1.0, 0.75, 0.5) * crossed / PI;
            for count in [64, 1000, 4096] {
                let all = sum(&made(context, &scene, count).read().expect("read"));
                let off = (all / expected - 1.0).abs().max_element();
                println!("{name}, {count}: {all}, {off:.1e} off");
                // A texel at the rim of a cone counts entirely or not at all.
                assert!(off < 1e-3, "{name}, {count}: {all}, and {expected} in closed form");
            }
        }
    });
}

/// With many colors, the total of each channel is preserved on average, and luminance exactly.
#[test]
fn colors_are_kept_on_average() {
    gpu_test("colors_are_kept_on_average", |context| {
        let scene = Scene::load("cornell", 0.0).expect("built in");
        let count = 4096;
        let vpls = made(context, &scene, count);
        let patches = patches(&scene, &vpls.seen().expect("read"));
        let flux: DVec3 = patches.iter().flatten().map(|p| p.flux).sum();
        let all = sum(&vpls.read().expect("read"));
        println!("{all} of {flux}");
        assert!((luminance(all) / luminance(flux) - 1.0).abs() < 1e-3);
        // With random draws, a channel's standard error would be its spread over the square root of the count.
        for i in 0..3 {
            let ratio = |p: &Patch| p.flux[i] / luminance(p.flux) - flux[i] / luminance(flux);
            let spread: f64 =
                patches.iter().flatten().filter(|p| p.flux.x > 0.0).map(|p| luminance(p.flux) * ratio(p).powi(2)).sum();
            let error = (spread / luminance(flux) / f64::from(count)).sqrt() * luminance(flux);
            assert!((all[i] - flux[i]).abs() < 2.0 * error, "channel {i}: {} of {}, {error}", all[i], flux[i]);
        }
    });
}

#[test]
fn a_scene_is_lit_by_them() {
    gpu_test("a_scene_is_lit_by_them", |context| {
        let cornell = Scene::load("cornell", 0.0).expect("built in");
        let lit_by = lit_by_vpls(context, &cornell, 256, VplsBy::Flux).expect("lit");
        assert_eq!(
            (lit_by.lights.len(), &*lit_by.name, &lit_by.reserve),
            (256, "cornell-256-vpls", &Reserve::default())
        );
        assert_eq!((&lit_by.meshes, lit_by.camera), (&cornell.meshes, cornell.camera));
        assert_eq!(lit_by, lit_by_vpls(context, &cornell, 256, VplsBy::Flux).expect("lit"), "the same each time");
        // Each light is in the room's air, on a side of a surface that faces the lamp.
        let casters = Casters::new(&cornell);
        let mut hidden = 0;
        for light in &lit_by.lights {
            let LightKind::Virtual { position, normal, nearest } = light.kind else { panic!("{light:?}") };
            assert!(normal.is_normalized() && nearest > 1e-3 && nearest < 0.5, "{light:?}");
            assert!(cornell.lights[0].shines_on(position) && cornell.lights[0].towards(position).dot(normal) > 0.0);
            hidden += usize::from(!casters.unblocked(0, position));
        }
        // The rasterizer decides at edges.
        assert!(hidden <= 2, "{hidden} are in the lamp's shadow");

        let mut dark = cornell.clone();
        dark.lights[0].radiance = [0.0; 3];
        for (scene, count, words) in [
            (&dark, 64, "reaches a mesh"),
            (&scenes::random(), 64, "no mesh"),
            (&cornell, 63, "64 to 4096"),
            (&cornell, 4097, "64 to 4096"),
        ] {
            let error = lit_by_vpls(context, scene, count, VplsBy::Flux).expect_err("refused").to_string();
            assert!(error.contains(words) && !error.contains('\n'), "{error}");
        }
        assert_eq!((*VPLS.start(), *VPLS.end()), (64, 4096));
        // The device does not check whether any light reaches a mesh: the virtual lights are black.
        for light in made(context, &dark, 64).read().expect("read") {
            let LightKind::Virtual { position, normal, nearest } = light.kind else { panic!("{light:?}") };
            assert!(light.radiance == [0.0; 3] && position.is_finite() && normal.is_normalized() && nearest > 0.0);
        }
    });
}

/// In one run, each technique that shadows with meshes is queried for the same virtual lights: grids and rays are right outside their
/// boundary, and small maps are hardly ever wrong.
#[test]
fn techniques_answer_for_the_same_lights() {
    gpu_test("techniques_answer_for_the_same_lights", |context| {
        let cornell = Scene::load("cornell", 0.0).expect("built in");
        let scene = lit_by_vpls(context, &cornell, 64, VplsBy::Flux).expect("lit");
        let mut specs = vec!["voxel-grid:size=64", "shadow-map:size=16"];
        if context.features().lacks(Requirement::RayQuery).is_none() {
            specs.push("ray-query");
        }
        for (spec, row) in specs.iter().zip(crate::support::rows(context, &scene, &specs)) {
            if !spec.starts_with("shadow-map") {
                // Reach of the boundary: a voxel along each axis, and the same distance off a surface; rays are exact.
                let voxel = crate::support::within::diagonal(&scene) / 62.0;
                let reach = if *spec == "ray-query" { 0.0 } else { 3f64.sqrt() * voxel };
                crate::support::assert_right_beyond_the_resolution(&scene, row, 20_000, [reach, 2.0 * reach]);
                continue;
            }
            // The depth bias is the change of a surface's depth over a texel, of 7° here: on oblique surfaces it exceeds a wall's
            // thickness, and the wall's other side is lit.
            assert_eq!(row.status, Status::Ok, "{}", row.reason);
            let error = row.error.expect("a truth");
            let beyond = |points: gobo::bench::PointError| points.beyond()?.mean_abs;
            let [space, surface] = [error.space, error.surface].map(|points| points.and_then(beyond));
            println!("{spec}: {space:?} in space, {surface:?} on surfaces");
            assert!(space.is_some_and(|e| e < 3e-3) && surface.is_some_and(|e| e < 0.15), "{error:?}");
        }
    });
}
