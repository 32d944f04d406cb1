//! The truth: how much of the light reaches a point, in f64.

use super::grid::Grid;
use super::{Meshes, TrueCurve};
use crate::scene::{LightKind, Particle, Projection, Ray, Scene, View};
use glam::DVec3;

/// Cells a side of the grid over the light's view. It only finds candidates: any number gives the same answers.
const CELLS: u32 = 192;

/// All casters of a scene, with a grid over the light's view so that a look-up meets only those near its ray.
pub struct Casters<'a> {
    scene: &'a Scene,
    view: View,
    /// The meshes.
    pub meshes: Meshes,
    grid: Grid,
}

impl<'a> Casters<'a> {
    /// Sorts the casters of `scene` for its light.
    pub fn new(scene: &'a Scene) -> Self {
        let view = View::volume(scene, CELLS);
        let order: Vec<u32> = (0..scene.particles.len() as u32).collect();
        let grid = Grid::new(&view, &scene.particles, &order);
        Self { scene, view, meshes: Meshes::new(&scene.meshes), grid }
    }

    /// The particles whose shadow may reach the ray through `position`.
    fn near(&self, position: DVec3) -> &[u32] {
        let (texel, z) = self.view.project(position);
        if self.view.projection() == Projection::Perspective && z <= 0.0 { &[] } else { self.grid.at(texel) }
    }

    /// Optical depth of the particles between the light and `position`.
    pub fn optical_depth(&self, position: DVec3) -> f64 {
        let ray = self.view.ray_through(position);
        let (_, z) = self.view.project(position);
        let length = ray.direction.length();
        let nearest = self.nearest();
        self.near(position)
            .iter()
            .filter_map(|&i| {
                let particle = &self.scene.particles[i as usize];
                let (entry, exit) = overlap(&ray, particle)?;
                let passed = exit.min(z) - entry.max(nearest);
                (passed > 0.0).then(|| f64::from(particle.extinction) * passed * length)
            })
            .sum()
    }

    /// z from which the light shines: its own place, or from infinitely far.
    fn nearest(&self) -> f64 {
        match self.view.projection() {
            Projection::Parallel => f64::NEG_INFINITY,
            Projection::Perspective => 0.0,
        }
    }

    /// Whether no mesh stands between the light and `position`.
    pub fn unblocked(&self, position: DVec3) -> bool {
        match self.scene.light.kind {
            LightKind::Directional { direction } => self.meshes.free(position, -direction, f64::INFINITY),
            LightKind::Spot { position: light, .. } => self.meshes.free(position, light - position, 1.0),
        }
    }

    /// How much of the light reaches `position`, 0 to 1.
    pub fn visibility(&self, position: DVec3) -> f64 {
        if self.unblocked(position) { (-self.optical_depth(position)).exp() } else { 0.0 }
    }

    /// Whether the light sends anything towards `position` if nothing stands between.
    pub fn lights(&self, position: DVec3) -> bool {
        match self.scene.light.kind {
            LightKind::Directional { .. } => true,
            LightKind::Spot { position: light, direction, cone_degrees } => {
                let towards = (position - light).normalize_or_zero();
                towards.dot(direction) >= (cone_degrees.to_radians() * 0.5).cos()
            }
        }
    }

    /// The exact curve along `ray`, over depth in the range of `view`, and how many particles made it.
    pub fn true_curve(&self, view: &View, ray: &Ray) -> (TrueCurve, u32) {
        let length = ray.direction.length();
        let middle = ray.at(view.z(0.5));
        let segments: Vec<_> = self
            .near(middle)
            .iter()
            .filter_map(|&i| {
                let particle = &self.scene.particles[i as usize];
                let (entry, exit) = overlap(ray, particle)?;
                let entry = entry.max(f64::from(view.near));
                (exit > entry).then(|| {
                    let optical_depth = f64::from(particle.extinction) * (exit - entry) * length;
                    (view.depth(entry), view.depth(exit), optical_depth)
                })
            })
            .collect();
        (TrueCurve::new(&segments), segments.len() as u32)
    }
}

/// Where the ray is inside the sphere, z from and to; nothing where it misses.
pub(super) fn overlap(ray: &Ray, particle: &Particle) -> Option<(f64, f64)> {
    let offset = DVec3::from(particle.position.map(f64::from)) - ray.origin;
    let square = ray.direction.length_squared();
    let middle = offset.dot(ray.direction) / square;
    let across = offset - middle * ray.direction;
    let radius = f64::from(particle.radius);
    let half_square = (radius * radius - across.length_squared()) / square;
    (half_square > 0.0).then(|| (middle - half_square.sqrt(), middle + half_square.sqrt()))
}
