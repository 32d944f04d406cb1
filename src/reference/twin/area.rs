//! CPU twin of glsl/maps/bins/area.glsl, in f32. A whole texel sees one segment per caster, which transmits the mean light of all rays of
//! the texel. Each cell of a texel stores the share of light that the casters in front leave, so that casters behind one another add up
//! correctly.

use super::segment::{Segment, about_origin, ray, segment_at, strand_along};
use crate::scene::{Caster, Projection, View};
use glam::{Vec2, Vec2Swizzles, Vec3};

const WIDE: f32 = 2.0;
const SPHERE_RAYS: u32 = 4;
const COLUMNS: usize = 8;
const SIDE: usize = SPHERE_RAYS as usize;

/// Number of cells per texel, stored in rows along x.
pub const AREA_CELLS: usize = SIDE * SIDE;

fn share_taken(optical_depth: f32) -> f32 {
    if optical_depth < 1e-3 {
        optical_depth - 0.5 * optical_depth * optical_depth
    } else {
        1.0 - (-optical_depth).exp()
    }
}

/// Returns the optical depth that absorbs the share `taken` of the light, at most `most`.
fn optical_depth_of(taken: f32, most: f32) -> f32 {
    let optical_depth = if taken < 1e-3 { taken + 0.5 * taken * taken } else { -(1.0 - taken).ln() };
    if taken < 0.999_999 { optical_depth.min(most) } else { most }
}

/// Twin: texel_sides.
fn sides(view: &View, z: f32) -> Vec2 {
    let size = Vec2::new(view.width as f32, view.height as f32);
    let sides = (2.0 / (size * Vec2::new(view.scale_x, view.scale_y))).abs();
    if view.projection() == Projection::Parallel { sides } else { sides * z }
}

/// Lines across a texel, and where each meets the ribbon that a strand forms on the map. Twin: Lines.
struct Lines {
    z: f32,
    middle: f32,
    half_wide: f32,
    ends: [f32; 2],
    on_u: Vec2,
    on_v: Vec2,
    per_u: f32,
    per_v: f32,
    turned: bool,
}

impl Lines {
    /// Returns `None` if the ribbon is seen edge-on. Twin: strand_lines, which also drops ribbons that none of the lines meets.
    fn new(view: &View, texel: [u32; 2], strand: &Caster) -> Option<Self> {
        let ray = ray(view, Vec2::new(texel[0] as f32, texel[1] as f32) + 0.5);
        let (start, axis, along) = strand_along(ray, strand);
        let (origin, direction) = ray;
        let point = Vec3::from(strand.position) - origin + along?.clamp(0.0, 1.0) * Vec3::from(strand.axis);
        let z = point.dot(direction) / direction.dot(direction);
        let extent = axis.length();
        let u = axis / extent;
        let v = u.cross(direction.normalize());
        let on = |w: Vec3| sides(view, z) * Vec2::new(w.dot(view.right.into()), w.dot(view.up.into()));
        let (mut on_u, mut on_v) = (on(u), on(v));
        let turned = on_v.x.abs() > on_v.y.abs();
        if turned {
            (on_u, on_v) = (on_u.yx(), on_v.yx());
        }
        let per_u = 1.0 / (on_u.y + if on_u.y < 0.0 { -1e-9 } else { 1e-9 });
        let per_v = 1.0 / on_v.y;
        let (from, middle, half_wide) = (start.dot(u), start.dot(v), strand.radius * per_v.abs());
        Some(Self { z, middle, half_wide, ends: [from, from + extent], on_u, on_v, per_u, per_v, turned })
    }

    /// Twin: line_within.
    fn within(&self, i: usize) -> [f32; 2] {
        let at = (i as f32 + 0.5) / COLUMNS as f32 - 0.5;
        let centre = (self.middle - at * self.on_v.x) * self.per_v;
        let ends = self.ends.map(|end| (end - at * self.on_u.x) * self.per_u);
        let low = (centre - self.half_wide).max(ends[0].min(ends[1])).max(-0.5);
        [low, (centre + self.half_wide).min(ends[0].max(ends[1])).min(0.5)]
    }
}

