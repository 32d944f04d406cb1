//! The triangles or casters of each voxel. Twin of glsl/grid/lists/, with identical words.

use super::grid::{Bits, Facet, Place};
use super::splat::strand_axis;
use crate::scene::Caster;
use glam::{UVec3, Vec3};
use std::collections::BTreeMap;

/// The list of each occupied voxel, keyed by the voxel's brick and its bit in the brick. Each entry is a box and the index of a triangle or
/// caster; entries are in increasing order of these indices.
type Used = BTreeMap<(usize, u32), Vec<[u32; 2]>>;

/// The highest bit of each lane; with no other bits set, the box is empty. Twin: BOX_GUARDS in glsl/grid/lists/box.glsl.
const BOX_GUARDS: u32 = 0x2108_4210;

/// Twin: CAST_SLACK.
const CAST_SLACK: f32 = 1.0 / 512.0;

/// Returns the part of a box (in voxels) that lies inside a voxel, packed into six lanes of five bits with the highest bit of each lane
/// set. Twin: box_in in glsl/grid/lists/box.glsl.
fn box_in([low, high]: [[f32; 3]; 2], voxel: [u32; 3]) -> u32 {
    let place = |at: f32, i: usize| ((at - voxel[i] as f32) * 16.0).clamp(0.0, 15.0) as u32;
    (0..3).map(|i| (16 + place(high[i], i)) << (5 * i) | (31 - place(low[i], i)) << (15 + 5 * i)).sum()
}

/// Returns the smallest box that contains both boxes. Twin: box_about.
fn box_about(a: u32, b: u32) -> u32 {
    let lane = |of: u32, i: u32| of >> (5 * i) & 31;
    (0..6).map(|i| lane(a, i).max(lane(b, i)) << (5 * i)).sum()
}

/// Returns the occupied bits of all levels, and the lists, for triangles whose corners are given in voxels.
pub fn lists(triangles: impl Iterator<Item = [[f32; 3]; 3]>, size: u32) -> (Bits, Vec<u32>) {
    let mut bits = Bits::none(size);
    let mut used = Used::new();
    for (triangle, corners) in (0..).zip(triangles) {
        let facet = Facet::listed(corners, size);
        if facet.is_point() {
            continue;
        }
        for z in facet.first[2]..=facet.last[2] {
            for y in facet.first[1]..=facet.last[1] {
                for x in (facet.first[0]..=facet.last[0]).filter(|x| facet.meets([*x, y, z])) {
                    (0..3).for_each(|level| bits.set(level, [x, y, z]));
                    let listed = [box_in(facet.bounds(), [x, y, z]), triangle];
                    used.entry(bits.place(0, [x, y, z])).or_default().push(listed);
                }
            }
        }
    }
    let words = words(&bits, used, size);
    (bits, words)
}

/// Returns the brick and bit of the list shared by all voxels. Twin: lists_of_all.
fn of_all(size: u32) -> (usize, u32) {
    ((size / 4).pow(3) as usize, 0)
}

/// Returns all lists as words, in the layout of glsl/grid/lists/place.glsl.
fn words(bits: &Bits, mut used: Used, size: u32) -> Vec<u32> {
    let all = of_all(size);
    used.entry(all).or_default();
    let bricks = all.0 as u32 + 1;
    let mut words: Vec<u32> = Vec::new();
    let mut before = 0;
    for brick in 0..=all.0 {
        words.push(bricks + 2 * before);
        before += if brick == all.0 { 1 } else { bits.words[brick].count_ones() };
    }
    let mut start = bricks + 2 * before + 1;
    for list in used.values() {
        words.extend([start, list.iter().map(|[listed, _]| *listed).reduce(box_about).unwrap_or_default()]);
        start += 2 * list.len() as u32;
    }
    words.push(start);
    words.extend(used.into_values().flatten().flatten());
    words
}

/// A caster in voxels. Twin: Cast.
struct Cast {
    place: Vec3,
    axis: Vec3,
    reach: f32,
}

impl Cast {
    /// Twin: cast_of.
    fn new(caster: &Caster, place: &Place) -> Self {
        let axis = strand_axis(caster) * place.per_unit;
        let reach = caster.radius * place.per_unit + CAST_SLACK;
        Self { place: place.voxels(caster.position).into(), axis, reach }
    }

    /// Returns the low and high corners of the caster's box, in voxels.
    fn bounds(&self) -> [Vec3; 2] {
        let end = self.place + self.axis;
        [self.place.min(end) - self.reach, self.place.max(end) + self.reach]
    }

    /// Twin: cast_meets.
    fn meets(&self, voxel: UVec3) -> bool {
        let middle = self.place - (voxel.as_vec3() + 0.5);
        if self.axis == Vec3::ZERO {
            let apart = (middle.abs() - 0.5).max(Vec3::ZERO);
            let square = apart.x * apart.x + apart.y * apart.y + apart.z * apart.z;
            return square <= self.reach * self.reach;
        }
        let along = 0.5 * self.axis;
        let (from, half, length) = (middle + along, 0.5 + self.reach, along.abs());
        if from.abs().cmpgt(length + half).any() {
            return false;
        }
        let turned = |v: Vec3| (Vec3::new(v.y, v.z, v.x), Vec3::new(v.z, v.x, v.y));
        let ((from_on, from_back), (along_on, along_back)) = (turned(from), turned(along));
        let across = (from_on * along_back - from_back * along_on).abs();
        let (on, back) = turned(length);
        let most = half * (back + on) + CAST_SLACK * (length.x + length.y + length.z);
        across.cmple(most).all()
    }
}

/// Returns the occupied bits of all levels, and the lists, for casters in the grid `place`. Casters whose boxes span more than `share`
/// voxels go into the list shared by all voxels. Twin: casters.comp and the passes after it.
pub fn caster_lists(casters: &[Caster], place: &Place, share: u32) -> (Bits, Vec<u32>) {
    let (size, mut bits, mut used) = (place.size, Bits::none(place.size), Used::new());
    for (number, caster) in (0..).zip(casters).filter(|(_, caster)| caster.radius > 0.0) {
        let cast = Cast::new(caster, place);
        let bounds = cast.bounds();
        let most = Vec3::splat((size - 1) as f32);
        let [first, last] = bounds.map(|corner| corner.floor().clamp(Vec3::ZERO, most).as_uvec3());
        if (last - first + 1).element_product() > share {
            used.entry(of_all(size)).or_default().push([BOX_GUARDS, number]);
            continue;
        }
        for z in first.z..=last.z {
            for y in first.y..=last.y {
                for x in (first.x..=last.x).filter(|x| cast.meets(UVec3::new(*x, y, z))) {
                    let voxel = [x, y, z];
                    (0..3).for_each(|level| bits.set(level, voxel));
                    let listed = [box_in(bounds.map(Into::into), voxel), number];
                    used.entry(bits.place(0, voxel)).or_default().push(listed);
                }
            }
        }
    }
    let words = words(&bits, used, size);
    (bits, words)
}
