//! A case's scene with its truth, computed once for all techniques.

use super::scene_builders::{random, step};
use crate::bench::{Cached, Extent, Points, SeenTruth, Truth, Wanted};
use crate::reference::truth::{Casters, MAP_DEPTHS, MapTruth, TrueCurve, bounds, sample_maps};
use crate::scene::{Projection, Resolution, Scene, View};
use glam::{DVec2, DVec3, IVec2};
use rayon::prelude::*;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::{Arc, OnceLock};

/// Number of different orders in which the same casters are tried.
pub const SHUFFLES: usize = 8;

/// Number of texels whose rays get points, over all maps together.
const TEXELS: usize = 96;

/// Number of points in space per light, of points on meshes per light, and of camera rays.
const POINTS: usize = 1024;

/// Size in pixels of the picture through which half of the points on meshes are found.
const PICTURE: [u32; 2] = [96, 64];

/// Distance that all casters move per step, as a fraction of the diagonal of their box, and the number of steps.
const STEP: f64 = 1e-3;
const STEPS: usize = 3;

/// A scene with its truth.
pub struct Subject<'a> {
    /// The scene.
    pub scene: &'a Scene,
    truth: Truth<'a>,
    casters: Casters<'a>,
    moved: OnceLock<Vec<MovedCasters>>,
    /// Truth on the rays of maps, which several techniques share.
    maps: Cached<Vec<View>, OnRays>,
    /// Filtered truth at the points in space, by number of steps and views.
    filtered: Cached<(usize, Vec<View>), Vec<f64>>,
    boundaries: Cached<(usize, Vec<Resolution>), Vec<bool>>,
}

/// Points on the rays of texels, and how far rounding has moved each from its ray.
pub(super) type OnRays = (Vec<Points>, Vec<RoundedAnswers>);

/// The scene after a step, and its truth at the points in space.
pub(super) struct MovedCasters {
    pub scene: Scene,
    pub visibility: Arc<Vec<f64>>,
}

impl<'a> Subject<'a> {
    /// Creates the subject of a scene; most of its truth is computed when first needed.
    pub fn new(scene: &'a Scene) -> Self {
        // An empty scene is queried in an arbitrary box.
        let bounds = bounds(scene).unwrap_or([DVec3::NEG_ONE, DVec3::ONE]);
        let wanted = Wanted {
            extent: Extent::Sample,
            points: POINTS,
            picture: PICTURE,
            bounds: Some(bounds),
            seen: (POINTS, 0),
            watched: Arc::default(),
        };
        Self {
            scene,
            truth: Truth::new(scene, wanted),
            casters: Casters::new(scene),
            moved: OnceLock::new(),
            maps: Cached::new(),
            filtered: Cached::new(),
            boundaries: Cached::new(),
        }
    }

    /// Computes the truth that all techniques share now, so that its time does not count towards any technique.
    pub(super) fn find_truth(&self) {
        self.space();
        self.surface();
        self.seen();
        self.moved();
    }

    /// Returns the points in space, per light.
    pub(super) fn space(&self) -> &[Points] {
        self.truth.space()
    }

    /// Returns the points on meshes, per light.
    pub(super) fn surface(&self) -> &[Points] {
        self.truth.surface()
    }

    /// Returns the points that the camera sees.
    pub(super) fn seen(&self) -> &SeenTruth {
        self.truth.seen()
    }

    /// Whether each point is in the boundary of opaque shadows.
    pub(super) fn boundary(&self, points: &Points, resolution: &[Resolution]) -> Arc<Vec<bool>> {
        self.truth.boundary(points, resolution)
    }

    /// Returns points on the rays of covered texels, [`crate::reference::truth::MAP_DEPTHS`] per texel at increasing depth, with the
    /// filtered truth there. Points are rounded to floats, and the truth is computed at the rounded point, so that this rounding does not
    /// count against the technique.
    pub(super) fn maps(&self, views: &[View]) -> Arc<OnRays> {
        self.maps.get(views.to_vec(), |views| self.on_rays(views))
    }

    fn on_rays(&self, views: &[View]) -> OnRays {
        let truths = sample_maps(&self.casters, self.scene, views, TEXELS).0;
        let covered = truths.into_iter().filter(|truth| !truth.texels.is_empty());
        let mut rounded = Vec::new();
        let points = |truth: MapTruth| {
            let texels = truth.texels.iter().flat_map(|texel| std::iter::repeat_n(*texel, MAP_DEPTHS as usize));
            rounded
                .extend(texels.zip(&truth.points).map(|(texel, p)| RoundedAnswers::of(&views[truth.map], texel, *p)));
            let visibility = filtered(&self.casters, self.scene, views, truth.light, &truth.points);
            Points::in_space(truth.light, truth.points, visibility)
        };
        (covered.map(points).collect(), rounded)
    }

