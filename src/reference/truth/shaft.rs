//! The rays from a light to all of a small box: whether meshes block all of them, or none.

use super::meshes::{Meshes, Triangle};
use crate::scene::{Projection, View};
use bvh::aabb::{Aabb, IntersectsAabb};
use glam::{DVec2, DVec3};

/// What is left of a square counts as nothing below this, texels²: edges that triangles share leave so much by rounding. A corner
/// is rounded to 2⁻⁵² of its distance from the view's origin, which is 10⁻¹¹ texels in a view of 65,536 texels per side; and a square
/// is some texels wide.
const NOTHING: f64 = 1e-9;

/// Times that a square is cut, beyond which it is taken to be partly lit.
const MOST_CUTS: usize = 1 << 16;

/// On one side of a plane: where `normal · p <= most`, from the view's origin, so that what lies far off is no rounder.
#[derive(Clone, Copy)]
struct Half {
    normal: DVec3,
    most: f64,
}

/// What is on the inner side of all of these.
pub(super) struct Shaft {
    /// The origin of the view, world units.
    origin: DVec3,
    halves: Vec<Half>,
}

impl Shaft {
    /// The part of a triangle that is in it, from the view's origin.
    fn part(&self, corners: [DVec3; 3]) -> Vec<DVec3> {
        let corners = corners.map(|corner| corner - self.origin);
        self.halves.iter().fold(corners.to_vec(), |polygon, half| clip(polygon, *half))
    }
}

impl IntersectsAabb<f64, 3> for Shaft {
    /// Never false where they meet.
    fn intersects_aabb(&self, aabb: &Aabb<f64, 3>) -> bool {
        self.halves.iter().all(|half| {
            let corner = |i: usize| if half.normal[i] > 0.0 { aabb.min[i] } else { aabb.max[i] };
            (0..3).map(|i| half.normal[i] * (corner(i) - self.origin[i])).sum::<f64>() <= half.most
        })
    }
}

/// A box about a point, in the directions of a light's view: so many texels to either side, and so far along z.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Neighbourhood<'a> {
    /// The light's view.
    pub view: &'a View,
    /// Its middle.
    pub position: DVec3,
    /// Half its width, texels.
    pub reach: f64,
    /// Half its length, world units.
    pub depth: f64,
}

