//! The picture of `gobo slice`: the visibility at one depth, with the outline of the casters over it.

use crate::report::{Paper, with_scale};
use crate::scene::{Caster, Scene, View};
use glam::{DVec2, DVec3};

/// The silhouette's colour: orange, as of Okabe and Ito 2008.
const OUTLINE: [u8; 3] = [213, 94, 0];

/// The share of a splat's drawn extent up to which it is visible.
const SEEN: f64 = 0.5;

/// Which pixels of a light's view the translucent casters cover, however thinly; rows from the top.
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
    scene.gaussians.iter().for_each(|g| disc(wide(g.position), SEEN * f64::from(Caster::from(g).radius)));
    for strand in &scene.strands {
        let (start, end) = (wide(strand.start), wide(strand.end));
        // At least one place per pixel from end to end, so that no pixel in between is left out.
        let [first, last] = [start, end].map(|place| view.project(place).0);
        let places = ((last - first).abs().max_element().ceil()).clamp(1.0, 4096.0);
        (0..=places as u32).for_each(|i| disc(start.lerp(end, f64::from(i) / places), strand.radius.into()));
    }
    covered
}

/// Grey visibility with the casters' silhouette over it, and the grey scale and the depth below it.
pub(super) fn shown(scene: &Scene, view: &View, depth: f32, size: u32, mut rgb8: Vec<u8>) -> Paper {
    let sized = View { width: size, height: size, ..*view };
    let covered = covered(scene, &sized);
    let at = |x: u32, y: u32| x < size && y < size && covered[(y * size + x) as usize];
    for (x, y) in (0..size).flat_map(|y| (0..size).map(move |x| (x, y))) {
        let beside = [(x + 1, y), (x.wrapping_sub(1), y), (x, y + 1), (x, y.wrapping_sub(1))];
        if at(x, y) && beside.iter().any(|(x, y)| !at(*x, *y)) {
            let place = 3 * (y * size + x) as usize;
            rgb8[place..place + 3].copy_from_slice(&OUTLINE);
        }
    }
    let grey = |share: f64| {
        let pixels = vec![[share as f32; 3]];
        let bytes = crate::scene::Picture { width: 1, height: 1, pixels }.to_srgb8();
        [bytes[0], bytes[1], bytes[2]]
    };
    let words = format!("visibility at depth {depth:.2}: {:.2} world units", view.z(f64::from(depth)));
    with_scale(&rgb8, [size; 2], grey, ["0", &words, "1"])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::tests::on_the_axis;

    /// One sphere on the axis is a disc in the middle of its light's view, as wide as its radius says.
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
        let paper = shown(&scene, &view, 0.5, 64, vec![255; 3 * 64 * 64]);
        let orange = paper.rgb8.chunks_exact(3).filter(|p| **p == OUTLINE).count() as f64;
        let rim = 2.0 * std::f64::consts::PI / texel;
        assert!(orange > 0.7 * rim && orange < 1.5 * rim, "{orange} pixels of a rim of {rim}");
    }
}