    /// Returns the scene after `step` steps.
    fn after(&self, step: usize) -> &Scene {
        step.checked_sub(1).and_then(|step| self.moved().get(step)).map_or(self.scene, |moved| &moved.scene)
    }

    /// Returns the filtered truth at all points in space, after `step` steps.
    pub(super) fn filtered(&self, step: usize, views: &[View]) -> Arc<Vec<f64>> {
        self.filtered.get((step, views.to_vec()), |_| {
            let scene = self.after(step);
            let casters = Casters::new(scene);
            let of = |points: &Points| filtered(&casters, scene, views, points.light, &points.positions);
            self.space().iter().flat_map(of).collect()
        })
    }

    /// Whether each point in space is in the boundary of opaque shadows, after `step` steps.
    pub(super) fn boundary_after(&self, step: usize, resolution: &[Resolution]) -> Arc<Vec<bool>> {
        self.boundaries.get((step, resolution.to_vec()), |_| self.in_boundary(self.after(step), resolution))
    }

    fn in_boundary(&self, scene: &Scene, resolution: &[Resolution]) -> Vec<bool> {
        let casters = Casters::new(scene);
        let at = |light: usize, p: &[f32; 3]| {
            let map = scene.first_map(light) + scene.lights[light].map_at(*p);
            let resolution = resolution.get(map).filter(|_| scene.has_triangles());
            resolution.is_some_and(|of| casters.in_boundary(light, of, DVec3::from(p.map(f64::from))))
        };
        let of = |points: &Points| points.positions.par_iter().map(|p| at(points.light, p)).collect::<Vec<_>>();
        self.space().iter().flat_map(of).collect()
    }

    /// Returns the scene with its casters in other orders; nothing if there are fewer than two casters.
    pub(super) fn shuffled(&self) -> impl Iterator<Item = Scene> + '_ {
        let triangles = self.scene.meshes.iter().map(|mesh| mesh.triangles.len());
        let most = triangles.chain([self.scene.particles.len(), self.scene.strands.len()]).max();
        (0..if most > Some(1) { SHUFFLES } else { 0 }).map(|stream| {
            let (mut scene, mut random) = (self.scene.clone(), random(100 + stream as u64));
            // A Fisher–Yates shuffle.
            let mut swaps = |count: usize| -> Vec<[usize; 2]> {
                let other = |i: usize, share: f64| ((share * (i + 1) as f64) as usize).min(i);
                (1..count).rev().map(|i| [i, other(i, random.between(0.0, 1.0))]).collect()
            };
            swaps(scene.particles.len()).into_iter().for_each(|[i, j]| scene.particles.swap(i, j));
            swaps(scene.strands.len()).into_iter().for_each(|[i, j]| scene.strands.swap(i, j));
            for mesh in &mut scene.meshes {
                swaps(mesh.triangles.len()).into_iter().for_each(|[i, j]| mesh.triangles.swap(i, j));
            }
            scene
        })
    }

    /// Returns the scene after each step of its casters; empty if there are no casters.
    pub(super) fn moved(&self) -> &[MovedCasters] {
        self.moved.get_or_init(|| {
            let Some([low, high]) = bounds(self.scene) else { return Vec::new() };
            let step = STEP * (high - low).length() * DVec3::new(0.7, -0.5, 0.5);
            (1..=STEPS).map(|i| MovedCasters::new(self, i as f64 * step)).collect()
        })
    }
}

impl MovedCasters {
    fn new(subject: &Subject, by: DVec3) -> Self {
        let mut scene = subject.scene.clone();
        step(&mut scene, by);
        let casters = Casters::new(&scene);
        let at = |light: usize, p: &[f32; 3]| casters.visibility(light, DVec3::from(p.map(f64::from)));
        let visibility = |points: &Points| points.positions.par_iter().map(|p| at(points.light, p)).collect::<Vec<_>>();
        let visibility = Arc::new(subject.space().iter().flat_map(visibility).collect());
        Self { scene, visibility }
    }
}

/// Error bound for rounding when a point is projected in f32, as a fraction of its distance from the view's origin: half a unit in the last
/// place for the difference, and three half units for a sum of three products.
const PROJECTED: f64 = 4.0 / (1 << 24) as f64;

/// Where a point of a texel's ray lies after its position is rounded to f32.
pub(super) struct RoundedAnswers {
    /// Distance of the point from the ray, in texels: the sum over both axes, plus the error bound of the point's projection. A bilinear
    /// look-up at the point may differ by this much from the value on the ray.
    pub off: f64,
    /// z of the point along the ray.
    pub z: f64,
}

