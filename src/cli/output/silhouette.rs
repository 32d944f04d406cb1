//! `gobo slice`: the casters' outlines over the visibility at one depth, and the scale and caption below it.

use crate::report::{Paper, captioned, with_scale};
use crate::scene::{Caster, Mesh, Projection, Scene, View};
use glam::{DVec2, DVec3};

/// Color of the translucent casters: orange from Okabe and Ito 2008.
const OUTLINE: [u8; 3] = [213, 94, 0];

/// Color of the meshes: blue from the same palette.
const OUTLINE_OF_MESHES: [u8; 3] = [0, 114, 178];

/// Fraction of a splat's drawn extent up to which it is visible.
const SEEN: f64 = 0.5;

/// Returns which pixels of a light's view the translucent casters cover, however thinly; rows from the top.
fn covered(scene: &Scene, view: &View) -> Vec<bool> {
    let (width, height) = (i64::from(view.width), i64::from(view.height));
    let mut covered = vec![false; view.texels()];
    let mut disc = |middle: DVec3, radius: f64| {
        let (at, z) = view.project(middle);
        if z <= 0.0 {
            return;
        }
        let reach = DVec2::from(view.texel_at(middle).map(|texel| radius / texel.length())).max(DVec2::splat(0.5));
        let [low, high] = [at - reach, at + reach].map(|corner| corner.floor());
        for y in (low.y.max(0.0) as i64)..=(high.y.min(height as f64 - 1.0) as i64) {
            for x in (low.x.max(0.0) as i64)..=(high.x.min(width as f64 - 1.0) as i64) {
                let away = (DVec2::new(x as f64, y as f64) + 0.5 - at) / reach;
                if away.length() <= 1.0 {
                    covered[(y * width + x) as usize] = true;
                }
            }
        }
    };
    let wide = |v: [f32; 3]| DVec3::from(v.map(f64::from));
    scene.particles.iter().for_each(|p| disc(wide(p.position), p.radius.into()));
    scene.splats.iter().for_each(|g| disc(wide(g.position), SEEN * f64::from(Caster::from(g).radius)));
    for strand in &scene.strands {
        let (start, end) = (wide(strand.start), wide(strand.end));
        // At least one point per pixel from end to end, so that no pixel in between is left out.
        let [first, last] = [start, end].map(|place| view.project(place).0);
        let places = ((last - first).abs().max_element().ceil()).clamp(1.0, 4096.0);
        (0..=places as u32).for_each(|i| disc(start.lerp(end, f64::from(i) / places), strand.radius.into()));
    }
    for volume in &scene.volumes {
        let placed = volume.placed();
        for (first, _) in volume.field().cubes(1) {
            let corner = |i: usize| {
                let along = |axis: usize| placed.steps[axis] * f64::from(first[axis] + (i as i32 >> axis & 1));
                placed.origin + along(0) + along(1) + along(2)
            };
            for face in FACES_OF_A_CELL {
                triangle(view, face.map(corner), &mut covered);
            }
        }
    }
    covered
}

/// Corner indices of the triangles of a box's faces: bits 0, 1 and 2 of a corner give its end along each axis.
const FACES_OF_A_CELL: [[usize; 3]; 12] = [
    [0, 1, 3],
    [0, 3, 2],
    [4, 5, 7],
    [4, 7, 6],
    [0, 1, 5],
    [0, 5, 4],
    [2, 3, 7],
    [2, 7, 6],
    [0, 2, 6],
    [0, 6, 4],
    [1, 3, 7],
    [1, 7, 5],
];

/// Marks the pixels whose centres are inside a triangle's projection. It uses homogeneous coordinates, so that parts behind the view need
/// no clipping (Olano and Greer 1997, Triangle Scan Conversion using 2D Homogeneous Coordinates).
fn triangle(view: &View, corners: [DVec3; 3], covered: &mut [bool]) {
    let size = DVec2::new(view.width.into(), view.height.into());
    let [a, b, c] = corners.map(|corner| {
        let at = view.axes(corner);
        let w = if view.projection() == Projection::Parallel { 1.0 } else { at.z };
        let ndc = DVec2::new(at.x * f64::from(view.scale_x), at.y * f64::from(view.scale_y));
        ((ndc + w) * 0.5 * size).extend(w)
    });
    let twice_area = a.dot(b.cross(c));
    if twice_area == 0.0 {
        return;
    }
    let sides = [b.cross(c), c.cross(a), a.cross(b)].map(|side| side / twice_area);
    let [low, high] = if [a, b, c].iter().all(|corner| corner.z > 0.0) {
        let [a, b, c] = [a, b, c].map(|corner| corner.truncate() / corner.z);
        [(a.min(b).min(c) - 0.5).ceil(), (a.max(b).max(c) - 0.5).floor()]
    } else {
        [DVec2::ZERO, size]
    };
    let [low, high] = [low.max(DVec2::ZERO), high.min(size - 1.0)];
    for y in low.y as i64..=high.y as i64 {
        for x in low.x as i64..=high.x as i64 {
            let pixel = DVec3::new(x as f64 + 0.5, y as f64 + 0.5, 1.0);
            if sides.iter().all(|side| side.dot(pixel) >= 0.0) {
                covered[y as usize * view.width as usize + x as usize] = true;
            }
        }
    }
}

