//! Twin of glsl/technique/ism/splat.glsl: the disc of a point in a light's map.

use super::map::{Axes, Levels, V3, dot, map_way, minus, texel_place};

/// Twin: WIDEST.
const WIDEST: f32 = 3.0;

/// Twins: BESIDE, DEEP.
const BESIDE: f32 = 0.3;
const DEEP: f32 = 1.5;

/// Twin: OWN_NEAR.
const OWN_NEAR: f32 = 0.3;

/// A point on a mesh.
#[derive(Clone, Copy, Debug)]
pub struct Point {
    /// Position in world units.
    pub position: V3,
    /// Unit normal.
    pub normal: V3,
    /// Whether the point lies on a closed surface.
    pub closed: bool,
}

/// Twins: ISM_CULLING, ISM_SLIDE.
#[derive(Clone, Copy, Debug)]
pub struct Culling {
    /// Whether points on one side of closed surfaces are culled.
    pub on: bool,
    /// Whether the side that faces the light is culled and the far side kept; otherwise the reverse.
    pub far: bool,
    /// Whether normals alone decide which side faces the light.
    pub slide: bool,
}

/// Twins: SLANT, ROUNDING.
pub(super) const SLANT: f32 = 1e-3;
pub(super) const ROUNDING: f32 = 1e-6;

/// Returns whether a point lies in front of the light's plane. Twin: is_before.
pub fn is_before(origin: V3, forward: V3, offset: V3) -> bool {
    let sum = |v: V3| v[0].abs() + v[1].abs() + v[2].abs();
    dot(forward, offset) > SLANT * sum(offset) + ROUNDING * sum(origin)
}

/// Returns whether a point in front of the light's plane casts a shadow rather than being culled. Twin: is_seen.
pub fn is_seen(point: &Point, forward: V3, offset: V3, culling: Culling) -> bool {
    let along = if culling.slide { forward } else { offset };
    let away = dot(point.normal, along);
    !(point.closed && culling.on) || if culling.far { away < 0.0 } else { away > 0.0 }
}

/// Twin: Bounds.
#[derive(Clone, Copy, Debug)]
pub struct Bounds {
    /// Centre of the box, in world units.
    pub middle: V3,
    /// Half-extents of the box.
    pub sides: V3,
}

/// A point used by a light, with its disc's radius and the box that limits the disc.
#[derive(Clone, Copy, Debug)]
pub struct Taken {
    /// The point.
    pub point: Point,
    /// Radius of the disc, in world units.
    pub radius: f32,
    /// Box outside which the disc is cut off; `None` if points do not adapt.
    pub bounds: Option<Bounds>,
}

/// A point's disc, projected into a light's map. Twin: Splat.
#[derive(Clone, Copy, Debug)]
pub struct Splat {
    /// Level into which the disc is splatted.
    pub level: usize,
    /// Centre of the disc, in texels of the level.
    pub middle: [f32; 2],
    /// Distance from the centre up to which texels may be covered, in texels of the level.
    pub extent: [f32; 2],
    offset: V3,
    normal: V3,
    plane: f32,
    least: f32,
    most: f32,
    square: f32,
    distance: f32,
    bounds: Option<Bounds>,
}

