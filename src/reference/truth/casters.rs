//! The truth: how much of a light reaches a point, in f64.

use super::grid::Grid;
use super::meshes::Meshes;
use super::splat::{self, TRUE_REACH};
use super::surface::SurfacePoint;
use super::true_curve::{Smooth, TrueCurve};
use super::volume;
use crate::scene::{Caster, Projection, REACH, Ray, Scene, Shape, View, Volume};
use glam::DVec3;

/// Maximum number of cells per side of the grid over a map's view. The grid only finds candidates: any number gives the same results.
const CELLS: u32 = 192;

/// Maximum number of entries in all cells of a grid together: a grid that would exceed it gets fewer cells. A large caster has an entry in
/// every cell.
const MOST_MEMBERS: usize = 1 << 24;

/// The map size at which the faces of a point light are widest: a grid over these faces contains the rays of every map size.
const WIDEST: u32 = 4;

/// All casters of a scene, with a grid over each map's view, so that a query tests only casters near its ray.
pub struct Casters<'a> {
    pub(super) scene: &'a Scene,
    /// Spheres, then strands, splats, sheets, and last the cells of volumes. Only pictures use the sheets and the cells: optical depth comes
    /// from the meshes and from the volumes' densities.
    pub(in crate::reference) all: Vec<Caster>,
    /// Extinction ratio of each caster if the casters have several ([`Scene::with_inks`]); otherwise empty.
    inks: Vec<[f32; 3]>,
    /// Extinction ratio of each volume.
    volume_ratios: Vec<[f32; 3]>,
    /// The meshes.
    pub meshes: Meshes,
    /// View and grid of each map of each light; empty if the scene has no casters.
    maps: Vec<(View, Grid)>,
}

impl<'a> Casters<'a> {
    /// Sorts the casters of `scene` into grids, one per map of each light.
    pub fn new(scene: &'a Scene) -> Self {
        let all = scene.casters();
        let asked = all.len() - scene.cell_count();
        // Sheets are looked up among the meshes.
        let order: Vec<u32> = (0..scene.first_sheet() as u32).collect();
        let with_grid = |view: View| {
            let sides = std::iter::successors(Some(CELLS), |side| (*side > 1).then_some(side / 2));
            let mut views = sides.map(|side| View { width: side, height: side, ..view });
            let few = |view: &View| Grid::members(view, &all[..asked]) <= MOST_MEMBERS;
            let view = views.find(few).unwrap_or(View { width: 1, height: 1, ..view });
            (view, Grid::new(&view, &all, &order))
        };
        let views = if all.is_empty() { Vec::new() } else { View::volumes(scene, WIDEST) };
        let maps = views.into_iter().map(with_grid).collect();
        let inks = if scene.inks.is_empty() { Vec::new() } else { scene.ink_ratios().take(all.len()).collect() };
        Self { scene, meshes: Meshes::new(&scene.meshes), maps, all, inks, volume_ratios: scene.volume_ratios() }
    }

    /// Returns a caster with its extinction for light of a color ([`Scene::color_of_light`]).
    fn seen_by(&self, color: usize, index: u32) -> Caster {
        let caster = self.all[index as usize];
        let ratio = self.inks.get(index as usize).map_or(1.0, |ratio| ratio[color]);
        // Rounded to f32, as on the device.
        Caster { density: caster.density * ratio, ..caster }
    }

    /// Returns the range of z in which a ray is inside caster `index`, or `None` if it misses. For a strand or a sheet, both ends are equal.
    pub(super) fn overlap(&self, ray: &Ray, index: u32) -> Option<(f64, f64)> {
        let caster = &self.all[index as usize];
        if caster.is_sheet() {
            return self.meshes.sheet(caster.sheet_triangle(), ray).map(|(z, _)| (z, z));
        }
        overlap(ray, caster)
    }

    /// Returns the optical depth of caster `index` from z `entry` to `exit`, both within its overlap.
    pub(super) fn depth_within(&self, ray: &Ray, index: u32, entry: f64, exit: f64) -> f64 {
        let caster = &self.all[index as usize];
        if caster.is_sheet() {
            return self.meshes.sheet(caster.sheet_triangle(), ray).map_or(0.0, |(_, depth)| depth);
        }
        optical_depth(ray, caster, entry, exit)
    }

