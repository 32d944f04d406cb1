//! The shaded picture, lit by the truth. Twin: glsl/shading/ with glsl/shading/shading.glsl.

use super::backdrop::{ground_faded, sky_color};
use super::casters::Casters;
use super::grid::Grid;
use super::meshes::Hit;
use super::volume;
use crate::scene::{
    Backdrop, Caster, LightKind, Order, Picture, REACH, Ray, SKY, Scene, Shape, View, Volume, far_to_near,
    smooth_normals,
};
use glam::{DVec2, DVec3};
use rayon::prelude::*;
use std::ops::Range;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Twin: PARTICLE_ALBEDO.
const PARTICLE_ALBEDO: DVec3 = DVec3::new(0.92, 0.92, 0.95);
/// Twin: STRAND_ALBEDO.
const STRAND_ALBEDO: DVec3 = DVec3::new(0.70, 0.42, 0.20);
/// Twin: AMBIENT.
const AMBIENT: DVec3 = DVec3::new(0.10, 0.12, 0.15);

/// Twin: SHEET_LIFT.
const SHEET_LIFT: f64 = 1.0 / 16.0;

/// Pixels per side of a cell of the grid, which only finds candidates.
const CELL_PIXELS: u32 = 8;

/// Transmittance below which a picture's march through a volume stops.
const HIDDEN: f64 = 1e-9;

/// Renders `scene` as seen by `camera`. Casters and volumes are blended from far to near by the z of their centres, as on the device. A
/// volume is marched with two steps in each cell of its field.
pub fn picture(casters: &Casters, scene: &Scene, camera: &View) -> Picture {
    let pixels = picture_rows(casters, scene, camera, 0..camera.height);
    Picture { width: camera.width, height: camera.height, pixels }
}

/// Renders some rows of [`picture`], counted from the top.
pub fn picture_rows(casters: &Casters, scene: &Scene, camera: &View, rows: Range<u32>) -> Vec<[f32; 3]> {
    let caster = |_, index: Option<u32>, position| light(casters, scene, position, lifted(casters, index), |_| 1.0);
    let surface = |position, hit: &Hit| lit_surface(casters, scene, position, hit);
    let sky = |_| DVec3::from(SKY.map(f64::from));
    camera_rows(casters, scene, camera, rows, &far_to_near(scene, camera), caster, surface, sky)
}

/// Like [`picture`], plus the extras of pictures made for viewing: smooth normals, and a sky into which the ground fades. Twin:
/// shading::Renderer::show.
pub fn shown_picture(casters: &Casters, scene: &Scene, camera: &View) -> Picture {
    let pixels = shown_rows(casters, scene, camera, 0..camera.height);
    Picture { width: camera.width, height: camera.height, pixels }
}

/// Renders some rows of [`shown_picture`], counted from the top.
pub fn shown_rows(casters: &Casters, scene: &Scene, camera: &View, rows: Range<u32>) -> Vec<[f32; 3]> {
    let caster = |_, index: Option<u32>, position| light(casters, scene, position, lifted(casters, index), |_| 1.0);
    let normals: Vec<_> = scene.meshes.iter().flat_map(smooth_normals).collect();
    let backdrop = Backdrop::of(scene);
    let surface = |position: DVec3, hit: &Hit| {
        let normal = casters.meshes.smooth_normal(position, hit, &normals[hit.triangle]);
        let share = ground_faded(&backdrop, position);
        let towards = position - DVec3::from(camera.origin.map(f64::from));
        let lit =
            if share < 1.0 { lit_surface(casters, scene, position, &Hit { normal, ..*hit }) } else { DVec3::ZERO };
        lit.lerp(sky_color(&backdrop, towards.normalize()), share)
    };
    let sky = |direction: DVec3| sky_color(&backdrop, direction.normalize());
    camera_rows(casters, scene, camera, rows, &far_to_near(scene, camera), caster, surface, sky)
}