/// Returns the ribbon's z, and the share of the texel that it covers. Twin: strand_share.
fn strand_share(view: &View, texel: [u32; 2], strand: &Caster) -> Option<(f32, f32)> {
    let lines = Lines::new(view, texel, strand)?;
    let part = |i: usize| {
        let [low, high] = lines.within(i);
        (high - low).max(0.0) / COLUMNS as f32
    };
    let share = (0..COLUMNS).map(part).sum();
    (share > 0.0 && lines.z > view.near).then_some((lines.z, share))
}

/// Returns the shares of the texel's cells that a strand covers. Twin: strand_cells.
fn strand_cells(view: &View, texel: [u32; 2], strand: &Caster) -> [f32; AREA_CELLS] {
    const EACH: usize = COLUMNS / SIDE;
    let mut shares = [0.0; AREA_CELLS];
    let Some(lines) = Lines::new(view, texel, strand) else { return shares };
    for i in 0..COLUMNS {
        let [enters, leaves] = lines.within(i);
        for j in 0..SIDE {
            let [low, high] = [j, j + 1].map(|edge| edge as f32 / SIDE as f32 - 0.5);
            let cell = if lines.turned { i / EACH * SIDE + j } else { j * SIDE + i / EACH };
            shares[cell] += (leaves.min(high) - enters.max(low)).max(0.0) * (SIDE as f32 / EACH as f32);
        }
    }
    shares
}

/// Cuts a segment off at the depth where its optical depth reaches `dark`, since hardly any light is left behind it. Twin: segment_cut.
fn cut(segment: Segment, dark: f32) -> Segment {
    let Segment { entry, exit, optical_depth } = segment;
    if optical_depth <= dark {
        return segment;
    }
    Segment { entry, exit: entry + (exit - entry) * (dark / optical_depth), optical_depth: dark }
}

/// Returns the segments of the rays through the centres of a texel's cells, or `None` if the caster is so wide that these rays have nearly
/// equal segments. Twin: is_thin and sphere_part.
fn thin_parts(view: &View, texel: [u32; 2], caster: &Caster, dark: f32) -> Option<[Option<Segment>; AREA_CELLS]> {
    let middle = Vec2::new(texel[0] as f32, texel[1] as f32) + 0.5;
    let z = Vec3::from(caster.position).dot(view.forward.into());
    if !caster.is_splat_or_cell() && caster.radius >= WIDE * sides(view, z.max(view.near)).max_element() {
        return None;
    }
    let beside = |i: usize| (Vec2::new((i % SIDE) as f32, (i / SIDE) as f32) + 0.5) / SIDE as f32 - 0.5;
    Some(std::array::from_fn(|i| segment_at(view, middle + beside(i), caster).map(|segment| cut(segment, dark))))
}

/// Returns the caster's segment for the whole texel, or `None` if no ray meets the caster. Twin: texel_part with AREA.
pub fn texel_part(view: &View, texel: [u32; 2], caster: &Caster, dark: f32) -> Option<Segment> {
    let (view, caster) = (&about_origin(view, caster).0, &about_origin(view, caster).1);
    if caster.is_strand() {
        let (z, share) = strand_share(view, texel, caster)?;
        let depth = (z - view.near) / (view.far - view.near);
        let whole = caster.density.min(dark);
        let optical_depth = optical_depth_of(share * share_taken(whole), whole);
        return Some(Segment { entry: depth, exit: depth, optical_depth });
    }
    let Some(parts) = thin_parts(view, texel, caster, dark) else {
        let middle = Vec2::new(texel[0] as f32, texel[1] as f32) + 0.5;
        return segment_at(view, middle, caster).map(|segment| cut(segment, dark));
    };
    let met: Vec<_> = parts.into_iter().flatten().collect();
    let taken: f32 = met.iter().map(|s| share_taken(s.optical_depth) / AREA_CELLS as f32).sum();
    let entry = met.iter().map(|s| s.entry).reduce(f32::min)?;
    let exit = met.iter().map(|s| s.exit).reduce(f32::max)?;
    (taken > 0.0).then(|| Segment { entry, exit, optical_depth: optical_depth_of(taken, dark) })
}

/// Share of light that a caster absorbs in each cell of a texel, and the caster's largest optical depth over all cells. `None` if the share
/// is the same in all cells.
pub type Taken = Option<([f32; AREA_CELLS], f32)>;

