//! CPU twin of glsl/indirect: virtual lights, drawn from reflective shadow maps. Units of flux and what is drawn by them are the same
//! numbers as on the device; patches and lights are in f64, from the same rays.

use crate::scene::{Light, LightKind, Projection, View};
use glam::{DVec2, DVec3};

/// Texels of a block. Twin: BLOCK in glsl/indirect/units.glsl.
pub const BLOCK: usize = 256;

/// Twin: LEAST_EXPONENT.
const LEAST_EXPONENT: u32 = 27;

/// Twin: LIFT in glsl/indirect/lights.comp.
const LIFT: f64 = 1e-5;

/// Twin: LEAST_COSINE.
const LEAST_COSINE: f64 = 0.1;

/// The map and the place in it of a texel along Morton's curve. Twin: glsl/indirect/texels.glsl.
pub fn place(texel: u32, side_bits: u32) -> (usize, [u32; 2]) {
    let axis = |first: u32| (0..side_bits).map(|bit| (texel >> (2 * bit + first) & 1) << bit).sum();
    ((texel >> (2 * side_bits)) as usize, [axis(0), axis(1)])
}

/// What a unit of flux is, where `greatest` is the greatest flux.
pub fn unit(greatest: f32) -> f32 {
    f32::from_bits(((greatest.to_bits() >> 23).max(LEAST_EXPONENT) - 22) << 23)
}

/// Flux in whole numbers.
pub fn units(flux: f32, greatest: f32) -> u32 {
    let per_unit = f32::from_bits((276 - (greatest.to_bits() >> 23).max(LEAST_EXPONENT)) << 23);
    (flux * per_unit + 0.5) as u32
}

fn greatest(fluxes: &[f32]) -> f32 {
    fluxes.iter().fold(0.0, |most: f32, flux| most.max(*flux))
}

/// Units of each block. Twin: glsl/indirect/sums.comp.
pub fn sums(fluxes: &[f32]) -> Vec<u32> {
    let most = greatest(fluxes);
    fluxes.chunks(BLOCK).map(|block| block.iter().map(|flux| units(*flux, most)).sum()).collect()
}

/// Units before each block, and of all. Twin: glsl/indirect/scan.comp.
pub fn scan(sums: &[u32]) -> Vec<u64> {
    let mut starts = vec![0];
    let mut all = 0;
    for sum in sums {
        all += u64::from(*sum);
        starts.push(all);
    }
    starts
}

/// The texels of `count` lights; none where there is no flux. Twin: glsl/indirect/draw.comp.
pub fn draw(fluxes: &[f32], count: u32) -> Vec<Option<u32>> {
    let most = greatest(fluxes);
    let mut ends = Vec::new();
    let mut all = 0u64;
    for flux in fluxes {
        all += u64::from(units(*flux, most));
        ends.push(all);
    }
    let pick = |light: u32| {
        let place = u128::from(light) << 16 | u128::from(light.wrapping_mul(40503) & 0xffff);
        let unit = (place * u128::from(all) / (u128::from(count) << 16)) as u64;
        // The first texel that ends behind it.
        (all > 0).then(|| ends.partition_point(|end| *end <= unit) as u32)
    };
    (0..count).map(pick).collect()
}

/// A triangle of a mesh.
pub struct Facet {
    /// World units.
    pub corners: [DVec3; 3],
    /// Diffuse reflectance.
    pub albedo: DVec3,
}

/// What a light sees of a surface through a texel. Twin: Patch in glsl/indirect/patch.glsl.
pub struct Patch {
    /// World units.
    pub position: DVec3,
    /// Unit length, on the side that the light comes from.
    pub normal: DVec3,
    /// The radiance that leaves it, times its area, over π.
    pub flux: DVec3,
    /// The area of the light's rays that meet it, over π.
    pub crossed: f64,
    /// Between it and the light's rays.
    pub cosine: f64,
}

