//! Casters sorted into cells over a view, to find the candidates for a ray.

use super::splat::TRUE_REACH;
use crate::scene::{Caster, Projection, REACH, View};
use glam::{DVec2, DVec3};
use std::ops::Range;

/// Lists of casters, one per cell; a cell is a texel of the view for which the grid was built.
pub(super) struct Grid {
    width: u32,
    height: u32,
    /// Caster indices of cell i: `members[starts[i]..starts[i + 1]]`, in the order they were given.
    starts: Vec<u32>,
    members: Vec<u32>,
}

impl Grid {
    /// Sorts the casters named by `order` into the texels of `view`.
    pub fn new(view: &View, casters: &[Caster], order: &[u32]) -> Self {
        let ranges: Vec<_> = order.iter().map(|&i| (i, cells(view, &casters[i as usize]))).collect();
        let width = view.width as usize;
        let each = |visit: &mut dyn FnMut(usize, u32)| {
            for (index, [x, y]) in &ranges {
                for row in y.clone() {
                    for column in x.clone() {
                        visit(row * width + column, *index);
                    }
                }
            }
        };
        let mut starts = vec![0u32; view.texels() + 1];
        each(&mut |cell, _| starts[cell + 1] += 1);
        for i in 0..view.texels() {
            starts[i + 1] += starts[i];
        }
        let mut next = starts.clone();
        let mut members = vec![0u32; starts[view.texels()] as usize];
        each(&mut |cell, index| {
            members[next[cell] as usize] = index;
            next[cell] += 1;
        });
        Self { width: view.width, height: view.height, starts, members }
    }

    /// Returns the number of entries that a grid over `view` would have in all cells together.
    pub fn members(view: &View, casters: &[Caster]) -> usize {
        casters.iter().map(|caster| cells(view, caster).iter().map(Range::len).product::<usize>()).sum()
    }

    /// Returns the candidates in the cell at `texel`, or none outside the grid.
    pub fn at(&self, texel: DVec2) -> &[u32] {
        let size = DVec2::new(self.width.into(), self.height.into());
        if !(texel.cmpge(DVec2::ZERO).all() && texel.cmplt(size).all()) {
            return &[];
        }
        let cell = texel.y as usize * self.width as usize + texel.x as usize;
        &self.members[self.starts[cell] as usize..self.starts[cell + 1] as usize]
    }
}

/// Returns the columns and rows of cells that a caster may touch, with one more on each side as a margin for rounding.
fn cells(view: &View, caster: &Caster) -> [Range<usize>; 2] {
    let ends = [caster.start(), caster.end()];
    let more = if caster.is_splat() { TRUE_REACH / REACH } else { 1.0 };
    let radius = f64::from(caster.radius) * more;
    let dot = |end: DVec3, axis: [f32; 3]| (end - DVec3::from(view.origin.map(f64::from))).dot(axis_of(axis));
    let perspective = view.projection() == Projection::Perspective;
    if perspective && ends.iter().all(|end| dot(*end, view.forward) + radius <= 0.0) {
        return [0..0, 0..0];
    }
    let range = |axis: [f32; 3], scale: f32, count: u32| {
        let cell = |t: f64| (t * f64::from(scale) * 0.5 + 0.5) * f64::from(count);
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for end in ends {
            let (across, z) = (dot(end, axis), dot(end, view.forward));
            let (a, b) = match view.projection() {
                Projection::Parallel => (across - radius, across + radius),
                Projection::Perspective if z <= radius => (f64::NEG_INFINITY, f64::INFINITY),
                Projection::Perspective => {
                    // In this plane the sphere is a circle whose edges are seen at these two angles.
                    let angle = across.atan2(z);
                    let half = (radius / across.hypot(z)).asin();
                    ((angle - half).tan(), (angle + half).tan())
                }
            };
            low = low.min(cell(a)).min(cell(b));
            high = high.max(cell(a)).max(cell(b));
        }
        let low = (low.floor() - 1.0).clamp(0.0, count.into()) as usize;
        let high = (high.floor() + 2.0).clamp(0.0, count.into()) as usize;
        low..high
    };
    [range(view.right, view.scale_x, view.width), range(view.up, view.scale_y, view.height)]
}

fn axis_of(axis: [f32; 3]) -> DVec3 {
    DVec3::from(axis.map(f64::from))
}
