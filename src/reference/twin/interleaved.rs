//! Twins of glsl/shading/interleaved/: which lights each pixel of a 4 × 4 square queries, and the mean over such squares.

use super::many_lights::frame::Frame;
use super::many_lights::shade::is_same_surface;

/// Returns the number of subsets, called parts, into which the lights are divided. Twin: part_count.
pub fn part_count(lights: u32) -> u32 {
    if lights >= 16 { 16 } else { 1 << lights.max(1).ilog2() }
}

/// Returns a pixel's position in its 4 × 4 square, as an index. Twin: pixel_place.
pub fn place([x, y]: [u32; 2]) -> u32 {
    let two = |x: u32, y: u32| (x & 1) + 2 * (y & 1);
    two(x, y) + 4 * two(x >> 1, y >> 1)
}

/// Returns the indices of the lights queried by the pixel at `place` in its square.
pub fn part(lights: u32, place: u32) -> impl Iterator<Item = u32> {
    let parts = part_count(lights);
    (place % parts..lights).step_by(parts as usize)
}

/// Returns the light that each pixel reflects from its part of the lights. `light` returns the light that the pixel reflects from one
/// light; `seen` is false for pixels that show the sky, which reflects nothing. Twin: glsl/shading/interleaved/ask.comp.
pub fn ask(
    [width, height]: [u32; 2],
    lights: u32,
    seen: impl Fn([u32; 2]) -> bool,
    light: impl Fn([u32; 2], u32) -> [f32; 3],
) -> Vec<[f32; 3]> {
    let pixel = |i: u32| {
        let at = [i % width, i / width];
        let asked = part(lights, place(at)).filter(|_| seen(at));
        asked.fold([0.0; 3], |sum, i| add(sum, light(at, i)))
    };
    (0..width * height).map(pixel).collect()
}

fn add(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    [0, 1, 2].map(|i| a[i] + b[i])
}

/// How well a window of four pixels is centred on a pixel. Entry 0 is for a window that starts 3 pixels before the pixel, entry 1 for one
/// that starts 2 pixels before, and so on to entry 3, where the window starts at the pixel. Twin: NEARNESS.
const NEARNESS: [usize; 4] = [0, 2, 3, 1];

