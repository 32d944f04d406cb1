//! The shaded picture, lit by the truth. Twin: glsl/consume/ with glsl/consume/shading.glsl.

use super::casters::{Casters, optical_depth, overlap};
use super::grid::Grid;
use super::meshes::Hit;
use crate::scene::{Caster, LightKind, Picture, Ray, SKY, Scene, View, far_to_near};
use glam::{DVec2, DVec3};
use rayon::prelude::*;

/// Twin: PARTICLE_ALBEDO.
const PARTICLE_ALBEDO: DVec3 = DVec3::new(0.92, 0.92, 0.95);
/// Twin: STRAND_ALBEDO.
const STRAND_ALBEDO: DVec3 = DVec3::new(0.70, 0.42, 0.20);
/// Twin: AMBIENT.
const AMBIENT: DVec3 = DVec3::new(0.10, 0.12, 0.15);

/// Pixels a side of a grid cell, which only finds candidates.
const CELL_PIXELS: u32 = 8;

/// Renders `scene` as `camera` sees it. Casters are blended from far to near by the z of their middles, as the
/// device draws them.
pub fn picture(casters: &Casters, scene: &Scene, camera: &View) -> Picture {
    camera_rays(casters, scene, camera, &far_to_near(scene, camera), |_, index, position| {
        light(casters, scene, position, lift(&casters.all[index as usize]), |_| 1.0)
    })
}

/// How many casters [`picture`] would try against rays, by a coarse picture of the same view: what it costs.
pub fn picture_tests(casters: &Casters, scene: &Scene, camera: &View) -> f64 {
    let small = View { width: 32, height: 18, ..*camera };
    let tests = std::sync::atomic::AtomicUsize::new(0);
    let order: Vec<u32> = (0..casters.all.len() as u32).collect();
    camera_rays(casters, scene, &small, &order, |_, _, position| {
        let shining = (0..scene.lights.len()).filter(|light| scene.lights[*light].shines_on(position));
        let all = shining.map(|light| casters.candidates(light, position)).sum();
        tests.fetch_add(all, std::sync::atomic::Ordering::Relaxed);
        DVec3::ZERO
    });
    tests.into_inner() as f64 * camera.texels() as f64 / small.texels() as f64
}

/// A ray a pixel through casters in this order; what arrives at a caster is `light` of the pixel, the caster's index and
/// the middle of what the ray sees of it.
pub(in crate::reference) fn camera_rays(
    casters: &Casters,
    scene: &Scene,
    camera: &View,
    order: &[u32],
    light: impl Fn(DVec2, u32, DVec3) -> DVec3 + Sync,
) -> Picture {
    let cells =
        View { width: camera.width.div_ceil(CELL_PIXELS), height: camera.height.div_ceil(CELL_PIXELS), ..*camera };
    let grid = Grid::new(&cells, &casters.all, order);
    let share =
        DVec2::new(cells.width.into(), cells.height.into()) / DVec2::new(camera.width.into(), camera.height.into());
    let pixels = (0..camera.width * camera.height)
        .into_par_iter()
        .map(|i| {
            let at = DVec2::new(f64::from(i % camera.width) + 0.5, f64::from(i / camera.width) + 0.5);
            let light = |index, position| light(at, index, position);
            pixel(casters, scene, camera, &camera.ray(at), grid.at(at * share), light).as_vec3().into()
        })
        .collect();
    Picture { width: camera.width, height: camera.height, pixels }
}

fn pixel(
    casters: &Casters,
    scene: &Scene,
    camera: &View,
    ray: &Ray,
    candidates: &[u32],
    light: impl Fn(u32, DVec3) -> DVec3,
) -> DVec3 {
    let mut color = DVec3::from(SKY.map(f64::from));
    let mut farthest = f64::from(camera.far);
    if let Some(hit) = casters.meshes.hit(ray.origin, ray.direction)
        && hit.distance < farthest
    {
        farthest = hit.distance;
        color = surface(casters, scene, ray.at(hit.distance), &hit);
    }
    for &i in candidates {
        let caster = &casters.all[i as usize];
        let Some((entry, exit)) = overlap(ray, caster) else { continue };
        let (entry, exit) = (entry.max(camera.near.into()), exit.min(farthest));
        if exit < entry {
            continue;
        }
        let opacity = 1.0 - (-optical_depth(ray, caster, entry, exit)).exp();
        let light = light(i, ray.at(0.5 * (entry + exit)));
        let albedo = if caster.is_strand() { STRAND_ALBEDO } else { PARTICLE_ALBEDO };
        color = albedo * (ambient(scene) + light) * opacity + color * (1.0 - opacity);
    }
    color
}

fn surface(casters: &Casters, scene: &Scene, position: DVec3, hit: &Hit) -> DVec3 {
    let light = light(casters, scene, position, 0.0, |towards| hit.normal.dot(towards).abs());
    DVec3::from(hit.albedo.map(f64::from)) * (ambient(scene) + light)
}

/// What arrives from all sides; nothing where lights are virtual, which are what arrives. Twin: ambient.
fn ambient(scene: &Scene) -> DVec3 {
    match scene.lights.first().map(|light| light.kind) {
        Some(LightKind::Virtual { .. }) => DVec3::ZERO,
        _ => AMBIENT,
    }
}

/// How far towards the light a caster asks for it.
pub(in crate::reference) fn lift(caster: &Caster) -> f64 {
    if caster.is_strand() { 2.0 * f64::from(caster.radius) } else { 0.0 }
}

/// What arrives from all lights, each times `turn` of the direction towards it and asked for `lift` towards it (twin:
/// lit_side).
pub(in crate::reference) fn light(
    casters: &Casters,
    scene: &Scene,
    position: DVec3,
    lift: f64,
    turn: impl Fn(DVec3) -> f64,
) -> DVec3 {
    let mut sum = DVec3::ZERO;
    for (i, light) in scene.lights.iter().enumerate().filter(|(_, light)| light.shines_on(position)) {
        let radiance = DVec3::from(light.radiance.map(f64::from)) * light.falloff(position);
        let towards = light.towards(position);
        let turned = turn(towards);
        if turned > 0.0 {
            sum += radiance * turned * casters.visibility(i, position + lift * towards);
        }
    }
    sum
}