/// The patch of a facet that a texel of `view` shows; the view is that of face number `face` of the light. None where another face
/// is asked for what lies there. Twin: patch_of.
pub fn patch(view: &View, light: &Light, face: usize, facet: &Facet, at: [u32; 2]) -> Option<Patch> {
    let ray = view.ray(DVec2::from(at.map(f64::from)) + 0.5);
    let [a, b, c] = facet.corners;
    let normal = (b - a).cross(c - a).normalize_or_zero();
    let z_all = facet.corners.map(|corner| view.axes(corner).z);
    let (nearest, farthest) = (z_all[0].min(z_all[1]).min(z_all[2]), z_all[0].max(z_all[1]).max(z_all[2]));
    let z = (a - ray.origin).dot(normal) / ray.direction.dot(normal);
    let z = if z >= nearest { z.min(farthest) } else { nearest };
    let position = ray.at(z);
    if light.map_at(position.as_vec3().into()) != face {
        return None;
    }
    let cosine = normal.dot(light.towards(position));
    let across = 4.0 / (f64::from(view.scale_x) * f64::from(view.scale_y) * view.texels() as f64);
    let spread = match view.projection() {
        Projection::Parallel => 1.0,
        Projection::Perspective => z * z / ray.direction.length(),
    };
    let crossed = across * spread / std::f64::consts::PI;
    let arriving = if light.shines_on(position) { light.falloff(position) } else { 0.0 };
    let radiance = DVec3::from(light.radiance.map(f64::from)) * arriving;
    let normal = if cosine < 0.0 { -normal } else { normal };
    Some(Patch { position, normal, flux: facet.albedo * radiance * crossed, crossed, cosine: cosine.abs() })
}

/// By which patches are drawn: Rec. 709.
pub fn luminance(color: DVec3) -> f64 {
    color.dot(DVec3::new(0.2126, 0.7152, 0.0722))
}

/// The virtual light of a patch that stands for `share` of all flux, seen by a light whose view begins at `origin`. Twin:
/// glsl/indirect/lights.comp.
pub fn light(patch: &Patch, origin: DVec3, share: f64) -> Light {
    let own = luminance(patch.flux);
    let nearest = (patch.crossed / patch.cosine.max(LEAST_COSINE) * (share / own).max(1.0)).sqrt();
    let lift = LIFT * (patch.position.abs().max_element() + patch.position.distance(origin));
    let position = patch.position + lift * patch.normal;
    Light {
        kind: LightKind::Virtual { position, normal: patch.normal, nearest },
        radiance: (patch.flux * (share / own)).as_vec3().into(),
        radius: f64::INFINITY,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Each texel once, and neighbours of the row are neighbours in the map but at a square's end.
    #[test]
    fn the_curve_visits_each_texel_once() {
        let mut seen = std::collections::BTreeSet::new();
        for texel in 0..3 << 8 {
            let (map, [x, y]) = place(texel, 4);
            assert!(x < 16 && y < 16 && map == (texel >> 8) as usize && seen.insert((map, x, y)));
            let (_, [left, up]) = place(texel & !3, 4);
            assert!(x - left <= 1 && y - up <= 1, "four in a row are a square");
        }
    }

    /// The greatest has 22 bits at least and 23 at most, a half is half as many, and nothing is none.
    #[test]
    fn flux_in_units() {
        for greatest in [1e-20f32, 1.0, 1.999, 2.0, 3.7e5, 1e30] {
            let most = units(greatest, greatest);
            assert!((1 << 22..=1 << 23).contains(&most), "{greatest}: {most}");
            assert!(units(greatest / 2.0, greatest).abs_diff(most / 2) <= 1 && units(0.0, greatest) == 0);
            assert!((unit(greatest) * most as f32 / greatest - 1.0).abs() < 1e-6);
        }
    }

    /// Equal fluxes have equally many lights each, one of all flux has all, and none has none.
    #[test]
    fn lights_are_drawn_by_flux() {
        let picks = draw(&[1.5; 512], 128);
        assert!(picks.iter().zip(0..).all(|(pick, i)| pick.is_some_and(|texel| texel / 4 == i)), "{picks:?}");
        let mut one = [0.0; 1024];
        one[777] = 1e-3;
        assert_eq!(draw(&one, 64), [Some(777); 64]);
        assert_eq!(draw(&[0.0; 256], 64), [None; 64]);
        assert_eq!(scan(&[u32::MAX, 1, 5]), [0, (1 << 32) - 1, 1 << 32, (1 << 32) + 5]);
    }
}
