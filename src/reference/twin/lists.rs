//! The triangles or the casters of each voxel. Twin of glsl/grid/lists/: the same words.

use super::gaussian::strand_axis;
use super::grid::{Bits, Facet, Place};
use crate::scene::Caster;
use glam::{UVec3, Vec3};
use std::collections::BTreeMap;

/// By brick and bit; each in the order of its numbers.
type Used = BTreeMap<(usize, u32), Vec<u32>>;

/// Twin: CAST_SLACK.
const CAST_SLACK: f32 = 1.0 / 512.0;

/// The bits of all levels, and the lists, of triangles whose corners are in voxels.
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
                    used.entry(bits.place(0, [x, y, z])).or_default().push(triangle);
                }
            }
        }
    }
    let words = words(&bits, used, size);
    (bits, words)
}

/// The words of glsl/grid/lists/place.glsl.
fn words(bits: &Bits, used: Used, size: u32) -> Vec<u32> {
    let bricks = (size / 4).pow(3);
    let mut words: Vec<u32> = Vec::new();
    let mut before = 0;
    for brick in 0..bricks as usize {
        words.push(bricks + before);
        before += bits.words[brick].count_ones();
    }
    let mut start = bricks + before + 1;
    words.push(start);
    for list in used.values() {
        start += list.len() as u32;
        words.push(start);
    }
    words.extend(used.into_values().flatten());
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

    /// The voxels of its box, first and last.
    fn bounds(&self, size: u32) -> [UVec3; 2] {
        let end = self.place + self.axis;
        let most = Vec3::splat((size - 1) as f32);
        let of = |corner: Vec3| corner.floor().clamp(Vec3::ZERO, most).as_uvec3();
        [of(self.place.min(end) - self.reach), of(self.place.max(end) + self.reach)]
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

/// The bits of all levels, and the lists, of casters in a grid that stands there. Twin: casters.comp, and what follows it.
pub fn caster_lists(casters: &[Caster], place: &Place) -> (Bits, Vec<u32>) {
    let (size, mut bits, mut used) = (place.size, Bits::none(place.size), Used::new());
    for (number, caster) in (0..).zip(casters).filter(|(_, caster)| caster.radius > 0.0) {
        let cast = Cast::new(caster, place);
        let [first, last] = cast.bounds(size);
        for z in first.z..=last.z {
            for y in first.y..=last.y {
                for x in (first.x..=last.x).filter(|x| cast.meets(UVec3::new(*x, y, z))) {
                    let voxel = [x, y, z];
                    (0..3).for_each(|level| bits.set(level, voxel));
                    used.entry(bits.place(0, voxel)).or_default().push(number);
                }
            }
        }
    }
    let words = words(&bits, used, size);
    (bits, words)
}
