//! The shaded picture, lit by the truth. Twin: glsl/consume/ with glsl/common/shading.glsl.

use super::casters::overlap;
use super::grid::Grid;
use super::{Casters, Hit};
use crate::scene::{LightKind, Picture, Ray, Scene, View};
use glam::{DVec2, DVec3};
use rayon::prelude::*;

/// Twin: PARTICLE_ALBEDO.
const PARTICLE_ALBEDO: DVec3 = DVec3::new(0.92, 0.92, 0.95);
/// Twin: AMBIENT.
const AMBIENT: DVec3 = DVec3::new(0.10, 0.12, 0.15);
/// What the camera sees where nothing is, linear RGB.
pub const SKY: [f32; 3] = [0.16, 0.22, 0.32];

/// Pixels a side of a grid cell, which only finds candidates.
const CELL_PIXELS: u32 = 8;

/// Renders `scene` as `camera` sees it. Particles are blended from far to near by the z of their centres, as the
/// device draws them.
pub fn picture(casters: &Casters, scene: &Scene, camera: &View) -> Picture {
    let cells =
        View { width: camera.width.div_ceil(CELL_PIXELS), height: camera.height.div_ceil(CELL_PIXELS), ..*camera };
    let grid = Grid::new(&cells, &scene.particles, &far_to_near(scene, camera));
    let share =
        DVec2::new(cells.width.into(), cells.height.into()) / DVec2::new(camera.width.into(), camera.height.into());
    let pixels = (0..camera.width * camera.height)
        .into_par_iter()
        .map(|i| {
            let at = DVec2::new(f64::from(i % camera.width) + 0.5, f64::from(i / camera.width) + 0.5);
            pixel(casters, scene, camera, &camera.ray(at), grid.at(at * share)).as_vec3().into()
        })
        .collect();
    Picture { width: camera.width, height: camera.height, pixels }
}

/// Particle indices by falling z of their centres in `camera`; ties by index.
pub fn far_to_near(scene: &Scene, camera: &View) -> Vec<u32> {
    let z = |i: &u32| camera.project(DVec3::from(scene.particles[*i as usize].position.map(f64::from))).1;
    let mut order: Vec<u32> = (0..scene.particles.len() as u32).collect();
    order.sort_by(|a, b| z(b).total_cmp(&z(a)).then(a.cmp(b)));
    order
}

fn pixel(casters: &Casters, scene: &Scene, camera: &View, ray: &Ray, particles: &[u32]) -> DVec3 {
    let mut color = DVec3::from(SKY.map(f64::from));
    let mut farthest = f64::from(camera.far);
    if let Some(hit) = casters.meshes.hit(ray.origin, ray.direction)
        && hit.distance < farthest
    {
        farthest = hit.distance;
        color = surface(casters, scene, ray.at(hit.distance), &hit);
    }
    let length = ray.direction.length();
    for &i in particles {
        let particle = &scene.particles[i as usize];
        let Some((entry, exit)) = overlap(ray, particle) else { continue };
        let (entry, exit) = (entry.max(camera.near.into()), exit.min(farthest));
        if exit <= entry {
            continue;
        }
        let opacity = 1.0 - (-f64::from(particle.extinction) * (exit - entry) * length).exp();
        let position = ray.at(0.5 * (entry + exit));
        let light = radiance(casters, scene, position) * casters.visibility(position);
        color = PARTICLE_ALBEDO * (AMBIENT + light) * opacity + color * (1.0 - opacity);
    }
    color
}

fn surface(casters: &Casters, scene: &Scene, position: DVec3, hit: &Hit) -> DVec3 {
    let towards = match scene.light.kind {
        LightKind::Directional { direction } => -direction,
        LightKind::Spot { position: light, .. } => (light - position).normalize_or_zero(),
    };
    let light = radiance(casters, scene, position) * casters.visibility(position);
    DVec3::from(hit.albedo.map(f64::from)) * (AMBIENT + light * hit.normal.dot(towards).abs())
}

fn radiance(casters: &Casters, scene: &Scene, position: DVec3) -> DVec3 {
    if casters.lights(position) { DVec3::from(scene.light.radiance.map(f64::from)) } else { DVec3::ZERO }
}
