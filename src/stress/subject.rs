//! A scene of a case, with what is true there, which all techniques share.

use super::strewn::random;
use crate::Result;
use crate::measure::{Extent, Points, Truth, Wanted};
use crate::reference::truth::{Casters, TrueCurve, bounds, sample_maps};
use crate::scene::{Resolution, Scene, View};
use glam::{DVec2, DVec3, IVec2};
use rayon::prelude::*;
use std::collections::BTreeSet;
use std::sync::{Arc, OnceLock};

/// How many orders the same casters are given in.
pub const SHUFFLES: usize = 8;

/// Texels of all maps together that are asked.
const TEXELS: usize = 96;

/// Points of each light in space, and on meshes as many.
const POINTS: usize = 1024;

/// Pixels of the camera that half of the points on meshes are seen by.
const PICTURE: [u32; 2] = [96, 64];

/// By how much all casters move in a step, of the diagonal of their box, and how many steps there are.
const STEP: f64 = 1e-3;
const STEPS: usize = 3;

/// A scene with its truth.
pub struct Subject<'a> {
    /// The scene.
    pub scene: &'a Scene,
    truth: Truth<'a>,
    casters: Casters<'a>,
    moved: OnceLock<Vec<Moved>>,
}

/// The scene a little later, and what is true there at the points in space.
pub(super) struct Moved {
    pub scene: Scene,
    pub visibility: Vec<f64>,
}

impl<'a> Subject<'a> {
    /// Of that scene.
    pub fn new(scene: &'a Scene) -> Self {
        // Where there is nothing, somewhere.
        let bounds = bounds(scene).unwrap_or([DVec3::NEG_ONE, DVec3::ONE]);
        let wanted = Wanted {
            extent: Extent::Sample,
            points: POINTS,
            picture: PICTURE,
            bounds: Some(bounds),
            watched: Arc::default(),
        };
        Self { scene, truth: Truth::new(scene, wanted), casters: Casters::new(scene), moved: OnceLock::new() }
    }

    /// Points in space, of each light.
    pub(super) fn space(&self) -> &[Points] {
        self.truth.space()
    }

    /// Points on meshes, of each light.
    pub(super) fn surface(&self) -> &[Points] {
        self.truth.surface()
    }

    /// Whether each point is in the boundary of opaque shadows.
    pub(super) fn boundary(&self, points: &Points, resolution: &[Resolution]) -> Arc<Vec<bool>> {
        self.truth.boundary(points, resolution)
    }

    /// Points on the rays of covered texels, [`crate::reference::truth::MAP_DEPTHS`] a texel, depth rising, and what a bilinear
    /// look-up would find there if each texel had its exact curve: at the very point, rounded as it is, so that no rounding of
    /// the point is held against who answers.
    pub(super) fn maps(&self, views: &[View]) -> Result<Vec<Points>> {
        let truths = sample_maps(&self.casters, self.scene, views, TEXELS).0;
        let points = truths.into_iter().filter(|truth| !truth.texels.is_empty()).map(|truth| {
            let curves = Curves::about(&self.casters, truth.map, &views[truth.map], &truth.points);
            let at = |p: &[f32; 3]| {
                let position = DVec3::from(p.map(f64::from));
                let free = self.scene.meshes.is_empty() || self.casters.unblocked(truth.light, position);
                if free { curves.filtered(position) } else { 0.0 }
            };
            let visibility = truth.points.par_iter().map(at).collect();
            Points::in_space(truth.light, truth.points, visibility)
        });
        Ok(points.collect())
    }