    /// Returns the scene of these casters.
    pub fn scene(&self) -> &'a Scene {
        self.scene
    }

    /// Returns the casters whose shadow may reach the ray through `position` in map `map`.
    fn near(&self, map: usize, position: DVec3) -> &[u32] {
        let Some((view, grid)) = self.maps.get(map) else { return &[] };
        let (texel, z) = view.project(position);
        if view.projection() == Projection::Perspective && z <= 0.0 { &[] } else { grid.at(texel) }
    }

    /// Returns the optical depth of the casters and of see-through meshes between light `light` and `position`. A strand exactly at
    /// `position` counts.
    pub fn optical_depth(&self, light: usize, position: DVec3) -> f64 {
        let (direction, distance) = self.to_light(light, position);
        let glass = self.meshes.see_through(position, direction, distance, self.scene.color_of_light(light));
        self.casters_depth(light, position) + glass.into_iter().map(|(_, depth)| depth).sum::<f64>()
    }

    /// Returns the optical depth of the casters alone.
    fn casters_depth(&self, light: usize, position: DVec3) -> f64 {
        let map = self.scene.first_map(light) + self.scene.lights[light].map_at(position.as_vec3().into());
        let Some((view, _)) = self.maps.get(map) else { return 0.0 };
        let ray = view.ray_through(position);
        let (_, z) = view.project(position);
        // The z at which the light's rays start: 0 for a light with a position, −∞ for a directional light.
        let nearest = match view.projection() {
            Projection::Parallel => f64::NEG_INFINITY,
            Projection::Perspective => 0.0,
        };
        let color = self.scene.color_of_light(light);
        let of = |(volume, ratio): (&Volume, &[f32; 3])| {
            volume::optical_depth(volume, &ray, nearest, z) * f64::from(ratio[color])
        };
        let volumes = self.scene.volumes.iter().zip(&self.volume_ratios).map(of).sum::<f64>();
        let near = self.near(map, position).iter().filter_map(|&i| {
            let caster = &self.seen_by(color, i);
            if caster.is_splat() {
                return soft_depth(&ray, caster, nearest, z);
            }
            let (entry, exit) = overlap(&ray, caster)?;
            let (entry, exit) = (entry.max(nearest), exit.min(z));
            (exit >= entry).then(|| optical_depth(&ray, caster, entry, exit))
        });
        volumes + near.sum::<f64>()
    }

    /// Returns the number of casters that [`Casters::visibility`] tests. A box or triangle of a mesh counts half, since its test takes half
    /// as long.
    pub(super) fn tries(&self, light: usize, position: DVec3) -> usize {
        let map = self.scene.first_map(light) + self.scene.lights[light].map_at(position.as_vec3().into());
        let (direction, distance) = self.to_light(light, position);
        let volumes: usize = self.scene.volumes.iter().map(volume::tries).sum();
        volumes + self.near(map, position).len() + self.meshes.tries(position, direction, distance) / 2
    }

    /// Returns a direction from `position` towards light `light`, and the distance to the light in multiples of that direction.
    pub(super) fn to_light(&self, light: usize, position: DVec3) -> (DVec3, f64) {
        let light = &self.scene.lights[light];
        light.position().map_or_else(|| (light.towards(position), f64::INFINITY), |at| (at - position, 1.0))
    }

    /// Returns whether no mesh stands between light `light` and `position`.
    pub fn unblocked(&self, light: usize, position: DVec3) -> bool {
        let (direction, distance) = self.to_light(light, position);
        self.meshes.free(position, direction, distance)
    }

    /// Returns two distances between light `light` and `position`: from the light to the first mesh after it, and from `position` to the
    /// first mesh before it. Both are fractions of the diagonal of the box around all meshes. Both are infinite if no mesh is in between;
    /// for a light at infinity the first is always infinite.
    pub fn caster_distances(&self, light: usize, position: DVec3) -> [f64; 2] {
        let (direction, distance) = self.to_light(light, position);
        let Some(first) = self.meshes.hit(position, direction).map(|hit| hit.distance).filter(|at| *at < distance)
        else {
            return [f64::INFINITY; 2];
        };
        let length = direction.length() / self.meshes.diagonal;
        let from_light = self.scene.lights[light].position().map_or(f64::INFINITY, |place| {
            // A hit beyond `first` means that the first mesh touches the light: distance 0.
            let back = self.meshes.hit(place, -direction).map_or(0.0, |hit| hit.distance);
            if back + first <= 1.0 + 1e-9 { back * length } else { 0.0 }
        });
        [from_light, first * length]
    }

    /// Returns whether `position` is inside a closed or solid mesh while light `light` is outside it. Techniques are not queried at such
    /// points.
    pub fn inside(&self, light: usize, position: DVec3) -> bool {
        let (direction, distance) = self.to_light(light, position);
        self.meshes.inside(position, direction, distance)
    }

    /// Like [`Casters::inside`], for a point on a mesh: returns whether it is inside another mesh.
    pub fn surface_inside(&self, light: usize, point: &SurfacePoint) -> bool {
        // The point lies on the surface of its own mesh, so it is first moved out of that mesh.
        self.inside(light, point.position + 2.0 * self.meshes.epsilon * point.normal)
    }

    /// Returns how much of light `light` reaches `position`, from 0 to 1.
    pub fn visibility(&self, light: usize, position: DVec3) -> f64 {
        if self.unblocked(light, position) { (-self.optical_depth(light, position)).exp() } else { 0.0 }
    }

    /// Like [`Casters::visibility`], for red, green and blue light: each channel scales the optical depth by its own factor
    /// ([`Scene::extinction_ratio`]). Twin: glsl/world/colors.glsl.
    pub fn colors(&self, light: usize, position: DVec3) -> DVec3 {
        if !self.unblocked(light, position) {
            return DVec3::ZERO;
        }
        // Beside one ratio for all casters, glass absorbs all colors alike.
        let casters = self.casters_depth(light, position);
        let glass = self.optical_depth(light, position) - casters;
        (-casters * self.extinction_ratio() - glass).exp()
    }

    /// Returns a caster's extinctions for red, green and blue light, as multiples of its scalar extinction.
    pub(super) fn ratio_of(&self, caster: u32) -> DVec3 {
        DVec3::from(self.inks.get(caster as usize).unwrap_or(&self.scene.extinction_ratio).map(f64::from))
    }

    /// Returns a volume's extinctions for red, green and blue light, as multiples of its scalar extinction.
    pub(super) fn ratio_of_volume(&self, volume: u32) -> DVec3 {
        DVec3::from(self.volume_ratios[volume as usize].map(f64::from)) * self.extinction_ratio()
    }

    fn extinction_ratio(&self) -> DVec3 {
        DVec3::from(self.scene.extinction_ratio.map(f64::from))
    }

    /// Returns [`Casters::colors`] times the distance falloff of light `light`; 0 outside the cone of a spot light.
    pub fn arriving_colors(&self, light: usize, position: DVec3) -> DVec3 {
        let shining = &self.scene.lights[light];
        if shining.shines_on(position) { self.colors(light, position) * shining.falloff(position) } else { DVec3::ZERO }
    }

    /// Returns [`Casters::visibility`] times the distance falloff of light `light`; 0 outside the cone of a spot light.
    pub fn arriving(&self, light: usize, position: DVec3) -> f64 {
        let shining = &self.scene.lights[light];
        if shining.shines_on(position) { self.visibility(light, position) * shining.falloff(position) } else { 0.0 }
    }

    /// Returns the exact curve along `ray` of map `map` (counted over all lights' maps), over depth in the range of the map's `view`, and
    /// the number of casters that the ray meets.
    pub fn true_curve(&self, map: usize, view: &View, ray: &Ray) -> (TrueCurve, u32) {
        let color = self.scene.color_of_map(map);
        let (hard, soft): (Vec<Caster>, Vec<Caster>) = self
            .near(map, ray.at(view.z(0.5)))
            .iter()
            .map(|&i| self.seen_by(color, i))
            .partition(|caster| !caster.is_splat());
        let segments: Vec<_> = hard
            .into_iter()
            .filter_map(|caster| {
                let (entry, exit) = overlap(ray, &caster)?;
                let near = f64::from(view.near);
                let entry = entry.max(near);
                (exit > near).then(|| (view.depth(entry), view.depth(exit), optical_depth(ray, &caster, entry, exit)))
            })
            .collect();
        let glass = self.meshes.see_through(ray.origin, ray.direction, f64::INFINITY, color).into_iter();
        let glass =
            glass.filter(|(z, _)| *z > f64::from(view.near)).map(|(z, depth)| (view.depth(z), view.depth(z), depth));
        let segments: Vec<_> = segments.into_iter().chain(glass).collect();
        let mut curve = TrueCurve::new(&segments);
        let mut met = segments.len();
        let nearest = if view.projection() == Projection::Parallel { f64::NEG_INFINITY } else { view.near.into() };
        for caster in &soft {
            if splat::missed(ray, caster) {
                continue;
            }
            let along = splat::along(ray, caster);
            let Some((_, exit)) = along.within(TRUE_REACH) else { continue };
            if exit > nearest {
                let deviation = along.deviation / f64::from(view.far - view.near);
                curve.smooth.push(Smooth {
                    middle: view.depth(along.middle),
                    deviation,
                    before: splat::share((nearest - along.middle) / along.deviation),
                    whole: along.whole(ray, caster),
                });
                // Counted only within `REACH`, where techniques cut splats off.
                met += usize::from(along.within(REACH).is_some_and(|(_, exit)| exit > nearest));
            }
        }
        for (volume, ratio) in self.scene.volumes.iter().zip(&self.volume_ratios) {
            let mut cells = volume::curve(volume, ray, nearest, |z| view.depth(z));
            cells.iter_mut().for_each(|cell| cell.scale(ratio[color].into()));
            met += cells.len();
            curve.volumes.push(cells);
        }
        (curve, met as u32)
    }
}