/// Estimates the cost of [`picture`]: the number of tests of casters and meshes against rays to the lights, extrapolated from a coarse
/// picture of the same view and a sample of the lights.
pub fn picture_tries(casters: &Casters, scene: &Scene, camera: &View) -> f64 {
    /// Approximate number of lights sampled.
    const SOME: usize = 64;
    let small = View { width: 32, height: 18, ..*camera };
    let step = scene.lights.len().div_ceil(SOME).max(1);
    let all = AtomicUsize::new(0);
    let see = |position| {
        let shining = (0..scene.lights.len()).step_by(step).filter(|light| scene.lights[*light].shines_on(position));
        all.fetch_add(shining.map(|light| casters.tries(light, position)).sum(), Ordering::Relaxed);
        DVec3::ZERO
    };
    let order = far_to_near(scene, camera);
    camera_rays(casters, scene, &small, &order, |_, _, position| see(position), |position, _| see(position));
    all.into_inner() as f64 * step as f64 * camera.texels() as f64 / small.texels() as f64
}

/// Renders with one ray per pixel, through casters and volumes in the given order. `light` returns the light that arrives at a caster. Its
/// arguments are the pixel, the caster's index, and the midpoint of the ray's segment inside the caster. In a volume the index is `None`
/// and the point is the midpoint of a step. `surface` returns the color of a mesh where the ray hits it.
pub(in crate::reference) fn camera_rays(
    casters: &Casters,
    scene: &Scene,
    camera: &View,
    order: &Order,
    light: impl Fn(DVec2, Option<u32>, DVec3) -> DVec3 + Sync,
    surface: impl Fn(DVec3, &Hit) -> DVec3 + Sync,
) -> Picture {
    let sky = |_| DVec3::from(SKY.map(f64::from));
    let pixels = camera_rows(casters, scene, camera, 0..camera.height, order, light, surface, sky);
    Picture { width: camera.width, height: camera.height, pixels }
}

/// Renders some rows of [`camera_rays`]; `sky` returns the color of the sky in a ray's direction.
#[expect(clippy::too_many_arguments, reason = "what a ray meets, and how each looks")]
fn camera_rows(
    casters: &Casters,
    scene: &Scene,
    camera: &View,
    rows: Range<u32>,
    order: &Order,
    light: impl Fn(DVec2, Option<u32>, DVec3) -> DVec3 + Sync,
    surface: impl Fn(DVec3, &Hit) -> DVec3 + Sync,
    sky: impl Fn(DVec3) -> DVec3 + Sync,
) -> Vec<[f32; 3]> {
    let cells =
        View { width: camera.width.div_ceil(CELL_PIXELS), height: camera.height.div_ceil(CELL_PIXELS), ..*camera };
    let grid = Grid::new(&cells, &casters.all, &order.casters);
    let places = Places::of(order, casters.all.len());
    let share =
        DVec2::new(cells.width.into(), cells.height.into()) / DVec2::new(camera.width.into(), camera.height.into());
    (camera.width * rows.start..camera.width * rows.end)
        .into_par_iter()
        .map(|i| {
            let at = DVec2::new(f64::from(i % camera.width) + 0.5, f64::from(i / camera.width) + 0.5);
            let light = |index, position| light(at, index, position);
            let ray = camera.ray(at);
            let behind = meshes(casters, camera, &ray, &surface, &sky);
            pixel(casters, scene, camera, &ray, (grid.at(at * share), &places), light, behind).as_vec3().into()
        })
        .collect()
}

/// Returns the color that a ray sees behind all casters, from a mesh or the sky, and its distance.
fn meshes(
    casters: &Casters,
    camera: &View,
    ray: &Ray,
    surface: impl Fn(DVec3, &Hit) -> DVec3,
    sky: impl Fn(DVec3) -> DVec3,
) -> (DVec3, f64) {
    let far = f64::from(camera.far);
    match casters.meshes.hit(ray.origin, ray.direction).filter(|hit| hit.distance < far) {
        Some(hit) => (surface(ray.at(hit.distance), &hit), hit.distance),
        None => (sky(ray.direction), far),
    }
}

/// Positions of casters and volumes in a blending order.
struct Places<'a> {
    volumes: &'a [(u32, u32)],
    /// Position of each caster in the order; empty if there are no volumes.
    casters: Vec<u32>,
}