/// Returns the share of light that one caster absorbs in each cell, in the form read by area_seen.
pub fn texel_taken(view: &View, texel: [u32; 2], caster: &Caster, dark: f32) -> Taken {
    let (view, caster) = about_origin(view, caster);
    if caster.is_strand() {
        let deepest = caster.density.min(dark);
        let whole = share_taken(deepest);
        return Some((strand_cells(&view, texel, &caster).map(|share| share * whole), deepest));
    }
    let depths = thin_parts(&view, texel, &caster, dark)?.map(|part| part.map_or(0.0, |s| s.optical_depth));
    Some((depths.map(share_taken), depths.into_iter().fold(0.0, f32::max)))
}

/// Transmittance of each cell of a texel. Twin: cell_light.
pub struct CellLight([f32; AREA_CELLS]);

impl CellLight {
    /// Creates cells that are fully lit. Twin: area_clear.
    pub fn whole() -> Self {
        Self([1.0; AREA_CELLS])
    }

    /// Removes from the cells the light that a caster absorbs (`taken`). Returns the optical depth by which the mean light of the cells
    /// falls; if the caster is the same in all cells, that is `optical_depth`. Twin: area_seen.
    pub fn seen(&mut self, taken: &Taken, optical_depth: f32) -> f32 {
        let Some((taken, deepest)) = taken else { return optical_depth };
        let (mut light, mut lost) = (0.0, 0.0);
        for (left, taken) in self.0.iter_mut().zip(taken) {
            let its = *left * taken.min(1.0);
            light += *left;
            lost += its;
            *left -= its;
        }
        if lost > 0.0 { optical_depth_of(lost / light, *deepest) } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reference::twin::segment::{MAX_OPTICAL_DEPTH, texel_segment};
    use proptest::prelude::*;

    const SIZE: u32 = 12;

    /// Returns a view down the z axis. Texels are one unit wide: everywhere in a parallel view, at z = 10 in perspective.
    fn view(projection: Projection, size: u32) -> View {
        let half = 0.5 * SIZE as f32;
        let scale = if projection == Projection::Parallel { 1.0 / half } else { 10.0 / half };
        View {
            origin: [0.0; 3],
            projection: projection as u32,
            right: [1.0, 0.0, 0.0],
            scale_x: scale,
            up: [0.0, 1.0, 0.0],
            scale_y: scale,
            forward: [0.0, 0.0, 1.0],
            near: 0.5,
            far: 20.0,
            width: size,
            height: size,
        }
    }

    fn caster(is_strand: bool) -> impl Strategy<Value = Caster> {
        let place = (-4.0..4.0f32, -4.0..4.0f32, 8.0..12.0f32).prop_map(<[f32; 3]>::from);
        let axis = (-5.0..5.0f32, -5.0..5.0f32, -2.0..2.0f32).prop_map(<[f32; 3]>::from);
        (place, axis, 0.05..1.2f32, 0.01..6.0f32).prop_map(move |(position, axis, radius, density)| Caster {
            position,
            radius,
            axis: if is_strand { axis } else { [0.0; 3] },
            density,
        })
    }

    fn projection() -> impl Strategy<Value = Projection> {
        prop_oneof![Just(Projection::Parallel), Just(Projection::Perspective)]
    }

    fn taken(segment: Option<Segment>) -> f64 {
        segment.map_or(0.0, |s| 1.0 - f64::from(-s.optical_depth).exp())
    }

    /// Number of rays per texel side in the reference mean.
    const FINE: u32 = 64;

    /// Returns the mean share of light that a texel's rays lose, using the rays of a map FINE times as fine.
    fn mean(projection: Projection, [x, y]: [u32; 2], caster: &Caster) -> f64 {
        let view = view(projection, SIZE * FINE);
        let one = |i: u32| taken(texel_segment(&view, [x * FINE + i % FINE, y * FINE + i / FINE], caster));
        (0..FINE * FINE).map(one).sum::<f64>() / f64::from(FINE * FINE)
    }

    /// Returns the strand's length in the map, in texels.
    fn length_in_texels(projection: Projection, strand: &Caster) -> f32 {
        let at = |place: Vec3| place.truncate() * if projection == Projection::Parallel { 1.0 } else { 10.0 / place.z };
        let start = Vec3::from(strand.position);
        at(start).distance(at(start + Vec3::from(strand.axis)))
    }

    /// Returns how much a strand's apparent length may differ between a texel's centre and its corners, as a share of that length. The
    /// apparent length is proportional to the sine of the angle between strand and ray. At the corners, half a diagonal away, the angle
    /// differs most from the angle at the centre; this matters if a strand points along the rays. Parallel rays all see the same length.
    fn foreshortening(projection: Projection, [x, y]: [u32; 2], strand: &Caster) -> f64 {
        if projection == Projection::Parallel {
            return 0.0;
        }
        let (_, direction) = ray(&view(projection, SIZE), Vec2::new(x as f32, y as f32) + 0.5);
        let sine = direction.normalize().cross(Vec3::from(strand.axis).normalize()).length();
        let half_diagonal = 0.5 * 2.0f32.sqrt() / 10.0;
        f64::from((half_diagonal / sine.max(1e-6)).min(1.0))
    }

    fn texels() -> impl Iterator<Item = [u32; 2]> {
        (0..SIZE * SIZE).map(|i| [i % SIZE, i / SIZE])
    }

    /// Compares, in each texel, the mean over eight lines with the mean over 4096 rays. Summed over all texels, the lines absorb as much
    /// light as the rays: none is lost between texels.
    fn strand_takes_the_mean_of_all_rays(caster: Caster, projection: Projection) -> Result<(), TestCaseError> {
        let view = view(projection, SIZE);
        let (mut sum, mut wanted) = (0.0, 0.0);
        for texel in texels() {
            let (own, all) =
                (taken(texel_part(&view, texel, &caster, MAX_OPTICAL_DEPTH)), mean(projection, texel, &caster));
            let most = 0.1 + all * foreshortening(projection, texel, &caster);
            prop_assert!((own - all).abs() < most, "{texel:?}: {own}, not {all}");
            sum += own;
            wanted += all;
        }
        // The tolerance covers two errors. A row of rays along a strand measures its length only to within the ray spacing, and lines
        // locate its end only to within the line spacing. (In hair, where the next piece starts at that end, these errors cancel.)
        let side = length_in_texels(projection, &caster) / FINE as f32;
        let end = 2.0 * caster.radius / COLUMNS as f32;
        let most = 0.02 * wanted + 0.02 + f64::from((side + end) * share_taken(caster.density));
        prop_assert!((sum - wanted).abs() < most, "{sum} in all, not {wanted}");
        Ok(())
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(48))]

