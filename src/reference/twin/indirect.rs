//! CPU twin of glsl/lights/indirect: virtual lights chosen from reflective shadow maps. Units of flux and the chosen texels equal the
//! device's exactly; patches and lights are computed in f64 along the same rays.

use crate::scene::{Light, LightKind, Projection, View};
use glam::{DVec2, DVec3};

/// Twin: LEAST_EXPONENT in glsl/lights/indirect/units.glsl.
const LEAST_EXPONENT: u32 = 27;

/// Twin: LIFT in glsl/lights/indirect/lights.comp.
const LIFT: f64 = 1e-5;

/// Twins: LEAST_COSINE in glsl/lights/indirect/patch.glsl and view_points.comp.
const LEAST_COSINE: f64 = 0.1;

/// Twin: BY_FLUX in glsl/lights/indirect/weigh.comp.
const BY_FLUX: f64 = 0.25;

/// Returns a texel's map and its position in that map. Twin: glsl/lights/indirect/texels.glsl.
pub fn place(texel: u32, side_bits: u32) -> (usize, [u32; 2]) {
    let within = (1 << side_bits) - 1;
    ((texel >> (2 * side_bits)) as usize, [texel & within, texel >> side_bits & within])
}

/// Returns the flux of one unit, given the largest flux of any texel.
pub fn unit(greatest: f32) -> f32 {
    f32::from_bits(((greatest.to_bits() >> 23).max(LEAST_EXPONENT) - 22) << 23)
}

/// Converts flux to an integer number of units.
pub fn units(flux: f32, greatest: f32) -> u32 {
    let per_unit = f32::from_bits((276 - (greatest.to_bits() >> 23).max(LEAST_EXPONENT)) << 23);
    (flux * per_unit + 0.5) as u32
}

fn greatest(fluxes: &[f32]) -> f32 {
    fluxes.iter().fold(0.0, |most: f32, flux| most.max(*flux))
}

/// Returns the units of flux in each row of texels. Twin: glsl/lights/indirect/sums.comp.
pub fn sums(fluxes: &[f32], side_bits: u32) -> Vec<u32> {
    let most = greatest(fluxes);
    fluxes.chunks(1 << side_bits).map(|row| row.iter().map(|flux| units(*flux, most)).sum()).collect()
}

/// Returns the units of flux before each row, and in total. Twin: glsl/lights/indirect/scan.comp.
pub fn scan(sums: &[u32]) -> Vec<u64> {
    let mut starts = vec![0];
    let mut all = 0;
    for sum in sums {
        all += u64::from(*sum);
        starts.push(all);
    }
    starts
}

/// Returns the index of the element of `of` that contains unit number `unit`. Each element has as many units as its value, and its units
/// follow those of the previous element.
fn find(mut unit: u64, of: impl IntoIterator<Item = u64>) -> usize {
    let behind = |here: &u64| {
        let is_behind = unit >= *here;
        unit = unit.wrapping_sub(if is_behind { *here } else { 0 });
        is_behind
    };
    of.into_iter().take_while(behind).count()
}

/// Chooses the texels of `count` virtual lights; each is `None` if there is no flux. Twin: glsl/lights/indirect/draw.comp.
pub fn draw(fluxes: &[f32], side_bits: u32, count: u32) -> Vec<Option<u32>> {
    let (most, side) = (greatest(fluxes), 1usize << side_bits);
    let rows = sums(fluxes, side_bits);
    let maps: Vec<u64> = rows.chunks(side).map(|map| map.iter().copied().map(u64::from).sum()).collect();
    let all: u64 = maps.iter().sum();
    let part = |of: u64, light: u32, step: u32| (of * u64::from(light.wrapping_mul(step) >> 16)) >> 16;
    let pick = |light: u32| {
        let unit = (u128::from(2 * light + 1) * u128::from(all) / u128::from(2 * count)) as u64;
        let map = find(unit, maps.iter().copied());
        let unit = part(maps[map], light, 2_447_445_413);
        let row = map * side + find(unit, rows[map * side..].iter().copied().map(u64::from));
        let unit = part(rows[row].into(), light, 3_242_174_889);
        let texels = fluxes[row * side..].iter().map(|flux| u64::from(units(*flux, most)));
        (row * side + find(unit, texels)) as u32
    };
    (0..count).map(|light| (all > 0).then(|| pick(light))).collect()
}

/// A triangle of a mesh.
pub struct Facet {
    /// Corners in world units.
    pub corners: [DVec3; 3],
    /// Diffuse reflectance.
    pub albedo: DVec3,
    /// [`Side::sign`](crate::scene::Side::sign).
    pub side: i32,
}

/// The patch of a surface that a light sees through a texel. Twin: Patch in glsl/lights/indirect/patch.glsl.
pub struct Patch {
    /// Position in world units.
    pub position: DVec3,
    /// Unit normal, on the side from which the light arrives.
    pub normal: DVec3,
    /// Radiance leaving the patch, times its area, over π.
    pub flux: DVec3,
    /// Cross-section of the light's rays that hit the patch, over π.
    pub crossed: f64,
    /// Cosine of the angle between the patch's normal and the light's rays.
    pub cosine: f64,
}

/// Returns the patch of a facet seen through a texel of `view`, the view of the light's face number `face`. `None` if the position belongs
/// to another face, or if the light sees the inside of a closed surface. Twin: patch_of.
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
    if facet.side != 0 && (cosine <= 0.0) == (facet.side > 0) {
        return None;
    }
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

