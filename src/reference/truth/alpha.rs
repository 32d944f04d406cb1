//! Alpha at a point of a triangle, and over a part of it, in f64.

use crate::scene::{Alpha, AlphaMode, AlphaTexture, MAX_OPTICAL_DEPTH, Wrap};
use glam::{DVec2, DVec3};
use std::sync::Arc;

/// Maximum number of texels that [`TriangleAlpha::coverage`] looks at. Beyond it, the part counts as [`Coverage::Some`]. Twin: MOST_TEXELS
/// in glsl/world/alpha_cover.glsl.
const MOST_TEXELS: i64 = 256;

/// How far below the cutoff alpha may be by rounding alone. A texel of 102 has an alpha of 0.4, and a cutoff of 0.4 in f32 is larger.
const ROUNDING: f64 = 1e-6;

/// Alpha of a triangle.
pub(super) struct TriangleAlpha {
    mode: AlphaMode,
    uvs: [DVec2; 3],
    factors: [f64; 3],
    texture: Option<Arc<AlphaTexture>>,
    /// Factors of the optical depth for red, green and blue light.
    pub extinction_ratio: [f32; 3],
}

/// How much of a part of a surface blocks light.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Coverage {
    /// Nothing.
    None,
    /// Possibly some of it.
    Some,
    /// All of it.
    All,
}

impl TriangleAlpha {
    /// Returns the alpha of a triangle of a mesh, given by its vertex indices.
    pub fn new(alpha: &Alpha, triangle: [u32; 3]) -> Self {
        let uv = |i: u32| alpha.uvs.get(i as usize).map_or(DVec2::ZERO, |uv| DVec2::from(uv.map(f64::from)));
        let factor = |i: u32| alpha.factors.get(i as usize).map_or(1.0, |factor| f64::from(*factor));
        Self {
            mode: alpha.mode,
            uvs: triangle.map(uv),
            factors: triangle.map(factor),
            texture: alpha.texture.clone(),
            extinction_ratio: alpha.extinction_ratio,
        }
    }

    /// Returns alpha at the point with these weights of the three corners.
    fn value(&self, weights: [f64; 3]) -> f64 {
        let factor: f64 = weights.iter().zip(self.factors).map(|(weight, factor)| weight * factor).sum();
        let uv: DVec2 = weights.iter().zip(self.uvs).map(|(weight, uv)| *weight * uv).sum();
        factor * self.texture.as_ref().map_or(1.0, |texture| bilinear(texture, uv))
    }

    /// Returns whether the point with these weights of the three corners blocks all light.
    pub fn blocks(&self, weights: [f64; 3]) -> bool {
        match self.mode {
            AlphaMode::Cut(cutoff) => self.value(weights) + ROUNDING >= f64::from(cutoff),
            AlphaMode::SeeThrough => false,
        }
    }

    /// Returns the optical depth of a see-through triangle at the point with these weights of the three corners; 0 for other triangles.
    pub fn optical_depth(&self, weights: [f64; 3]) -> f64 {
        match self.mode {
            AlphaMode::Cut(_) => 0.0,
            AlphaMode::SeeThrough => (-(-self.value(weights)).ln_1p()).min(MAX_OPTICAL_DEPTH.into()),
        }
    }

    /// Returns how much of a convex part of the triangle blocks light. The part is given by the weights of the triangle's corners at each
    /// of its own corners, and may extend beyond the triangle.
    pub fn coverage(&self, part: &[[f64; 3]]) -> Coverage {
        let AlphaMode::Cut(cutoff) = self.mode else { return Coverage::None };
        if part.is_empty() {
            return Coverage::Some;
        }
        let range = |(low, high): (f64, f64), value: f64| (low.min(value), high.max(value));
        let factors = self.factors.into_iter().fold((f64::INFINITY, f64::NEG_INFINITY), range);
        let texels = match &self.texture {
            None => Some((1.0, 1.0)),
            Some(texture) => self.texel_range(texture, part),
        };
        let Some(texels) = texels else { return Coverage::Some };
        let (least, most) = (factors.0 * texels.0 - ROUNDING, factors.1 * texels.1 + ROUNDING);
        if most < cutoff.into() {
            Coverage::None
        } else if least >= cutoff.into() {
            Coverage::All
        } else {
            Coverage::Some
        }
    }