impl RoundedAnswers {
    fn of(view: &View, texel: u32, position: [f32; 3]) -> Self {
        let (at, z) = view.project(DVec3::from(position.map(f64::from)));
        let centre = DVec2::new(f64::from(texel % view.width), f64::from(texel / view.width)) + 0.5;
        let axes = view.axes(DVec3::from(position.map(f64::from)));
        let spread = if view.projection() == Projection::Parallel { 1.0 } else { z };
        let texels = |scale: f32, count: u32| 0.5 * f64::from(scale) * f64::from(count) / spread;
        let projected =
            PROJECTED * axes.length() * (texels(view.scale_x, view.width) + texels(view.scale_y, view.height));
        Self { off: (at - centre).abs().element_sum() + projected, z }
    }
}

/// Returns the filtered truth at points of a light: the result of a bilinear look-up in a map whose texels hold their exact curves. A
/// technique with maps of exact curves would return this; the rest of its error is due to the size of its texels.
fn filtered(casters: &Casters, scene: &Scene, views: &[View], light: usize, points: &[[f32; 3]]) -> Vec<f64> {
    let map = |p: &[f32; 3]| scene.first_map(light) + scene.lights[light].map_at(*p);
    let places: Vec<_> = points.iter().map(|p| Place::of(views, map(p), DVec3::from(p.map(f64::from)))).collect();
    let needed: BTreeSet<_> = places.iter().flat_map(|place| place.texels(views)).flatten().collect();
    let curve = |(map, texel): (usize, [u32; 2])| {
        let ray = views[map].ray(DVec2::from(texel.map(f64::from)) + 0.5);
        ((map, texel), casters.true_curve(map, &views[map], &ray).0)
    };
    let curves: BTreeMap<_, _> = needed.into_iter().collect::<Vec<_>>().into_par_iter().map(curve).collect();
    let at = |(p, place): (&[f32; 3], &Place)| {
        let free = scene.meshes.is_empty() || casters.unblocked(light, DVec3::from(p.map(f64::from)));
        let curve = |texel| curves.get(&texel).map_or(1.0, |curve: &TrueCurve| curve.transmittance(place.depth));
        let [a, b, c, d] = place.texels(views).map(|texel| texel.map_or(1.0, curve));
        let mix = |a: f64, b: f64, share: f64| a * (1.0 - share) + b * share;
        if free { mix(mix(a, b, place.rest.x), mix(c, d, place.rest.x), place.rest.y) } else { 0.0 }
    };
    points.par_iter().zip(&places).map(at).collect()
}

/// The texels and the depth at which a point is looked up.
struct Place {
    map: usize,
    /// The first of the four texels around the point; `None` in front of all casters.
    corner: Option<IVec2>,
    /// The point's offset from that texel's centre, in texels.
    rest: DVec2,
    depth: f64,
}

impl Place {
    fn of(views: &[View], map: usize, position: DVec3) -> Self {
        let view = &views[map];
        let (at, z) = view.project(position);
        // Clamped, so that coordinates far outside the map fit into integers; no texel there is inside the map.
        let at = at.clamp(DVec2::splat(-2.0), DVec2::new(view.width.into(), view.height.into()) + 2.0) - 0.5;
        let corner = (z > f64::from(view.near)).then(|| at.floor().as_ivec2());
        Self { map, corner, rest: at - at.floor(), depth: view.depth(z) }
    }

    /// Returns the four texels around the point, row by row; `None` beyond the map's edge, where nothing casts.
    fn texels(&self, views: &[View]) -> [Option<(usize, [u32; 2])>; 4] {
        let view = &views[self.map];
        [[0, 0], [1, 0], [0, 1], [1, 1]].map(|offset| {
            let [x, y] = (self.corner? + IVec2::from(offset)).to_array().map(|c| u32::try_from(c).ok());
            let (x, y) = (x.filter(|x| *x < view.width)?, y.filter(|y| *y < view.height)?);
            Some((self.map, [x, y]))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The truth in maps must be computed only once for techniques with the same views.
    #[test]
    fn the_truth_of_maps_is_found_once() {
        let scene = (super::super::StressCase::named("few").expect("a case").scene)(2.0);
        let subject = Subject::new(&scene);
        let [small, large] = [8, 16].map(|size| View::volumes(&scene, size));
        let maps = subject.maps(&small);
        assert!(!maps.0.is_empty() && Arc::ptr_eq(&maps, &subject.maps(&small)));
        assert!(!Arc::ptr_eq(&maps, &subject.maps(&large)));
        let [now, later] = [0, 1].map(|step| subject.filtered(step, &small));
        assert!(now != later && Arc::ptr_eq(&later, &subject.filtered(1, &small)));
    }
}