impl<'a> Places<'a> {
    fn of(order: &'a Order, count: usize) -> Self {
        let mut casters = vec![0; if order.volumes.is_empty() { 0 } else { count }];
        if !casters.is_empty() {
            (0..).zip(&order.casters).for_each(|(place, caster)| casters[*caster as usize] = place);
        }
        Self { volumes: &order.volumes, casters }
    }
}

fn pixel(
    casters: &Casters,
    scene: &Scene,
    camera: &View,
    ray: &Ray,
    (candidates, places): (&[u32], &Places),
    light: impl Fn(Option<u32>, DVec3) -> DVec3,
    (mut color, farthest): (DVec3, f64),
) -> DVec3 {
    let mut volumes = places.volumes.iter().peekable();
    let ends = (camera.near.into(), farthest);
    let through = |number: u32, behind: DVec3| {
        let volume = &scene.volumes[number as usize];
        through(
            volume,
            casters.ratio_of_volume(number),
            ray,
            ends,
            |position| ambient(scene) + light(None, position),
            behind,
        )
    };
    for &i in candidates {
        while let Some((_, volume)) = volumes.next_if(|(before, _)| *before <= places.casters[i as usize]) {
            color = through(*volume, color);
        }
        let caster = &casters.all[i as usize];
        let Some((entry, exit)) = casters.overlap(ray, i) else { continue };
        let (entry, exit) = (entry.max(camera.near.into()), exit.min(farthest));
        if exit < entry {
            continue;
        }
        let opacity = 1.0 - (-casters.depth_within(ray, i, entry, exit) * casters.ratio_of(i)).exp();
        let light = light(Some(i), ray.at(0.5 * (entry + exit)));
        let albedo = albedo(scene, i as usize, caster);
        color = albedo * (ambient(scene) + light) * opacity + color * (1.0 - opacity);
    }
    volumes.fold(color, |color, (_, volume)| through(*volume, color))
}

/// Blends a volume over the color behind it, lit at the midpoint of each step. Twin: glsl/shading/volume.glsl.
fn through(
    volume: &Volume,
    ratio: DVec3,
    ray: &Ray,
    (near, farthest): (f64, f64),
    light: impl Fn(DVec3) -> DVec3,
    behind: DVec3,
) -> DVec3 {
    let (mut scattered, mut transmittance) = (DVec3::ZERO, DVec3::ONE);
    volume::steps(volume, ray, near, farthest, |middle, depth| {
        if depth > 0.0 && transmittance.max_element() > HIDDEN {
            let left = transmittance * (-depth * ratio).exp();
            scattered += (transmittance - left) * light(ray.at(middle));
            transmittance = left;
        }
    });
    DVec3::from(volume.placed().color.map(f64::from)) * scattered + behind * transmittance
}

/// Returns a closure that maps the direction to a light to the distance by which a point is moved towards that light before visibility is
/// queried. The point lies on the caster with the given index, or in a volume (`None`).
fn lifted<'a>(casters: &'a Casters, index: Option<u32>) -> impl Fn(DVec3) -> f64 + 'a {
    let caster = index.map(|index| &casters.all[index as usize]);
    move |towards| caster.map_or(0.0, |caster| lift(caster, towards))
}

/// Returns a caster's albedo; splats, sheets and volumes have their own colors.
pub(super) fn albedo(scene: &Scene, index: usize, caster: &Caster) -> DVec3 {
    let splat = index.checked_sub(scene.particles.len() + scene.strands.len()).and_then(|i| scene.splats.get(i));
    match splat {
        Some(splat) => DVec3::from(splat.color.map(f64::from)),
        None if caster.is_cell() => cell_color(scene, index),
        None if caster.is_sheet() => sheet_color(scene, caster),
        None if caster.is_strand() => STRAND_ALBEDO,
        None => PARTICLE_ALBEDO,
    }
}

/// Returns the color of a sheet's mesh.
fn sheet_color(scene: &Scene, caster: &Caster) -> DVec3 {
    let mut before = caster.sheet_triangle() as usize;
    let its = scene.meshes.iter().find(|mesh| {
        let is_in = before < mesh.triangles.len();
        before = before.saturating_sub(mesh.triangles.len());
        is_in
    });
    its.map_or(PARTICLE_ALBEDO, |mesh| DVec3::from(mesh.albedo.map(f64::from)))
}