/// Returns the light that each pixel reflects from all lights, equal to the device's up to the rounding of a division; 0 in the sky.
/// `geometry` holds z (as bits) and the packed normal of each pixel. Twin: glsl/shading/interleaved/gather.comp.
pub fn gather(frame: &Frame, geometry: &[[u32; 2]], estimates: &[[f32; 3]], lights: u32) -> Vec<[f32; 3]> {
    let [width, height] = [frame.camera.width, frame.camera.height];
    let pixel = |i: u32| {
        if geometry[i as usize][0] == 0 {
            return [0.0; 3];
        }
        let at = [i % width, i / width].map(|c| c as i32);
        let like = |to: &[i32; 2]| {
            let is_inside = (0..width as i32).contains(&to[0]) && (0..height as i32).contains(&to[1]);
            let other = || (to[1] * width as i32 + to[0]) as usize;
            is_inside && is_same_surface(frame, geometry, [i as usize, other()], [to[0] - at[0], to[1] - at[1]])
        };
        let window = |[x, y]: [usize; 2]| -> Vec<[i32; 2]> {
            let first = [at[0] + x as i32 - 3, at[1] + y as i32 - 3];
            (0..16).map(|j| [first[0] + j % 4, first[1] + j / 4]).filter(like).collect()
        };
        let key = |place: &[usize; 2]| 8 * window(*place).len() + NEARNESS[place[0]] + NEARNESS[place[1]];
        // The first of equal windows wins. `max_by_key` takes the last, so the order is reversed.
        let places = (0..16).map(|j| [j % 4, j / 4]).rev();
        let chosen = places.max_by_key(key).map(window).unwrap_or_default();
        let (mut sum, mut asked) = ([0.0; 3], 0);
        for [x, y] in chosen.into_iter().map(|to| to.map(|c| c as u32)) {
            sum = add(sum, estimates[(y * width + x) as usize]);
            asked += part(lights, place([x, y])).count();
        }
        sum.map(|c| if asked > 0 { c * (lights as f32 / asked as f32) } else { 0.0 })
    };
    (0..width * height).map(pixel).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reference::twin::packed_normal::pack_normal;
    use crate::scene::View;
    use crate::scene::tests::on_the_axis;

    /// In any square of 4 × 4 pixels, all lights are queried equally often, and every pixel queries at least one.
    #[test]
    fn sixteen_pixels_ask_all_lights_alike() {
        for lights in (0..=40).chain([1000, 1023, 1024]) {
            let parts = part_count(lights);
            for (left, top) in [(0, 0), (1, 0), (2, 3), (7, 5)] {
                let mut asked = vec![0; lights as usize];
                for i in 0..16 {
                    let place = place([left + i % 4, top + i / 4]);
                    assert!(lights == 0 || part(lights, place).next().is_some(), "{lights} lights, {place}");
                    part(lights, place).for_each(|light| asked[light as usize] += 1);
                }
                assert!(asked.iter().all(|count| *count == 16 / parts), "{lights} lights: {asked:?}");
            }
        }
        assert_eq!([0, 1, 2, 3, 4, 7, 8, 15, 16, 17].map(part_count), [1, 1, 2, 2, 4, 4, 8, 8, 16, 16]);
    }

    /// With four parts, any 2 × 2 pixels cover all of them.
    #[test]
    fn four_parts_are_near() {
        for (x, y) in [(0, 0), (1, 0), (3, 2), (5, 5)] {
            let mut parts = [[x, y], [x + 1, y], [x, y + 1], [x + 1, y + 1]].map(|at| place(at) % 4);
            parts.sort_unstable();
            assert_eq!(parts, [0, 1, 2, 3]);
        }
    }

    fn frame() -> Frame {
        let scene = on_the_axis(&[(0.0, 1.0, 1.0)]);
        let camera = View::camera(&scene.camera, &scene, [23, 14]);
        Frame { camera, corner: [-0.5, 0.5, 1.0], across: [0.01, 0.0, 0.0], down: [0.0, -0.01, 0.0], edge: 0.02 }
    }

    /// On a plane each pixel gets the sum over all lights, even at the picture's edges and for any number of lights.
    #[test]
    fn a_plane_has_all_lights() {
        let frame = frame();
        let facing = pack_normal([0.0, 0.0, -1.0]);
        for lights in (0..=20).chain([40, 1024]) {
            let shines = |i: u32| [i as f32, (i % 7) as f32, 1.0];
            let estimates = ask([23, 14], lights, |_| true, |_, i| shines(i));
            let all = (0..lights).fold([0.0; 3], |sum, i| add(sum, shines(i)));
            for found in gather(&frame, &vec![[2.0f32.to_bits(), facing]; 23 * 14], &estimates, lights) {
                assert!((0..3).all(|i| (found[i] - all[i]).abs() <= 1e-6 * all[i]), "{lights}: {found:?}, not {all:?}");
            }
        }
    }

    /// Next to an edge, a pixel uses a 4 × 4 window on its own side, and so gets the same result as on a plane.
    #[test]
    fn an_edge_takes_nothing() {
        let frame = frame();
        let normals = [[0.0, 0.0, -1.0], [0.0, -1.0, 0.0]].map(pack_normal);
        let side = |i: usize| usize::from(i % 23 > 9 || i / 23 > 7);
        let geometry: Vec<_> = (0..23 * 14).map(|i| [2.0f32.to_bits(), normals[side(i)]]).collect();
        // The other side is a hundred times as bright, so any leak shows.
        let shines = |[x, y]: [u32; 2], i: u32| [(i + 1) as f32 * [1.0, 100.0][side((y * 23 + x) as usize)], 0.0, 0.0];
        let gathered = gather(&frame, &geometry, &ask([23, 14], 40, |_| true, shines), 40);
        for (i, found) in gathered.iter().enumerate().filter(|(i, _)| side(*i) == 0) {
            assert!((found[0] / 820.0 - 1.0).abs() < 1e-5, "pixel {i}: {found:?}");
        }
    }

    /// A pixel whose neighbours all see other surfaces uses only its own estimate, scaled up to all lights; the sky has no light.
    #[test]
    fn what_stands_alone_keeps_its_own() {
        let frame = frame();
        let facings = [[0.0, 0.0, -1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]];
        let normals = facings.map(pack_normal);
        // Adjacent pixels differ in their normal; pixels farther apart differ in depth.
        let alone = |i: u32| {
            let [x, y] = [i % 23, i / 23];
            let z = 1.0 + 0.9 * (x % 4 + 4 * (y % 4)) as f32;
            [z.to_bits(), normals[((x + 2 * y) % 5) as usize]]
        };
        let mut geometry: Vec<_> = (0..23 * 14).map(alone).collect();
        geometry[40] = [0, 0];
        let estimates = ask([23, 14], 37, |at| at != [17, 1], |at, i| [(at[0] + i) as f32, at[1] as f32, 1.0]);
        let gathered = gather(&frame, &geometry, &estimates, 37);
        let mut alone = 0;
        for (i, (own, found)) in estimates.iter().zip(&gathered).enumerate().filter(|(i, _)| *i != 40) {
            let share = 37.0 / part(37, place([i as u32 % 23, i as u32 / 23])).count() as f32;
            alone += usize::from((0..3).all(|c| (found[c] - share * own[c]).abs() <= 1e-5 * found[c]));
        }
        assert!(alone > 300, "{alone} of 321");
        assert_eq!(gathered[40], [0.0; 3]);
    }
}