    /// Returns the least and greatest alpha of the texels between which a part of the triangle is interpolated; `None` if there are too
    /// many.
    fn texel_range(&self, texture: &AlphaTexture, part: &[[f64; 3]]) -> Option<(f64, f64)> {
        let size = DVec2::new(f64::from(texture.size[0]), f64::from(texture.size[1]));
        let uv = |weights: &[f64; 3]| weights.iter().zip(self.uvs).map(|(w, uv)| *w * uv).sum::<DVec2>() * size - 0.5;
        let (low, high) = part
            .iter()
            .map(uv)
            .fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(low, high), uv| (low.min(uv), high.max(uv)));
        let corners = self.uvs.map(|uv| uv * size - 0.5);
        let (least, most) = (corners[0].min(corners[1]).min(corners[2]), corners[0].max(corners[1]).max(corners[2]));
        let (low, high) = (low.clamp(least, most), high.clamp(least, most));
        let first = [low.x, low.y].map(|at| whole(at - 1e-3));
        let last = [high.x, high.y].map(|at| whole(at + 1e-3) + 1);
        let counts = [0, 1].map(|axis| last[axis].saturating_sub(first[axis]).saturating_add(1));
        if counts[0].saturating_mul(counts[1]) > MOST_TEXELS {
            return None;
        }
        let all = (first[1]..=last[1]).flat_map(|y| (first[0]..=last[0]).map(move |x| [x, y]));
        let values = all.map(|at| texel(texture, at));
        Some(values.fold((1.0, 0.0), |(low, high), value| (low.min(value), high.max(value))))
    }
}

/// Returns the whole number below `at`, or one so large that it can still be added to.
fn whole(at: f64) -> i64 {
    at.floor().clamp(-1e15, 1e15) as i64
}

/// Returns a texture's alpha between the centres of four texels.
fn bilinear(texture: &AlphaTexture, uv: DVec2) -> f64 {
    let at = [0, 1].map(|axis| uv[axis] * f64::from(texture.size[axis]) - 0.5);
    let ([x, y], [right, down]) = (at.map(whole), at.map(|at| at - at.floor()));
    let row = |y: i64| texel(texture, [x, y]) * (1.0 - right) + texel(texture, [x + 1, y]) * right;
    row(y) * (1.0 - down) + row(y + 1) * down
}

/// Returns the alpha of a texel, which may be outside the texture.
fn texel(texture: &AlphaTexture, at: [i64; 2]) -> f64 {
    let [x, y] = [0, 1].map(|axis| {
        let size = i64::from(texture.size[axis]);
        match texture.wrap[axis] {
            Wrap::Repeat => at[axis].rem_euclid(size),
            Wrap::Mirror => {
                let within = at[axis].rem_euclid(2 * size);
                within.min(2 * size - 1 - within)
            }
            Wrap::Clamp => at[axis].clamp(0, size - 1),
        }
    });
    let place = y as usize * texture.size[0] as usize + x as usize;
    texture.texels.get(place).map_or(0.0, |&alpha| f64::from(alpha) / 255.0)
}