/// Squared sine of the angle between ray and axis below which a strand is seen edge-on and missed. Twin: EDGE_ON.
const EDGE_ON: f64 = 1e-10;

/// Returns the range of z in which the ray is inside the caster, or `None` if it misses. For a strand, both ends are equal.
fn overlap(ray: &Ray, caster: &Caster) -> Option<(f64, f64)> {
    let offset = caster.start() - ray.origin;
    let square = ray.direction.length_squared();
    let radius = f64::from(caster.radius);
    if caster.is_splat() {
        return splat::along(ray, caster).within(TRUE_REACH);
    }
    if caster.is_cell() {
        return cell_overlap(ray, caster);
    }
    if caster.is_strand() {
        let axis = DVec3::from(caster.axis.map(f64::from));
        let across = |v: DVec3| v - v.dot(ray.direction) / square * ray.direction;
        let (start, side) = (across(offset), across(axis));
        if side.length_squared() <= EDGE_ON * axis.length_squared() {
            return None;
        }
        let along = -start.dot(side) / side.length_squared();
        let z = (offset + along * axis).dot(ray.direction) / square;
        let hit = (0.0..1.0).contains(&along) && (start + along * side).length_squared() < radius * radius;
        return hit.then_some((z, z));
    }
    let middle = offset.dot(ray.direction) / square;
    let across = offset - middle * ray.direction;
    let half_square = (radius * radius - across.length_squared()) / square;
    (half_square > 0.0).then(|| (middle - half_square.sqrt(), middle + half_square.sqrt()))
}

