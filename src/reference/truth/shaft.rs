//! All rays from a light to the points of a small box: whether meshes block none, some or all of them.

use super::alpha::Coverage;
use super::meshes::{Meshes, Triangle};
use crate::scene::{Projection, View};
use bvh::aabb::{Aabb, IntersectsAabb};
use glam::{DVec2, DVec3};

/// Areas below this count as zero, in texels². Rounding leaves such slivers along edges shared by triangles: a corner is rounded to 2⁻⁵² of
/// its distance from the view's origin. That is 10⁻¹¹ texels in a view of 65,536 texels per side, and a square is several texels wide.
const NOTHING: f64 = 1e-9;

/// Number of cuts after which a square is assumed to be partly lit, to bound the time.
const MOST_CUTS: usize = 1 << 16;

/// The half space `normal · p <= most`. Positions are relative to the view's origin, to lose less to rounding in scenes far from the world
/// origin.
#[derive(Clone, Copy)]
pub(super) struct Half {
    pub normal: DVec3,
    pub most: f64,
}

/// The intersection of half spaces.
pub(super) struct Shaft {
    /// Origin of the view, in world units.
    origin: DVec3,
    halves: Vec<Half>,
}

impl Shaft {
    /// Returns the part of a convex polygon inside the shaft, relative to the view's origin.
    fn part(&self, corners: &[DVec3]) -> Vec<DVec3> {
        let corners = corners.iter().map(|corner| *corner - self.origin).collect();
        self.halves.iter().fold(corners, |polygon, half| clip(polygon, *half))
    }
}

impl IntersectsAabb<f64, 3> for Shaft {
    /// Conservative: never returns false if the shaft and the box overlap.
    fn intersects_aabb(&self, aabb: &Aabb<f64, 3>) -> bool {
        self.halves.iter().all(|half| {
            let corner = |i: usize| if half.normal[i] > 0.0 { aabb.min[i] } else { aabb.max[i] };
            (0..3).map(|i| half.normal[i] * (corner(i) - self.origin[i])).sum::<f64>() <= half.most
        })
    }
}

/// A box around a point, along the axes of a light's view: its width is in texels, its length along z in world units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Neighbourhood<'a> {
    /// The light's view.
    pub view: &'a View,
    /// The centre of the box.
    pub position: DVec3,
    /// Half of the box's width, in texels.
    pub reach: f64,
    /// Half of the box's length, in world units.
    pub depth: f64,
}