/// Returns the weights of a triangle's corners at a point of its plane; `None` if the triangle has no area.
pub(super) fn weights([a, b, c]: [DVec3; 3], point: DVec3) -> Option<[f64; 3]> {
    let (ab, ac, offset) = (b - a, c - a, point - a);
    let normal = ab.cross(ac);
    let square = normal.length_squared();
    let (of_b, of_c) = (offset.cross(ac).dot(normal) / square, ab.cross(offset).dot(normal) / square);
    (square > 0.0).then_some([1.0 - of_b - of_c, of_b, of_c])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn texture(size: [u32; 2], wrap: Wrap, texels: &[u8]) -> AlphaTexture {
        AlphaTexture { size, wrap: [wrap; 2], texels: texels.to_vec() }
    }

    /// At a texel's centre alpha is the texel's; half way between two centres it is their mean.
    #[test]
    fn between_the_centres_of_texels() {
        let ramp = texture([4, 1], Wrap::Clamp, &[0, 51, 102, 255]);
        let at = |x: f64| (bilinear(&ramp, DVec2::new(x / 4.0, 0.3)) * 255.0).round() as i32;
        assert_eq!([0.5, 1.5, 2.5, 3.5].map(at), [0, 51, 102, 255]);
        assert_eq!([1.0, 2.0, 3.0].map(at), [26, 77, 179]);
        assert_eq!([-3.0, 0.0, 4.0, 9.0].map(at), [0, 0, 255, 255]);
    }

    /// A texel of exactly the cutoff blocks, whichever way the cutoff was rounded to f32.
    #[test]
    fn a_texel_of_the_cutoff_blocks() {
        for alpha in 1..=255_u8 {
            let blocks = |cutoff: f32| {
                let texture = Some(Arc::new(texture([1, 1], Wrap::Clamp, &[alpha])));
                let alpha =
                    Alpha { uvs: vec![[0.5; 2]; 3], texture, ..Alpha::constant(AlphaMode::Cut(cutoff), 1.0, 3) };
                TriangleAlpha::new(&alpha, [0, 1, 2]).blocks([0.2, 0.3, 0.5])
            };
            assert!(blocks(f32::from(alpha) / 255.0) && !blocks((f32::from(alpha) + 0.1) / 255.0), "{alpha}");
        }
    }

    #[test]
    fn beyond_the_border() {
        let centre = |x: f64, wrap: Wrap| {
            let ramp = texture([3, 1], wrap, &[10, 20, 30]);
            (bilinear(&ramp, DVec2::new((x + 0.5) / 3.0, 0.5)) * 255.0).round() as i32
        };
        let of = |wrap| [-4.0, -3.0, -2.0, -1.0, 3.0, 4.0, 5.0, 6.0].map(|x| centre(x, wrap));
        assert_eq!(of(Wrap::Repeat), [30, 10, 20, 30, 10, 20, 30, 10]);
        assert_eq!(of(Wrap::Mirror), [30, 30, 20, 10, 30, 20, 10, 10]);
        assert_eq!(of(Wrap::Clamp), [10, 10, 10, 10, 30, 30, 30, 30]);
    }

    /// The coverage of a part bounds every point of it.
    #[test]
    fn coverage_bounds_its_points() {
        use rand::Rng;
        let mut random = rand_pcg::Pcg32::new(3, 5);
        let mut share = || f64::from(random.next_u32()) / f64::from(u32::MAX);
        let mut found = [0; 3];
        for round in 0..3000 {
            let side = 1 + round % 9;
            let texels = (0..side * side).map(|_| if share() < 0.5 { 0 } else { 255 }).collect::<Vec<_>>();
            let alpha = Alpha {
                uvs: (0..3).map(|_| [share(), share()].map(|at| (4.0 * at - 2.0) as f32)).collect(),
                texture: Some(Arc::new(AlphaTexture {
                    size: [side; 2],
                    wrap: [[Wrap::Repeat, Wrap::Mirror, Wrap::Clamp][round as usize % 3]; 2],
                    texels,
                })),
                ..Alpha::constant(AlphaMode::Cut(0.5), 1.0, 3)
            };
            let triangle = TriangleAlpha::new(&alpha, [0, 1, 2]);
            let inside =
                |a: f64, b: f64| if a + b > 1.0 { [a + b - 1.0, 1.0 - a, 1.0 - b] } else { [1.0 - a - b, a, b] };
            let first = inside(share(), share());
            let part: Vec<_> = (0..3)
                .map(|_| {
                    let other = inside(share(), share());
                    [0, 1, 2].map(|i| first[i] + 0.1 * (other[i] - first[i]))
                })
                .collect();
            let coverage = triangle.coverage(&part);
            found[coverage as usize] += 1;
            for _ in 0..20 {
                let mix = inside(share(), share());
                let at = [0, 1, 2].map(|i| (0..3).map(|k| mix[k] * part[k][i]).sum());
                let blocks = triangle.blocks(at);
                assert!(coverage == Coverage::Some || blocks == (coverage == Coverage::All), "{coverage:?} {at:?}");
            }
        }
        assert!(found.iter().all(|count| *count > 100), "{found:?}");
    }
}