/// Returns the range of z in which the ray is inside a cell, which is a box, or `None` if it misses.
fn cell_overlap(ray: &Ray, caster: &Caster) -> Option<(f64, f64)> {
    let shape = Shape::of_cell(caster);
    let offset = caster.start() - ray.origin;
    let (mut low, mut high) = (f64::NEG_INFINITY, f64::INFINITY);
    for (axis, side) in shape.axes.into_iter().zip(shape.deviations) {
        let (along, from) = (axis.dot(ray.direction), axis.dot(offset));
        if along == 0.0 && from.abs() > side {
            return None;
        }
        if along != 0.0 {
            let ends = [(from - side) / along, (from + side) / along];
            (low, high) = (low.max(ends[0].min(ends[1])), high.min(ends[0].max(ends[1])));
        }
    }
    (high > low).then_some((low, high))
}

/// Returns the optical depth of a splat from z `from` to `to`, or `None` if the ray stays out of its reach.
fn soft_depth(ray: &Ray, caster: &Caster, from: f64, to: f64) -> Option<f64> {
    if splat::missed(ray, caster) {
        return None;
    }
    let along = splat::along(ray, caster);
    let (entry, _) = along.within(TRUE_REACH)?;
    (to > entry).then(|| along.optical_depth(ray, caster, from, to))
}