impl Neighbourhood<'_> {
    /// Whether any of it is blocked from the light where its middle is not (`blocked`), or the other way round.
    pub fn differs(&self, meshes: &Meshes, blocked: bool) -> bool {
        let z = self.range();
        // What is met within the box blocks only what is behind it.
        let most = if blocked { z.x } else { z.y };
        self.is_other(meshes, blocked, self.before(z.y), |_, part| clip(part, self.before(most)))
    }

    /// The same of its middle's depth alone, where every triangle is pushed away from the light by what its plane changes over so
    /// many texels, and is cut off at the view's near plane. Surfaces that the middle lies on are none.
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

    /// The same by the depth of its middle alone, and for maps, which hold nothing before the view's near plane. On a surface with a normal
    /// only casters above the plane through the middle count; a texel's depth may come from a place `snap` texels beside it.
    pub fn differs_stored(&self, meshes: &Meshes, blocked: bool, normal: Option<DVec3>, snap: f64) -> bool {
        let z = self.range();
        let [right, up] = self.view.texel_at(self.position);
        let along = self.view.ray_through(self.position).direction;
        // What may end a texel's light, and what does.
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

    /// Whether part of the square is free where `blocked`, else whether part is not: by the parts of triangles within its rays up to `end`,
    /// as `cut` leaves them.
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
            let met = cut(triangle, shaft.part(triangle.corners));
            if !blocked && !met.is_empty() {
                return true;
            }
            // About the middle: an area about a corner of the view would be a difference of numbers as large as the view.
            blockers.push(Flat::new(met.iter().map(|p| self.view.project_offset(*p).0 - middle).collect()));
        }
        let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
        let square = Flat::new(corners.map(|corner| self.reach * DVec2::from(corner)).into());
        blocked && is_left(square, blockers)
    }

    /// Whether it is not in front of an eye.
    pub fn is_behind(&self) -> bool {
        self.view.projection() == Projection::Perspective && self.view.project(self.position).1 <= 0.0
    }

    /// Whether the surface of something closed passes through it.
    pub fn meets_closed(&self, meshes: &Meshes) -> bool {
        let z = self.range();
        let shaft = self.shaft(&[self.before(z.y), self.behind(z.x)]);
        meshes.meeting(&shaft).any(|triangle| triangle.side != 0 && !shaft.part(triangle.corners).is_empty())
    }

    /// Its least and greatest z.
    fn range(&self) -> DVec2 {
        let z = self.view.project(self.position).1;
        DVec2::new(z - self.depth, z + self.depth)
    }

    /// Up to a z.
    fn before(&self, z: f64) -> Half {
        Half { normal: vec(self.view.forward), most: z }
    }

    /// From a z on.
    fn behind(&self, z: f64) -> Half {
        Half { normal: -vec(self.view.forward), most: -z }
    }

    /// What is within its sides and these.
    fn shaft(&self, halves: &[Half]) -> Shaft {
        Shaft { origin: vec(self.view.origin), halves: [&self.sides()[..], halves].concat() }
    }

    /// Between its outermost texels, and in front of an eye.
    fn sides(&self) -> [Half; 5] {
        let view = self.view;
        let forward = vec(view.forward);
        let middle = view.project(self.position).0;
        let (low, high) = (middle - self.reach, middle + self.reach);
        let perspective = view.projection() == Projection::Perspective;
        // A texel's coordinate, times z where there is perspective, is linear in the position.
        let half = |axis: [f32; 3], scale: f32, count: u32, at: f64, sign: f64| {
            let middle = f64::from(count) / 2.0;
            let across = vec(axis) * (f64::from(scale) * middle);
            let along = if perspective { forward * (middle - at) } else { DVec3::ZERO };
            let normal = sign * (across + along);
            Half { normal, most: if perspective { 0.0 } else { sign * (at - middle) } }
        };
        // Nothing at the eye itself, where texels mean nothing.
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

/// The part of a convex polygon that is on the inner side; nothing where that is a line.
fn clip(polygon: Vec<DVec3>, half: Half) -> Vec<DVec3> {
    let beyond = |p: &DVec3| half.normal.dot(*p) - half.most;
    if polygon.iter().all(|p| beyond(p) <= 0.0) {
        return polygon;
    }
    let part = cut(&polygon, beyond, |a, b, share| a + (b - a) * share);
    if part.len() < 3 { Vec::new() } else { part }
}

/// The part of a convex polygon where `beyond` is not positive.
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
    /// As [`area`] has it.
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

    /// Whether no line along an axis is between them, and neither is a line itself.
    fn meets(&self, other: &Self) -> bool {
        other.area.is_normal() && self.low.cmplt(other.high).all() && other.low.cmplt(self.high).all()
    }

    /// It less another polygon: convex pieces.
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
        // What the other misses stays in one piece.
        if area(&inside).abs() > NOTHING { pieces } else { vec![self] }
    }
}

/// Whether anything of a polygon is in none of the others. One piece of it is followed through all of them before the next is
/// looked at: the first that is left is the answer.
fn is_left(polygon: Flat, mut others: Vec<Flat>) -> bool {
    // The largest first, so that little is left for the others.
    others.sort_by(|a, b| b.area.abs().total_cmp(&a.area.abs()));
    // Each with how many of the others it is outside of.
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

/// Positive where the corners turn counter-clockwise.
fn area(polygon: &[DVec2]) -> f64 {
    (0..polygon.len()).map(|i| polygon[i].perp_dot(polygon[(i + 1) % polygon.len()])).sum::<f64>() / 2.0
}

fn vec(v: [f32; 3]) -> DVec3 {
    DVec3::from(v.map(f64::from))
}
