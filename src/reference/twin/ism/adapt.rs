//! Twin of glsl/technique/ism/adapt.comp and adaptive.glsl.

use super::clusters::{CLUSTER, Cluster};
use super::map::{V3, dot, minus};
use super::points::hash;
use super::splat::{Bounds, Culling, ROUNDING, SLANT};

/// Twins: RANKS, RANK_SHIFT, LOWEST_RANK, LOWEST_RATE, RATES.
const RANKS: u32 = 128;
const RANK_SHIFT: u32 = 20;
const LOWEST_RANK: u32 = 951;
const LOWEST_RATE: u32 = 936;
const RATES: u32 = 97;

/// Twins: LEAST_FACING, LEAST_NEAR.
const LEAST_FACING: f32 = 0.25;
const LEAST_NEAR: f32 = 0.25;

/// Twin: TAKEN_BITS.
const TAKEN_BITS: u32 = 18;

/// Parameters by which each light chooses its points. Twins: AdaptPush, ISM_SIZE, ISM_CULLING, ISM_SLIDE, head.area.
#[derive(Clone, Copy, Debug)]
pub struct Choice {
    /// Texels per side of a map.
    pub size: u32,
    /// Maximum number of points that a light uses.
    pub points: u32,
    /// Total area of all triangles.
    pub area: f32,
    /// Position of the viewer's eye.
    pub eye: V3,
    /// Clusters closer to the eye than this all count as near.
    pub near: f32,
    /// Which points are culled.
    pub culling: Culling,
}

/// Twin: taken_index.
pub fn taken_index(code: u32) -> usize {
    (code & ((1 << TAKEN_BITS) - 1)) as usize
}

/// Returns how many times the cluster's area was halved to get the area represented by a point.
pub fn halved(code: u32) -> u32 {
    code >> TAKEN_BITS
}

/// Twin: taken_radius.
pub fn taken_radius(code: u32, radius: f32) -> f32 {
    let halved = halved(code);
    let share = radius * if halved & 1 == 1 { std::f32::consts::SQRT_2 } else { 2.0 };
    share / (1 << (halved >> 1)) as f32
}

/// Twins: MARGIN_POOL, MARGIN_OWN.
const MARGIN_POOL: f32 = 0.05;
const MARGIN_OWN: f32 = 0.1;

/// Twin: taken_bounds.
pub fn taken_bounds(cluster: &Cluster, radius: f32, usual: f32) -> Bounds {
    let margin = MARGIN_POOL * usual + MARGIN_OWN * radius;
    Bounds { middle: cluster.middle, sides: cluster.sides.map(|side| side + margin) }
}

/// Twin: rank_of.
fn rank_of(choice: &Choice, origin: V3, forward: V3, cluster: &Cluster) -> u32 {
    let offset = minus(cluster.middle, origin);
    let (square, before) = (dot(offset, offset), dot(forward, offset));
    let lean = dot(forward, cluster.normal);
    let support = lean.abs() * cluster.thick + cluster.reach * (1.0 - lean * lean).max(0.0).sqrt();
    let sum = |v: V3| v[0].abs() + v[1].abs() + v[2].abs();
    let far = SLANT * (sum(offset) - 1.75 * cluster.reach).max(0.0);
    if !(square < 3e38 && before + 1.001 * support > 0.99 * far) {
        return 0;
    }
    let distance = square.sqrt();
    let slide = choice.culling.slide;
    let (along, wide) = if slide { (forward, 1.0) } else { (offset, distance + cluster.reach) };
    let thick = if slide { 0.0 } else { cluster.thick };
    let away = dot(cluster.normal, along);
    let away = if choice.culling.far { -away } else { away };
    let most = away + thick + 1.001 * cluster.spread * wide + 1e-5 * wide + ROUNDING * sum(origin);
    let seen = most > 0.0;
    if choice.culling.on && cluster.closed && !seen {
        return 0;
    }
    let straight = dot(cluster.normal, offset).abs() / distance.max(1e-30);
    let facing = (straight.max(LEAST_FACING) + cluster.spread).min(1.0);
    let ahead = (distance + before.max(0.0)).max(cluster.reach.max(1e-18));
    let texel = ahead * (2.0 / choice.size as f32);
    let texels = choice.area * (CLUSTER as f32 / (16.0 * choice.points as f32)) / texel / texel * facing;
    let from_eye = minus(cluster.middle, choice.eye);
    let behind = dot(from_eye, from_eye) / (choice.near * choice.near);
    let worth = texels * (1.0 / behind.max(1.0)).max(LEAST_NEAR);
    (worth.to_bits() >> RANK_SHIFT).clamp(LOWEST_RANK + 1, LOWEST_RANK + RANKS - 1) - LOWEST_RANK
}

/// Twin: count_of.
fn count_of(rank: u32, rate: u32) -> u32 {
    let of = |bits: u32| f32::from_bits(bits << RANK_SHIFT);
    let count = (of(rank + LOWEST_RANK) * of(rate + LOWEST_RATE)).min(64.0) as u32;
    if rank == 0 { 0 } else { count.clamp(1, CLUSTER as u32) }
}

/// Returns the points that a light uses. Each code combines the point's index in the pool with how many times its cluster's area was
/// halved.
pub fn taken(choice: &Choice, light: u32, origin: V3, forward: V3, clusters: &[Cluster]) -> Vec<u32> {
    let ranks: Vec<_> = clusters.iter().map(|cluster| rank_of(choice, origin, forward, cluster)).collect();
    let at = |rank: u32, rate: u32, more: u32| count_of(rank, rate + u32::from(rank >= more));
    let total = |rate, more| ranks.iter().map(|rank| at(*rank, rate, more)).sum::<u32>();
    let rate = (0..RATES).rev().find(|rate| total(*rate, RANKS) <= choice.points).unwrap_or(0);
    let more = if rate + 1 < RATES { (1..RANKS).find(|more| total(rate, *more) <= choice.points) } else { None };
    let mut all = Vec::new();
    for (cluster, rank) in (0..).zip(&ranks) {
        let count = at(*rank, rate, more.unwrap_or(RANKS));
        for j in 0..count {
            let k = count.ilog2();
            let halved = k + u32::from(j >= 1 << k || j < count - (1 << k));
            let place = (j.reverse_bits() >> 26) ^ (hash(hash(light).wrapping_add(cluster)) % CLUSTER as u32);
            all.push((cluster * CLUSTER as u32 + place) | halved << TAKEN_BITS);
        }
    }
    all
}