/// Returns the optical depth of the caster from z `entry` to `exit`, both within its overlap.
pub(super) fn optical_depth(ray: &Ray, caster: &Caster, entry: f64, exit: f64) -> f64 {
    if caster.is_splat() {
        return splat::along(ray, caster).optical_depth(ray, caster, entry, exit);
    }
    let thickness = if caster.is_strand() { 1.0 } else { (exit - entry) * ray.direction.length() };
    f64::from(caster.density) * thickness
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::LightKind;
    use crate::scene::tests::{mesh, on_the_axis};

    /// Many spheres each fill all cells, so the grid gets fewer cells; the optical depth stays exact.
    #[test]
    fn many_large_casters_have_few_cells() {
        let count = 2000;
        let scene = on_the_axis(&vec![(0.0, 1.0, 1.0 / count as f32); count]);
        let casters = Casters::new(&scene);
        let (view, _) = &casters.maps[0];
        assert!(view.width < CELLS && Grid::members(view, &casters.all) <= MOST_MEMBERS);
        assert!(
            Grid::members(&View { width: 2 * view.width, height: 2 * view.height, ..*view }, &casters.all)
                > MOST_MEMBERS
        );
        for (z, expected) in [(1.5, 0.0), (0.0, 1.0), (-1.5, 2.0)] {
            let found = casters.optical_depth(0, DVec3::new(0.0, 0.0, z));
            // Extinctions are f32.
            assert!((found - expected).abs() < 1e-6, "{found}, not {expected}");
        }
    }

    /// Checks the caster distances under a lamp at height 4, with plates at heights 3 and 1 above a ground, for points on the ground and
    /// between the plates.
    #[test]
    fn casters_are_where_the_plates_are() {
        let plate = |z: f32, half: f32| {
            let corners = vec![[-half, -half, z], [half, -half, z], [half, half, z], [-half, half, z]];
            mesh(corners, vec![[0, 1, 2], [0, 2, 3]])
        };
        let mut scene = on_the_axis(&[]);
        scene.meshes = vec![plate(0.0, 2.0), plate(1.0, 1.0), plate(3.0, 1.0)];
        scene.lights[0].kind = LightKind::Point { position: DVec3::new(0.0, 0.0, 4.0) };
        let diagonal = (16.0_f64 + 16.0 + 9.0).sqrt();
        let check = |scene: &Scene, position: [f64; 3], expected: [f64; 2]| {
            let found = Casters::new(scene).caster_distances(0, DVec3::from(position));
            for (found, expected) in found.into_iter().zip(expected) {
                let expected = expected / diagonal;
                assert!(found == expected || (found - expected).abs() < 1e-12, "{found}, not {expected}");
            }
        };
        check(&scene, [0.1, 0.2, 0.0], [(1.0_f64 + 0.05 / 16.0).sqrt(); 2]);
        check(&scene, [0.3, 0.0, 2.0], [(1.0_f64 + 0.09 / 4.0).sqrt(); 2]);
        check(&scene, [0.3, 0.0, 3.5], [f64::INFINITY; 2]);
        check(&scene, [5.0, 0.0, 0.0], [f64::INFINITY; 2]);
        scene.meshes.remove(1);
        check(&scene, [0.0, 0.0, 0.0], [1.0, 3.0]);
        scene.lights[0].kind = LightKind::Directional { direction: DVec3::NEG_Z };
        check(&scene, [0.1, 0.2, 0.0], [f64::INFINITY, 3.0]);
    }
}