impl Neighbourhood<'_> {
    /// Returns whether any part of the box is free although its centre is `blocked`, or blocked although its centre is not.
    pub fn differs(&self, meshes: &Meshes, blocked: bool) -> bool {
        let z = self.range();
        // A triangle within the box blocks only the part of the box behind it.
        let most = if blocked { z.x } else { z.y };
        self.is_other(meshes, blocked, self.before(z.y), |_, part| clip(part, self.before(most)))
    }

    /// Like [`Neighbourhood::differs`], but only at the centre's own depth. Every triangle is first pushed away from the light, by the
    /// change of its plane's depth over `texels` texels, and clipped at the near plane. Surfaces that contain the centre do not count.
    pub fn differs_pushed(&self, meshes: &Meshes, blocked: bool, texels: f64) -> bool {
        let view = self.view;
        let z = self.range();
        let along = view.ray_through(self.position).direction;
        let texel = |axis: [f32; 3], scale: f32, count: u32| vec(axis) * (2.0 / (f64::from(scale) * f64::from(count)));
        let (right, up) = (texel(view.right, view.scale_x, view.width), texel(view.up, view.scale_y, view.height));
        let middle = (z.x + z.y) / 2.0;
        let nearest = if blocked { z.x } else { middle - meshes.epsilon };
        let most = |triangle: &Triangle| {
            let normal = triangle.normal();
            let (across, facing) = (normal.dot(right).abs() + normal.dot(up).abs(), normal.dot(along).abs());
            match view.projection() {
                Projection::Parallel => nearest - texels * across / facing,
                Projection::Perspective => nearest * (1.0 - texels * across / facing),
            }
        };
        let behind = self.behind(view.near.into());
        let pushed = |triangle: &Triangle, part| clip(clip(part, behind), self.before(most(triangle)));
        self.is_other(meshes, blocked, self.before(middle), pushed)
    }

    /// Like [`Neighbourhood::differs`], for depth maps: only at the centre's own depth, and without the parts of casters in front of the
    /// near plane. If the surface's `normal` is given, only casters above the plane through the centre count. The depth that a texel holds
    /// may come from a point up to `snap` texels away from the texel's centre.
    pub fn differs_stored(&self, meshes: &Meshes, blocked: bool, normal: Option<DVec3>, snap: f64) -> bool {
        let z = self.range();
        let [right, up] = self.view.texel_at(self.position);
        let along = self.view.ray_through(self.position).direction;
        let (middle, behind) = ((z.x + z.y) / 2.0, self.behind(self.view.near.into()));
        let above = |normal: DVec3| {
            let beside = snap * (normal.dot(right).abs() + normal.dot(up).abs());
            let by = if blocked { beside + self.depth * normal.dot(along).abs() } else { -beside };
            Half { normal: -normal, most: -normal.dot(self.position - vec(self.view.origin)) - by }
        };
        let counts: Vec<_> = [behind].into_iter().chain(normal.map(above)).collect();
        let before = self.before(if blocked { z.x } else { middle - meshes.epsilon });
        let stored = |_: &Triangle, part| counts.iter().fold(clip(part, before), |part, half| clip(part, *half));
        self.is_other(meshes, blocked, self.before(middle), stored)
    }

    /// Returns whether the light's state differs from `blocked` in some part of the box's square cross-section. Only triangles in front of
    /// `end` count, and only the parts of them that `cut` keeps.
    fn is_other(
        &self,
        meshes: &Meshes,
        blocked: bool,
        end: Half,
        cut: impl Fn(&Triangle, Vec<DVec3>) -> Vec<DVec3>,
    ) -> bool {
        let shaft = self.shaft(&[end]);
        let middle = self.view.project(self.position).0;
        let mut blockers = Vec::new();
        for triangle in meshes.meeting(&shaft) {
            let met = cut(triangle, shaft.part(&triangle.corners));
            let coverage = if met.is_empty() { Coverage::None } else { self.coverage(&shaft, triangle, meshes) };
            if !blocked && coverage != Coverage::None {
                return true;
            }
            // What may be a hole hides nothing for certain.
            if coverage != Coverage::All {
                continue;
            }
            // Relative to the centre: far from it, areas would be small differences of large numbers.
            blockers.push(Flat::new(met.iter().map(|p| self.view.project_offset(*p).0 - middle).collect()));
        }
        let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
        let square = Flat::new(corners.map(|corner| self.reach * DVec2::from(corner)).into());
        blocked && is_left(square, blockers)
    }

    /// Returns how much of a triangle blocks light in the shaft. Techniques may look at texels a little beyond the triangle's border, so all
    /// of its plane in the shaft counts.
    fn coverage(&self, shaft: &Shaft, triangle: &Triangle, meshes: &Meshes) -> Coverage {
        if !triangle.has_alpha() {
            return Coverage::All;
        }
        let part = shaft.part(&triangle.plane(self.position, 4.0 * meshes.extent));
        triangle.coverage(&part.iter().map(|corner| *corner + shaft.origin).collect::<Vec<_>>())
    }

    /// Returns whether the centre is behind the eye of a perspective view.
    pub fn is_behind(&self) -> bool {
        self.view.projection() == Projection::Perspective && self.view.project(self.position).1 <= 0.0
    }

    /// Returns whether a closed surface passes through the box.
    pub fn meets_closed(&self, meshes: &Meshes) -> bool {
        let z = self.range();
        let shaft = self.shaft(&[self.before(z.y), self.behind(z.x)]);
        meshes.meeting(&shaft).any(|triangle| triangle.side != 0 && !shaft.part(&triangle.corners).is_empty())
    }

    /// Returns the box's minimum and maximum z.
    fn range(&self) -> DVec2 {
        let z = self.view.project(self.position).1;
        DVec2::new(z - self.depth, z + self.depth)
    }

    /// Returns the half space in front of `z`.
    fn before(&self, z: f64) -> Half {
        Half { normal: vec(self.view.forward), most: z }
    }

    /// Returns the half space behind `z`.
    fn behind(&self, z: f64) -> Half {
        Half { normal: -vec(self.view.forward), most: -z }
    }

    /// Returns the shaft of rays through the box, clipped to these half spaces as well.
    fn shaft(&self, halves: &[Half]) -> Shaft {
        Shaft { origin: vec(self.view.origin), halves: [&self.sides()[..], halves].concat() }
    }

    /// Returns the half spaces that bound the box's texels on four sides and, in a perspective view, the one in front of the eye.
    fn sides(&self) -> [Half; 5] {
        let view = self.view;
        let forward = vec(view.forward);
        let middle = view.project(self.position).0;
        let (low, high) = (middle - self.reach, middle + self.reach);
        let perspective = view.projection() == Projection::Perspective;
        // A texel coordinate, multiplied by z in a perspective view, is linear in the position.
        let half = |axis: [f32; 3], scale: f32, count: u32, at: f64, sign: f64| {
            let middle = f64::from(count) / 2.0;
            let across = vec(axis) * (f64::from(scale) * middle);
            let along = if perspective { forward * (middle - at) } else { DVec3::ZERO };
            let normal = sign * (across + along);
            Half { normal, most: if perspective { 0.0 } else { sign * (at - middle) } }
        };
        // The eye itself is left out, since it has no texel coordinates.
        let (ahead, eye) = if perspective { (forward, 1e-6 * f64::from(view.far)) } else { (DVec3::ZERO, 0.0) };
        let ahead = Half { normal: -ahead, most: -eye };
        [
            half(view.right, view.scale_x, view.width, low.x, -1.0),
            half(view.right, view.scale_x, view.width, high.x, 1.0),
            half(view.up, view.scale_y, view.height, low.y, -1.0),
            half(view.up, view.scale_y, view.height, high.y, 1.0),
            ahead,
        ]
    }
}