/// Twin: project.
pub fn project(size: u32, axes: &Axes, origin: V3, taken: &Taken, culling: Culling) -> Option<Splat> {
    let Taken { point, radius, bounds } = taken;
    let radius = *radius;
    let offset = minus(point.position, origin);
    if !(is_seen(point, axes.forward, offset, culling) && is_before(origin, axes.forward, offset)) {
        return None;
    }
    let square = dot(offset, offset);
    let distance = square.sqrt();
    let (offset, normal) = (axes.into_axes(offset), axes.into_axes(point.normal));
    let ahead = distance + offset[2];
    let mut reach = radius / ahead * (0.5 * size as f32);
    let mut level = 0;
    while size >> (level + 1) >= 4 && reach > WIDEST {
        reach *= 0.5;
        level += 1;
    }
    let middle = [0, 1].map(|i| (offset[i] / ahead * 0.5 + 0.5) * (size >> level) as f32);
    let plane = dot(normal, offset);
    let (wide, slant) = (reach + BESIDE, normal[2] + plane / distance);
    let extent = [0, 1].map(|i| {
        let across = normal[i] - (2.0 * (offset[i] / ahead * 0.5 + 0.5) - 1.0) * slant;
        wide * ((1.0 - across * across).max(0.0).sqrt() * (1.0 + 2.0 * wide / (size >> level) as f32)).min(1.0)
    });
    let (least, deep) = ((distance - radius).max(0.5 * distance), ahead * (2.0 * DEEP / (size >> level) as f32));
    let most = distance + radius.max(deep);
    let all = radius + ahead * (2.0 * BESIDE / (size >> level) as f32);
    let near = square < 3e38 && middle.iter().all(|m| m.abs() < 1e6);
    let square = all * all;
    let bounds = bounds.map(|bounds| Bounds { middle: minus(bounds.middle, origin), ..bounds });
    near.then_some(Splat { level, middle, extent, offset, normal, plane, least, most, square, distance, bounds })
}

impl Splat {
    /// Returns the distance of the point's plane along the ray of the texel that contains the point. Twin: own_distance.
    fn own_distance(&self, side: i32, own: [i32; 2]) -> f32 {
        let way = map_way(texel_place(side, own));
        let along = self.plane / dot(self.normal, way);
        if along > 0.0 { (along * (2.0 - way[2])).max(self.least).min(self.most) } else { self.distance }
    }

    /// Returns the disc's distance along the ray through a texel's centre; `None` if the ray misses the disc. Twin: disc_at.
    pub fn disc_at(&self, axes: &Axes, side: i32, texel: [i32; 2]) -> Option<f32> {
        let way = map_way(texel_place(side, texel));
        let along = self.plane / dot(self.normal, way);
        let place = way.map(|w| along * w);
        let off = minus(place, self.offset);
        let within = |bounds: Bounds| {
            let world =
                [0, 1, 2].map(|i| axes.right[i] * place[0] + axes.up[i] * place[1] + axes.forward[i] * place[2]);
            (0..3).all(|i| (world[i] - bounds.middle[i]).abs() <= bounds.sides[i])
        };
        let covered = along > 0.0 && dot(off, off) <= self.square && self.bounds.is_none_or(within);
        covered.then_some(along * (2.0 - way[2]))
    }

    /// Returns the texels covered by the disc, with its distance in each.
    pub fn texels(&self, axes: &Axes, side: i32) -> Vec<([i32; 2], f32)> {
        let own = self.middle.map(|m| m.floor() as i32);
        let inside = |t: i32| (0..side).contains(&t);
        let near = |i: usize| (self.middle[i] - own[i] as f32 - 0.5).abs() <= OWN_NEAR;
        let mut all = Vec::new();
        if own.iter().all(|t| inside(*t)) && (self.bounds.is_none() || near(0) && near(1)) {
            all.push((own, self.own_distance(side, own)));
        }
        let low = [0, 1].map(|i| ((self.middle[i] - self.extent[i] - 0.5).ceil() as i32).clamp(0, side));
        let high = [0, 1].map(|i| ((self.middle[i] + self.extent[i] - 0.5).floor() as i32).clamp(-1, side - 1));
        for y in low[1]..=high[1] {
            all.extend((low[0]..=high[0]).filter_map(|x| Some(([x, y], self.disc_at(axes, side, [x, y])?))));
        }
        all
    }
}

/// Builds the map of a light from all its points, before holes are filled; also returns how many points were not culled. Twins:
/// glsl/technique/ism/tiled.comp and splat.comp.
pub fn splat(size: u32, normal: V3, origin: V3, points: &[Taken], culling: Culling) -> (Levels, u32) {
    let axes = Axes::of(normal);
    let (mut levels, mut seen) = (Levels::new(size), 0);
    for splat in points.iter().filter_map(|taken| project(size, &axes, origin, taken, culling)) {
        seen += 1;
        for (texel, distance) in splat.texels(&axes, levels.side(splat.level)) {
            levels.set(splat.level, texel, levels.get(splat.level, texel).min(distance));
        }
    }
    (levels, seen)
}