    /// The same casters in other orders; none where there are fewer than two.
    pub(super) fn shuffled(&self) -> impl Iterator<Item = Scene> + '_ {
        let triangles = self.scene.meshes.iter().map(|mesh| mesh.triangles.len());
        let most = triangles.chain([self.scene.particles.len(), self.scene.strands.len()]).max();
        (0..if most > Some(1) { SHUFFLES } else { 0 }).map(|stream| {
            let (mut scene, mut random) = (self.scene.clone(), random(100 + stream as u64));
            // Fisher and Yates.
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

    /// All casters a little farther on, step by step; none where there are none.
    pub(super) fn moved(&self) -> &[Moved] {
        self.moved.get_or_init(|| {
            let Some([low, high]) = bounds(self.scene) else { return Vec::new() };
            let step = STEP * (high - low).length() * DVec3::new(0.7, -0.5, 0.5);
            (1..=STEPS).map(|i| Moved::new(self, i as f64 * step)).collect()
        })
    }
}

impl Moved {
    fn new(subject: &Subject, by: DVec3) -> Self {
        let mut scene = subject.scene.clone();
        let step = |p: &mut [f32; 3]| *p = (DVec3::from(p.map(f64::from)) + by).as_vec3().into();
        scene.particles.iter_mut().for_each(|particle| step(&mut particle.position));
        scene.strands.iter_mut().for_each(|strand| [&mut strand.start, &mut strand.end].into_iter().for_each(step));
        scene.meshes.iter_mut().flat_map(|mesh| &mut mesh.positions).for_each(step);
        let casters = Casters::new(&scene);
        let at = |light: usize, p: &[f32; 3]| casters.visibility(light, DVec3::from(p.map(f64::from)));
        let visibility = |points: &Points| points.positions.par_iter().map(|p| at(points.light, p)).collect::<Vec<_>>();
        let visibility = subject.space().iter().flat_map(visibility).collect();
        Self { scene, visibility }
    }
}

/// The exact curves of a map's texels, sorted by texel.
struct Curves<'a> {
    view: &'a View,
    all: Vec<([i32; 2], TrueCurve)>,
}

impl<'a> Curves<'a> {
    /// Of the texels that a bilinear look-up at these points has.
    fn about(casters: &Casters, map: usize, view: &'a View, points: &[[f32; 3]]) -> Self {
        let corners = |p: &[f32; 3]| {
            let (corner, _) = footprint(view, DVec3::from(p.map(f64::from)));
            [0, 1, 2, 3].map(|i| (corner + IVec2::new(i % 2, i / 2)).to_array())
        };
        let inside = |[x, y]: &[i32; 2]| (0..view.width as i32).contains(x) && (0..view.height as i32).contains(y);
        let texels: BTreeSet<[i32; 2]> = points.iter().flat_map(corners).filter(inside).collect();
        let curve = |texel: [i32; 2]| {
            let ray = view.ray(DVec2::new(f64::from(texel[0]) + 0.5, f64::from(texel[1]) + 0.5));
            (texel, casters.true_curve(map, view, &ray).0)
        };
        Self { view, all: texels.into_iter().collect::<Vec<_>>().into_par_iter().map(curve).collect() }
    }

    fn filtered(&self, position: DVec3) -> f64 {
        let (_, z) = self.view.project(position);
        if z <= f64::from(self.view.near) {
            return 1.0;
        }
        let (corner, rest) = footprint(self.view, position);
        let depth = self.view.depth(z);
        let texel = |i: i32| {
            let texel = (corner + IVec2::new(i % 2, i / 2)).to_array();
            let found = self.all.binary_search_by_key(&texel, |(texel, _)| *texel);
            found.map_or(1.0, |place| self.all[place].1.transmittance(depth))
        };
        let row = |y: i32| texel(2 * y) * (1.0 - rest.x) + texel(2 * y + 1) * rest.x;
        row(0) * (1.0 - rest.y) + row(1) * rest.y
    }
}

/// The first of the four texels about a point, and how far on the point is. Twin: view_footprint in glsl/world/view.glsl.
fn footprint(view: &View, position: DVec3) -> (IVec2, DVec2) {
    let (at, _) = view.project(position);
    // Far outside all texels are outside.
    let at = at.clamp(DVec2::splat(-2.0), DVec2::new(view.width.into(), view.height.into()) + 2.0) - 0.5;
    (at.floor().as_ivec2(), at - at.floor())
}