        #[test]
        fn a_strand_takes_the_mean_of_all_rays(caster in caster(true), projection in projection()) {
            strand_takes_the_mean_of_all_rays(caster, projection)?;
        }

        /// Compares the mean over 16 rays of a texel with the mean over 4096. The 16 rays lie on four lines. On each line the sphere has
        /// two edges, and the error bound for the position of each edge is half the ray spacing.
        #[test]
        fn a_small_sphere_takes_the_mean_of_all_rays(caster in caster(false), projection in projection()) {
            let view = view(projection, SIZE);
            let most = 2.0 * 0.5 / f64::from(SPHERE_RAYS);
            for texel in texels() {
                let (own, all) = (taken(texel_part(&view, texel, &caster, MAX_OPTICAL_DEPTH)), mean(projection, texel, &caster));
                prop_assert!((own - all).abs() < most, "{texel:?}: {own}, not {all}");
            }
        }
    }

    /// A strand along a ray, in perspective: its apparent length changes by half within a texel.
    #[test]
    fn a_strand_along_a_ray_takes_about_the_mean() {
        let (position, axis) = ([-2.0431788, 0.0, 8.0], [-0.44344693, -0.16859736, 1.8485361]);
        let strand = Caster { position, radius: 0.6758513, axis, density: 5.427126 };
        strand_takes_the_mean_of_all_rays(strand, Projection::Perspective).expect("about the mean");
    }

    /// If a ribbon is axis-aligned, its share of a texel is the overlap of two intervals.
    #[test]
    fn shares_are_areas() {
        let view = view(Projection::Parallel, SIZE);
        let share = |position: [f32; 3], axis: [f32; 3], radius: f32| {
            let strand = Caster { position, radius, axis, density: 1.0 };
            strand_share(&view, [6, 6], &strand).map_or(0.0, |(_, share)| share)
        };
        // The texel is the unit square at the origin.
        let close = |a: f32, b: f32| assert!((a - b).abs() < 1e-4, "{a}, not {b}");
        close(share([-9.0, 0.5, 9.0], [18.0, 0.0, 0.0], 0.1), 0.2);
        close(share([-9.0, 0.0, 9.0], [18.0, 0.0, 0.0], 0.1), 0.1);
        close(share([-9.0, -0.2, 9.0], [18.0, 0.0, 0.0], 0.1), 0.0);
        close(share([0.5, -9.0, 9.0], [0.0, 18.0, 0.0], 3.0), 1.0);
        close(share([0.25, 0.5, 9.0], [0.5, 0.0, 0.0], 0.1), 0.1);
        // A strip along the diagonal covers the square minus two triangles.
        let half = 0.1;
        let side = 1.0 - half * std::f32::consts::SQRT_2;
        let error = (share([-9.0, -9.0, 9.0], [18.0, 18.0, 0.0], half) - (1.0 - side * side)).abs();
        assert!(error < 0.5 / (COLUMNS * COLUMNS) as f32, "{error}");
    }

    /// Returns the light left behind `casters`, which the rays of a texel meet in this order, computed in two ways: with cells, and as if
    /// each caster covered a random part of the texel.
    fn left(view: &View, texel: [u32; 2], casters: &[Caster]) -> [f64; 2] {
        let mut light = CellLight::whole();
        let (mut by_cells, mut by_chance) = (0.0, 0.0);
        for caster in casters {
            let Some(part) = texel_part(view, texel, caster, MAX_OPTICAL_DEPTH) else { continue };
            by_chance += f64::from(part.optical_depth);
            let taken = texel_taken(view, texel, caster, MAX_OPTICAL_DEPTH);
            by_cells += f64::from(light.seen(&taken, part.optical_depth));
        }
        [by_cells, by_chance].map(|optical_depth| (-optical_depth).exp())
    }

    /// Builds a ribbon along x across the unit square at the origin, which is texel (6, 6): from `low` to `low + width` in y, at depth `z`.
    fn ribbon(low: f32, width: f32, z: f32, opacity: f32) -> Caster {
        let density = -(1.0 - opacity).ln();
        Caster { position: [-9.0, low + 0.5 * width, z], radius: 0.5 * width, axis: [18.0, 0.0, 0.0], density }
    }

    /// Layers of ribbons whose edges coincide with cell edges. Each layer lies right behind the previous one, beside it, or across it. The
    /// remaining light has a closed form. The cells reproduce it exactly; ribbons that cover random parts of the texel do not.
    #[test]
    fn lattices_have_closed_forms() {
        let view = view(Projection::Parallel, SIZE);
        let opacity = 0.7f32;
        let through = 1.0 - f64::from(opacity);
        let across = |strand: Caster| Caster {
            position: [strand.position[1], -9.0, strand.position[2]],
            axis: [0.0, 18.0, 0.0],
            ..strand
        };
        // Two of four rows.
        let layer =
            |k: usize, shift: f32| [0.0, 0.5].map(|row| ribbon(row + shift, 0.25, 8.0 + 0.1 * k as f32, opacity));
        type Case<'a> = (&'a str, &'a dyn Fn(usize) -> [Caster; 2], &'a dyn Fn(i32) -> f64);
        let cases: [Case; 3] = [
            ("behind", &|k| layer(k, 0.0), &|n| 0.5 + 0.5 * through.powi(n)),
            ("beside", &|k| layer(k, 0.25 * (k % 2) as f32), &|n| {
                0.5 * (through.powi(n / 2) + through.powi(n - n / 2))
            }),
            ("across", &|k| if k % 2 == 0 { layer(k, 0.0) } else { layer(k, 0.0).map(across) }, &|n| {
                (0.5 + 0.5 * through.powi(n / 2)) * (0.5 + 0.5 * through.powi(n - n / 2))
            }),
        ];
        for (name, layer, expected) in cases {
            let mut casters = Vec::new();
            let mut chance: f64 = 0.0;
            for n in 1..=6 {
                casters.extend(layer(n - 1));
                let [by_cells, by_chance] = left(&view, [6, 6], &casters);
                let expected = expected(n as i32);
                assert!((by_cells - expected).abs() < 1e-5, "{name}, {n}: {by_cells}, not {expected}");
                chance = chance.max((by_chance - expected).abs());
            }
            assert!(chance > 0.1, "{name}: chance is off by {chance} alone");
        }
    }

    /// Generates up to four strands: behind one another, edge to edge, crossing, and at random.
    fn bundle() -> impl Strategy<Value = Vec<Caster>> {
        let one = (-0.6..0.6f32, -1.0..1.0f32, 0.01..0.8f32, 0.1..0.999f32);
        let many = prop::collection::vec((0u8..4, 0.0..1.0f32), 1..4);
        (one, many).prop_map(|((middle, slope, radius, opacity), others)| {
            let density = -(1.0 - opacity).ln();
            let of = |middle: f32, slope: f32, radius: f32, z: f32| Caster {
                position: [-9.0, 0.5 + middle - 9.5 * slope, z],
                radius,
                axis: [18.0, 18.0 * slope, 0.0],
                density,
            };
            let mut all = vec![of(middle, slope, radius, 8.0)];
            for (i, (kind, share)) in others.into_iter().enumerate() {
                let z = 8.2 + 0.2 * i as f32;
                let wide = 2.0 * radius * (1.0 + slope * slope).sqrt();
                all.push(match kind {
                    0 => of(middle, slope, radius, z),
                    1 => of(middle + wide * (i as f32 + 1.0), slope, radius, z),
                    2 => of(middle, -slope, radius * (0.5 + share), z),
                    _ => of(middle + share - 0.5, slope * (share - 0.5), radius * share.max(0.1), z),
                });
            }
            all
        })
    }

    /// Returns the mean light left along all rays of the texel.
    fn left_of_rays([x, y]: [u32; 2], casters: &[Caster]) -> f64 {
        let view = view(Projection::Parallel, SIZE * FINE);
        let ray = |i: u32| {
            let at = [x * FINE + i % FINE, y * FINE + i / FINE];
            casters.iter().map(|caster| 1.0 - taken(texel_segment(&view, at, caster))).product::<f64>()
        };
        (0..FINE * FINE).map(ray).sum::<f64>() / f64::from(FINE * FINE)
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(256))]

        /// The remaining light does not depend on the order of casters, and no caster absorbs more than its own optical depth.
        #[test]
        fn what_is_left_is_bounded_and_has_no_order(casters in bundle()) {
            let view = view(Projection::Parallel, SIZE);
            let [own, _] = left(&view, [6, 6], &casters);
            let others: Vec<_> = casters.iter().rev().copied().collect();
            let [reversed, _] = left(&view, [6, 6], &others);
            prop_assert!((own - reversed).abs() < 1e-5, "{own}, the other way round {reversed}");
            let mut light = CellLight::whole();
            for caster in &casters {
                let Some(part) = texel_part(&view, [6, 6], caster, MAX_OPTICAL_DEPTH) else { continue };
                let seen = light.seen(&texel_taken(&view, [6, 6], caster, MAX_OPTICAL_DEPTH), part.optical_depth);
                prop_assert!((0.0..=caster.density).contains(&seen), "{seen} of {}", caster.density);
            }
        }
    }

    /// Strands lie behind each other: edge to edge, crossing, or at random. The cells come closer to the mean of all rays than the
    /// assumption that strands cover random parts of the texel.
    #[test]
    fn cells_know_more_than_chance() {
        use proptest::strategy::ValueTree;
        use proptest::test_runner::TestRunner;
        let view = view(Projection::Parallel, SIZE);
        let mut runner = TestRunner::deterministic();
        let mut squares = [0.0; 2];
        let mut worst = 0.0f64;
        for _ in 0..300 {
            let casters = bundle().new_tree(&mut runner).expect("a bundle").current();
            let wanted = left_of_rays([6, 6], &casters);
            let errors = left(&view, [6, 6], &casters).map(|left| left - wanted);
            squares.iter_mut().zip(errors).for_each(|(sum, error)| *sum += error * error);
            worst = worst.max(errors[0].abs());
        }
        let [by_cells, by_chance] = squares.map(|sum: f64| (sum / 300.0).sqrt());
        println!("RMS {by_cells:.4} by cells, {by_chance:.4} by chance; worst {worst:.4}");
        assert!(by_chance > 0.04 && by_cells < 0.5 * by_chance, "{by_cells}, by chance {by_chance}");
    }
}