/// Returns the color of a cell's volume, given the cell's index among all casters.
fn cell_color(scene: &Scene, index: usize) -> DVec3 {
    let mut first = scene.first_cell();
    let its = scene.volumes.iter().find(|volume| {
        first += volume.cells().len();
        index < first
    });
    its.map_or(PARTICLE_ALBEDO, |volume| DVec3::from(volume.placed().color.map(f64::from)))
}

/// Returns the color of a mesh at the point where a ray hits it.
pub(in crate::reference) fn lit_surface(casters: &Casters, scene: &Scene, position: DVec3, hit: &Hit) -> DVec3 {
    let light = light(casters, scene, position, |_| 0.0, |towards| hit.normal.dot(towards).abs());
    DVec3::from(hit.albedo.map(f64::from)) * (ambient(scene) + light)
}

/// Returns the ambient light; 0 under virtual lights, which replace it. Twin: ambient.
fn ambient(scene: &Scene) -> DVec3 {
    match scene.lights.first().map(|light| light.kind) {
        Some(LightKind::Virtual { .. }) => DVec3::ZERO,
        _ => AMBIENT,
    }
}

/// Returns how far a point on a caster is moved towards a light before visibility is queried, so that a strand, splat or sheet does
/// not shadow itself. `towards` has length 1.
pub(in crate::reference) fn lift(caster: &Caster, towards: DVec3) -> f64 {
    if caster.is_splat() {
        return (REACH / Shape::of(caster).whitened(towards).length()).max(f64::from(caster.radius) / REACH);
    }
    if caster.is_sheet() {
        return SHEET_LIFT * f64::from(caster.radius);
    }
    if caster.is_strand() { 2.0 * f64::from(caster.radius) } else { 0.0 }
}

/// Sums the light that arrives from all lights, each weighted by the value of `turn` for the direction to the light. Visibility is queried
/// at a point moved by `lift` towards the light. Twin: lit_side.
pub(in crate::reference) fn light(
    casters: &Casters,
    scene: &Scene,
    position: DVec3,
    lift: impl Fn(DVec3) -> f64,
    turn: impl Fn(DVec3) -> f64,
) -> DVec3 {
    let mut sum = DVec3::ZERO;
    for (i, light) in scene.lights.iter().enumerate().filter(|(_, light)| light.shines_on(position)) {
        let radiance = DVec3::from(light.radiance.map(f64::from)) * light.falloff(position);
        let towards = light.towards(position);
        let turned = turn(towards);
        if turned > 0.0 {
            sum += radiance * turned * casters.colors(i, position + lift(towards) * towards);
        }
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Camera;
    use crate::scene::tests::{mesh, on_the_axis};

    /// The cost of a picture of a plate grows with the number of pixels and of lights, even beyond the number of lights sampled; the sky
    /// costs nothing.
    #[test]
    fn meshes_cost_something() {
        let mut scene = on_the_axis(&[]);
        let corners = vec![[-99.0, -99.0, 0.0], [99.0, -99.0, 0.0], [99.0, 99.0, 0.0], [-99.0, 99.0, 0.0]];
        scene.meshes = vec![mesh(corners, vec![[0, 1, 2], [0, 2, 3]])];
        scene.camera =
            Camera { position: DVec3::Z, target: DVec3::new(0.1, 0.0, 0.0), up: DVec3::X, fov_y_degrees: 30.0 };
        let tries =
            |scene: &Scene, size| picture_tries(&Casters::new(scene), scene, &View::camera(&scene.camera, scene, size));
        let one = tries(&scene, [32, 18]);
        assert!(one >= 576.0, "{one}");
        assert_eq!(tries(&scene, [64, 36]), 4.0 * one);
        scene.lights = vec![scene.lights[0]; 640];
        assert_eq!(tries(&scene, [32, 18]), 640.0 * one);
        scene.camera.target = DVec3::new(0.1, 0.0, 2.0);
        assert_eq!(tries(&scene, [32, 18]), 0.0);
    }
}