/// Returns which pixels of a light's view a mesh covers.
fn covered_by(mesh: &Mesh, view: &View) -> Vec<bool> {
    let mut covered = vec![false; view.texels()];
    let place = |i: u32| mesh.positions.get(i as usize).map(|p| DVec3::from(p.map(f64::from)));
    for [a, b, c] in &mesh.triangles {
        if let (Some(a), Some(b), Some(c)) = (place(*a), place(*b), place(*c)) {
            triangle(view, [a, b, c], &mut covered);
        }
    }
    covered
}

/// Paints the covered pixels that have an uncovered neighbour.
fn outline(covered: &[bool], size: u32, color: [u8; 3], rgb8: &mut [u8]) {
    // A shape that continues beyond the picture has no outline at the picture's border.
    let is_free = |x: u32, y: u32| x < size && y < size && !covered[(y * size + x) as usize];
    for (x, y) in (0..size).flat_map(|y| (0..size).map(move |x| (x, y))) {
        let beside = [(x + 1, y), (x.wrapping_sub(1), y), (x, y + 1), (x, y.wrapping_sub(1))];
        if covered[(y * size + x) as usize] && beside.iter().any(|(x, y)| is_free(*x, *y)) {
            let place = 3 * (y * size + x) as usize;
            rgb8[place..place + 3].copy_from_slice(&color);
        }
    }
}

/// Draws the casters' silhouettes over grey visibility, one for all translucent casters and one per mesh. Below it come the grey scale, the
/// depth, and lines that describe the slice.
pub(in crate::cli) fn shown(
    scene: &Scene,
    view: &View,
    depth: f32,
    size: u32,
    mut rgb8: Vec<u8>,
    caption: &[String],
) -> Paper {
    let sized = View { width: size, height: size, ..*view };
    for mesh in &scene.meshes {
        outline(&covered_by(mesh, &sized), size, OUTLINE_OF_MESHES, &mut rgb8);
    }
    outline(&covered(scene, &sized), size, OUTLINE, &mut rgb8);
    let grey = |share: f64| {
        let pixels = vec![[share as f32; 3]];
        let bytes = crate::scene::Picture { width: 1, height: 1, pixels }.to_srgb8();
        [bytes[0], bytes[1], bytes[2]]
    };
    let words = format!("visibility at depth {depth:.2}: {:.2} world units", view.z(f64::from(depth)));
    captioned(&with_scale(&rgb8, [size; 2], grey, ["0", &words, "1"]), caption)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::tests::on_the_axis;

    /// A sphere on the axis must cover a disc at the centre of the light's view, of the size that its radius implies.
    #[test]
    fn a_sphere_is_a_disc() {
        let scene = on_the_axis(&[(0.0, 1.0, 1.0)]);
        let view = View::volumes(&scene, 64)[0];
        let covered = covered(&scene, &view);
        let count = covered.iter().filter(|c| **c).count() as f64;
        let texel = view.texel_at(DVec3::ZERO)[0].length();
        let wanted = std::f64::consts::PI / (texel * texel);
        assert!((count - wanted).abs() < 0.05 * wanted, "{count} pixels, not {wanted}");
        let (middle, _) = view.project(DVec3::ZERO);
        assert!(covered[middle.y as usize * 64 + middle.x as usize] && !covered[0]);
        // Only the sphere's rim turns orange.
        let paper = shown(&scene, &view, 0.5, 64, vec![255; 3 * 64 * 64], &[]);
        let orange = paper.rgb8.chunks_exact(3).filter(|p| **p == OUTLINE).count() as f64;
        // The view is as wide as the sphere. The four parts of its rim within a pixel of the picture's border have no uncovered neighbours.
        let rim = (2.0 * std::f64::consts::PI - 8.0 * (1.0 - texel).acos()) / texel;
        assert!(orange > 0.7 * rim && orange < 1.5 * rim, "{orange} pixels of a rim of {rim}");
    }
}