/// Returns the area of the surface seen through a texel, over π. Twin: patch_area.
fn area(patch: &Patch) -> f64 {
    patch.crossed / patch.cosine.max(LEAST_COSINE)
}

/// Returns the luminance by which patches are chosen: Rec. 709.
pub fn luminance(color: DVec3) -> f64 {
    color.dot(DVec3::new(0.2126, 0.7152, 0.0722))
}

/// A point that the camera sees. Twin: ViewPoint in glsl/lights/indirect/view.glsl.
pub struct ViewPoint {
    /// Position in world units.
    pub position: DVec3,
    /// Area of the surface that the point represents, over π.
    pub area: f64,
    /// Unit normal, on the outside of closed meshes.
    pub normal: DVec3,
    /// Luminance of the albedo.
    pub weight: f64,
    /// Whether the surface is lit from either side.
    pub is_open: bool,
}

/// Returns the point of a facet that the camera sees through pixel `at` of a picture of `across` × `across` pixels. Twin:
/// glsl/lights/indirect/view_points.comp.
pub fn view_point(camera: &View, across: u32, facet: &Facet, at: [u32; 2]) -> ViewPoint {
    let camera = View { width: across, height: across, ..*camera };
    let ray = camera.ray(DVec2::from(at.map(f64::from)) + 0.5);
    let [a, b, c] = facet.corners;
    let outside = if facet.side < 0 { -1.0 } else { 1.0 };
    let normal = outside * (b - a).cross(c - a).normalize_or_zero();
    let z_all = facet.corners.map(|corner| camera.axes(corner).z);
    let (nearest, farthest) = (z_all[0].min(z_all[1]).min(z_all[2]), z_all[0].max(z_all[1]).max(z_all[2]));
    let z = (a - ray.origin).dot(normal) / ray.direction.dot(normal);
    let z = if z >= nearest { z.min(farthest) } else { nearest };
    let slant = ray.direction.length();
    let cosine = (ray.direction.dot(normal).abs() / slant).max(LEAST_COSINE);
    let scale = f64::from(camera.scale_x) * f64::from(camera.scale_y);
    let crossed = 4.0 * z * z / (camera.texels() as f64 * scale.abs() * slant * std::f64::consts::PI);
    ViewPoint {
        position: ray.at(z),
        area: crossed / cosine,
        normal,
        weight: luminance(facet.albedo),
        is_open: facet.side == 0,
    }
}

/// Returns the light that a patch of flux 1 sends to all points, ignoring occlusion. Twin: light_to in glsl/lights/indirect/view.glsl.
pub fn importance(patch: &Patch, points: &[ViewPoint]) -> f64 {
    let area = area(patch);
    let light_to = |point: &ViewPoint| {
        let offset = point.position - patch.position;
        let squared = offset.length_squared();
        let (sent, met) = (offset.dot(patch.normal).max(0.0), -offset.dot(point.normal));
        let met = if point.is_open { met.abs() } else { met.max(0.0) };
        if squared > 0.0 { point.weight * sent * met / (squared * (squared + point.area + area)) } else { 0.0 }
    };
    points.iter().map(light_to).sum()
}

/// Returns the weight with which a texel of this flux and importance is drawn, if `mean` is the flux-weighted mean importance. Twin:
/// glsl/lights/indirect/weigh.comp.
pub fn weight(flux: f64, importance: f64, mean: f64) -> f64 {
    flux * (BY_FLUX + (1.0 - BY_FLUX) * if mean > 0.0 { importance / mean } else { 1.0 })
}

/// Returns the virtual light that represents a patch drawn with weight `own`; each light represents a weight of `share`. The view of the
/// light that lit the patch starts at `origin`. Twin: glsl/lights/indirect/lights.comp.
pub fn light(patch: &Patch, origin: DVec3, own: f64, share: f64) -> Light {
    let nearest = (area(patch) * (share / own).max(1.0)).sqrt();
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

    /// The largest flux converts to 2²² to 2²³ units, half of it to half as many, and a flux of 0 to no units.
    #[test]
    fn flux_in_units() {
        for greatest in [1e-20f32, 1.0, 1.999, 2.0, 3.7e5, 1e30] {
            let most = units(greatest, greatest);
            assert!((1 << 22..=1 << 23).contains(&most), "{greatest}: {most}");
            assert!(units(greatest / 2.0, greatest).abs_diff(most / 2) <= 1 && units(0.0, greatest) == 0);
            assert!((unit(greatest) * most as f32 / greatest - 1.0).abs() < 1e-6);
        }
    }

    /// Two maps of equal flux get half of the virtual lights each, and each row of a map gets about its share. A texel with all the flux
    /// gets all virtual lights. Without flux there are none.
    #[test]
    fn lights_are_drawn_by_flux() {
        let picks = draw(&[1.5; 512], 4, 128);
        let maps: Vec<usize> = picks.iter().map(|pick| place(pick.expect("flux"), 4).0).collect();
        assert!(maps[..64] == [0; 64] && maps[64..] == [1; 64]);
        for row in 0..16 {
            let of_row = picks.iter().filter(|pick| place(pick.expect("flux"), 4).1[1] == row).count();
            assert!((4..=12).contains(&of_row), "{of_row} of 128 in one of 16");
        }
        let mut one = [0.0; 1024];
        one[777] = 1e-3;
        assert_eq!(draw(&one, 4, 64), [Some(777); 64]);
        assert_eq!(draw(&[0.0; 256], 4, 64), [None; 64]);
        assert_eq!(scan(&[u32::MAX, 1, 5]), [0, (1 << 32) - 1, 1 << 32, (1 << 32) + 5]);
    }
}
