//! CPU twin of glsl/maps/bins/area.glsl: the segment of a caster that lets as much light through as the mean of all rays through a
//! texel, in f32.

use super::segment::{Segment, about_origin, ray, segment_at, strand_along};
use crate::scene::{Caster, Projection, View};
use glam::{Vec2, Vec2Swizzles, Vec3};

const WIDE: f32 = 2.0;
const SPHERE_RAYS: u32 = 4;
const COLUMNS: usize = 8;

fn share_taken(optical_depth: f32) -> f32 {
    if optical_depth < 1e-3 {
        optical_depth - 0.5 * optical_depth * optical_depth
    } else {
        1.0 - (-optical_depth).exp()
    }
}

/// The optical depth of a share that has been taken, `most` at most.
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

/// z and the share of the texel that the ribbon covers. Twin: strand_share.
fn strand_share(view: &View, texel: [u32; 2], strand: &Caster) -> Option<(f32, f32)> {
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
    if on_v.x.abs() > on_v.y.abs() {
        (on_u, on_v) = (on_u.yx(), on_v.yx());
    }
    let per_u = 1.0 / (on_u.y + if on_u.y < 0.0 { -1e-9 } else { 1e-9 });
    let per_v = 1.0 / on_v.y;
    let (from, middle, half_wide) = (start.dot(u), start.dot(v), strand.radius * per_v.abs());
    let part = |i: usize| {
        let at = (i as f32 + 0.5) / COLUMNS as f32 - 0.5;
        let centre = (middle - at * on_v.x) * per_v;
        let ends = [from, from + extent].map(|end| (end - at * on_u.x) * per_u);
        let low = (centre - half_wide).max(ends[0].min(ends[1])).max(-0.5);
        let high = (centre + half_wide).min(ends[0].max(ends[1])).min(0.5);
        (high - low).max(0.0) / COLUMNS as f32
    };
    let share = (0..COLUMNS).map(part).sum();
    (share > 0.0 && z > view.near).then_some((z, share))
}

/// As segment_cut has it where nothing is left behind an optical depth of `dark`.
fn cut(segment: Segment, dark: f32) -> Segment {
    let Segment { entry, exit, optical_depth } = segment;
    if optical_depth <= dark {
        return segment;
    }
    Segment { entry, exit: entry + (exit - entry) * (dark / optical_depth), optical_depth: dark }
}

/// Twin: texel_part with AREA. None where no ray meets the caster.
pub fn texel_part(view: &View, texel: [u32; 2], caster: &Caster, dark: f32) -> Option<Segment> {
    let (view, caster) = (&about_origin(view, caster).0, &about_origin(view, caster).1);
    let middle = Vec2::new(texel[0] as f32, texel[1] as f32) + 0.5;
    if caster.is_strand() {
        let (z, share) = strand_share(view, texel, caster)?;
        let depth = (z - view.near) / (view.far - view.near);
        let whole = caster.density.min(dark);
        let optical_depth = optical_depth_of(share * share_taken(whole), whole);
        return Some(Segment { entry: depth, exit: depth, optical_depth });
    }
    let z = Vec3::from(caster.position).dot(view.forward.into());
    if !caster.is_packed() && caster.radius >= WIDE * sides(view, z.max(view.near)).max_element() {
        return segment_at(view, middle, caster).map(|segment| cut(segment, dark));
    }
    let beside =
        |i: u32| (Vec2::new((i % SPHERE_RAYS) as f32, (i / SPHERE_RAYS) as f32) + 0.5) / SPHERE_RAYS as f32 - 0.5;
    let rays = (0..SPHERE_RAYS * SPHERE_RAYS).filter_map(|i| segment_at(view, middle + beside(i), caster));
    let met: Vec<_> = rays.map(|segment| cut(segment, dark)).collect();
    let taken: f32 = met.iter().map(|s| share_taken(s.optical_depth) / (SPHERE_RAYS * SPHERE_RAYS) as f32).sum();
    let entry = met.iter().map(|s| s.entry).reduce(f32::min)?;
    let exit = met.iter().map(|s| s.exit).reduce(f32::max)?;
    (taken > 0.0).then(|| Segment { entry, exit, optical_depth: optical_depth_of(taken, dark) })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reference::twin::segment::{MAX_OPTICAL_DEPTH, texel_segment};
    use proptest::prelude::*;

    const SIZE: u32 = 12;

    /// Down the z axis; in a parallel view a texel is a unit wide, in perspective too where z is 10.
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

    /// Rays along a side of a texel, of which the means are taken.
    const FINE: u32 = 64;

    /// What a texel's rays take in the mean: those of a map FINE times as fine.
    fn mean(projection: Projection, [x, y]: [u32; 2], caster: &Caster) -> f64 {
        let view = view(projection, SIZE * FINE);
        let one = |i: u32| taken(texel_segment(&view, [x * FINE + i % FINE, y * FINE + i / FINE], caster));
        (0..FINE * FINE).map(one).sum::<f64>() / f64::from(FINE * FINE)
    }

    /// The strand's length in the map.
    fn length_in_texels(projection: Projection, strand: &Caster) -> f32 {
        let at = |place: Vec3| place.truncate() * if projection == Projection::Parallel { 1.0 } else { 10.0 / place.z };
        let start = Vec3::from(strand.position);
        at(start).distance(at(start + Vec3::from(strand.axis)))
    }

    /// By how much the length of a strand that a ray sees may differ between the middle of a texel and its corners, as a share of
    /// it. The length goes with the sine of the angle between strand and ray, and rays of a texel stand up to half its diagonal
    /// apart: it matters where a strand points along the rays. Parallel rays see one length.
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

    /// Eight lines of a texel against 4096 rays of it. All texels together take what all rays do: no light is lost between
    /// them.
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
        // A strand along which rays stand in line is known to the space between two of them, and its ends to the space
        // between two lines. (Where another goes on, as in hair, what one is missed in the other has.)
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

        /// 16 rays of a texel against 4096 of it: on each of four lines each of two edges is off by half the space between
        /// rays at most.
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

    /// Along a ray, in perspective: what one sees of its length changes by half within a texel.
    #[test]
    fn a_strand_along_a_ray_takes_about_the_mean() {
        let (position, axis) = ([-2.0431788, 0.0, 8.0], [-0.44344693, -0.16859736, 1.8485361]);
        let strand = Caster { position, radius: 0.6758513, axis, density: 5.427126 };
        strand_takes_the_mean_of_all_rays(strand, Projection::Perspective).expect("about the mean");
    }

    /// Where a ribbon is aligned, its share of a texel is the overlap of two intervals.
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
        // Half a diagonal's strip: the square less two triangles, whose slopes the lines meet in their middles.
        let half = 0.1;
        let side = 1.0 - half * std::f32::consts::SQRT_2;
        let error = (share([-9.0, -9.0, 9.0], [18.0, 18.0, 0.0], half) - (1.0 - side * side)).abs();
        assert!(error < 0.5 / (COLUMNS * COLUMNS) as f32, "{error}");
    }
}