/// Returns the part of a convex polygon inside a half space; empty if that part is a line or point.
pub(super) fn clip(polygon: Vec<DVec3>, half: Half) -> Vec<DVec3> {
    let beyond = |p: &DVec3| half.normal.dot(*p) - half.most;
    if polygon.iter().all(|p| beyond(p) <= 0.0) {
        return polygon;
    }
    let part = cut(&polygon, beyond, |a, b, share| a + (b - a) * share);
    if part.len() < 3 { Vec::new() } else { part }
}

/// Returns the part of a convex polygon where `beyond` is not positive.
fn cut<P: Copy>(polygon: &[P], beyond: impl Fn(&P) -> f64, between: impl Fn(P, P, f64) -> P) -> Vec<P> {
    let mut part = Vec::with_capacity(polygon.len() + 1);
    for (i, here) in polygon.iter().enumerate() {
        let next = &polygon[(i + 1) % polygon.len()];
        let (at_here, at_next) = (beyond(here), beyond(next));
        if at_here <= 0.0 {
            part.push(*here);
        }
        if at_here < 0.0 && at_next > 0.0 || at_here > 0.0 && at_next < 0.0 {
            part.push(between(*here, *next, at_here / (at_here - at_next)));
        }
    }
    part
}

/// A convex polygon.
struct Flat {
    corners: Vec<DVec2>,
    /// Signed area, see [`area`].
    area: f64,
    low: DVec2,
    high: DVec2,
}

impl Flat {
    fn new(corners: Vec<DVec2>) -> Self {
        let include = |(low, high): (DVec2, DVec2), c: &DVec2| (low.min(*c), high.max(*c));
        let (low, high) = corners.iter().fold((DVec2::MAX, DVec2::MIN), include);
        Self { area: area(&corners), corners, low, high }
    }

    /// Returns whether the bounding boxes overlap and `other` is not degenerate.
    fn meets(&self, other: &Self) -> bool {
        other.area.is_normal() && self.low.cmplt(other.high).all() && other.low.cmplt(self.high).all()
    }

    /// Subtracts another polygon from this one and returns convex pieces.
    fn without(self, other: &Self) -> Vec<Self> {
        let (mut inside, mut pieces) = (self.corners.clone(), Vec::new());
        for (i, from) in other.corners.iter().enumerate() {
            let edge = other.corners[(i + 1) % other.corners.len()] - *from;
            // Positive outside.
            let out = |p: &DVec2| -edge.perp_dot(*p - *from) * other.area.signum();
            let between = |a: DVec2, b: DVec2, share: f64| a + (b - a) * share;
            let outside = cut(&inside, |p| -out(p), between);
            if area(&outside).abs() > NOTHING {
                pieces.push(Self::new(outside));
            }
            inside = cut(&inside, out, between);
        }
        // If the polygons do not overlap, this one stays in one piece.
        if area(&inside).abs() > NOTHING { pieces } else { vec![self] }
    }
}

/// Returns whether part of a polygon lies outside all polygons in `others`. The search is depth-first: each piece is cut by all polygons
/// before the next piece is cut, so it stops at the first piece that remains.
fn is_left(polygon: Flat, mut others: Vec<Flat>) -> bool {
    // The largest polygon comes first, so that few pieces remain for the smaller ones.
    others.sort_by(|a, b| b.area.abs().total_cmp(&a.area.abs()));
    // Each piece, with the number of leading polygons in `others` known not to overlap it.
    let (mut pieces, mut cuts) = (vec![(polygon, 0)], 0);
    while let Some((piece, outside)) = pieces.pop() {
        let met = others[outside..].iter().position(|other| piece.meets(other));
        let Some(met) = met.filter(|_| cuts < MOST_CUTS) else { return true };
        cuts += 1;
        let outside = outside + met + 1;
        pieces.extend(piece.without(&others[outside - 1]).into_iter().map(|piece| (piece, outside)));
    }
    false
}

/// Returns the signed area, positive if the corners run counter-clockwise.
fn area(polygon: &[DVec2]) -> f64 {
    (0..polygon.len()).map(|i| polygon[i].perp_dot(polygon[(i + 1) % polygon.len()])).sum::<f64>() / 2.0
}

fn vec(v: [f32; 3]) -> DVec3 {
    DVec3::from(v.map(f64::from))
}
