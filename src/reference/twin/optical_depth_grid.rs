//! Optical depths to a light from the cells of a grid. Twin of glsl/technique/optical_depth_grid/.

use super::grid::Place;
use super::media::{DARK, Media};
use super::soft::way;
use crate::scene::Light;
use std::array::from_fn;

/// The optical depths of one light.
pub struct OpticalDepths {
    /// Position of the density grid.
    pub place: Place,
    /// Number of cells per side.
    pub cells: u32,
    /// Optical depth from each cell's centre to the light, x fastest, then y, then z.
    pub depths: Vec<f32>,
}

impl OpticalDepths {
    /// Marches from each cell's centre to the light, each ray in `parts` parts. Twin: bake.comp.
    pub fn bake(media: &Media, place: &Place, light: &Light, cells: u32, parts: u32) -> Self {
        let side = place.voxel * (place.size as f32 / cells as f32);
        let of = |i: u32| {
            let cell = [i % cells, i / cells % cells, i / (cells * cells)];
            let (from, way) = way(place, light, from_fn(|a| place.origin[a] + (cell[a] as f32 + 0.5) * side));
            let Some([near, far]) = media.bits.clipped(from, way).filter(|_| parts > 1) else {
                return media.march_exact(from, way);
            };
            let taken = |part: u32| {
                let [begin, end] = [part, part + 1].map(|i| near + (far - near) * (i as f32 / parts as f32));
                media.march_exact(from_fn(|a| from[a] + begin * way[a]), way.map(|w| (end - begin) * w))
            };
            (0..parts).map(taken).sum::<f32>().min(DARK)
        };
        Self { place: *place, cells, depths: (0..cells.pow(3)).map(of).collect() }
    }

    /// Returns the transmittance from the light to `position`. Twin: light_visibility in visibility.glsl.
    pub fn visibility(&self, media: &Media, light: &Light, position: [f32; 3]) -> f32 {
        let (from, way) = way(&self.place, light, position);
        let Some([near, _]) = media.bits.clipped(from, way) else { return 1.0 };
        let scale = self.cells as f32 / self.place.size as f32;
        let at: [f32; 3] = from_fn(|i| ((from[i] + way[i] * near) * scale - 0.5).clamp(0.0, (self.cells - 1) as f32));
        let corner = at.map(|a| (a as u32).min(self.cells - 2));
        let corners = (0..8u32).map(|c| {
            let high: [u32; 3] = from_fn(|i| c >> i & 1);
            let share = |i: usize| at[i] - corner[i] as f32;
            let weight: f32 = (0..3).map(|i| if high[i] == 1 { share(i) } else { 1.0 - share(i) }).product();
            let [x, y, z]: [u32; 3] = from_fn(|i| corner[i] + high[i]);
            weight * self.depths[((z * self.cells + y) * self.cells + x) as usize]
        });
        (-corners.sum::<f32>()).exp()
    }
}
