//! The points at which techniques are measured, and the truth there.

use super::casters::Casters;
use super::true_curve::TrueCurve;
use crate::scene::{Caster, Light, Ray, Scene, View};
use glam::{DVec2, DVec3};
use rayon::prelude::*;

/// Number of depths at which a covered texel is measured, spread evenly over the light's range as far as the light reaches, both ends
/// included.
pub const MAP_DEPTHS: u32 = 64;

/// The truth at the map points of one map.
pub struct MapTruth {
    /// The light that the map belongs to.
    pub light: usize,
    /// Index of the map, counted over all lights.
    pub map: usize,
    /// Texels that some caster covers, as index y · width + x.
    pub texels: Vec<u32>,
    /// World positions, [`MAP_DEPTHS`] per texel, in order of increasing depth.
    pub points: Vec<[f32; 3]>,
    /// How much of the light reaches each point.
    pub visibility: Vec<f64>,
    /// Total number of segments in these texels.
    pub segments: u64,
}

/// Returns the truth in every map of every light, at the centres of all covered texels. `views` holds the views of all maps, in the order
/// of the lights. In a scene with only meshes, every texel counts as covered. Texels of a point light's face are left out where look-ups
/// use another face.
pub fn map_truths(casters: &Casters, scene: &Scene, views: &[View]) -> Vec<MapTruth> {
    sample_maps(casters, scene, views, usize::MAX).0
}

/// Like [`map_truths`], but with at most `most` covered texels in all maps together. Also returns the fraction of all texels visited to
/// find the covered ones. Every run gives the same result.
///
/// From one visited texel to the next, the index advances by about 0.618 (the inverse golden ratio) times the number of texels and wraps
/// around. The visited texels are therefore evenly spread, however many there are, and none is visited twice.
pub fn sample_maps(casters: &Casters, scene: &Scene, views: &[View], most: usize) -> (Vec<MapTruth>, f64) {
    /// Number of texels visited at a time.
    const CHUNK: usize = 2048;
    let maps = |light: usize| (0..scene.lights[light].map_count()).map(move |face| (light, face));
    let places: Vec<_> = (0..scene.lights.len()).flat_map(maps).zip(views).collect();
    let mut truths: Vec<_> = (0..)
        .zip(&places)
        .map(|(map, ((light, _), _))| MapTruth {
            light: *light,
            map,
            texels: vec![],
            points: vec![],
            visibility: vec![],
            segments: 0,
        })
        .collect();
    // All maps have the same size.
    let per_map = views.first().map_or(0, View::texels);
    let total = per_map * places.len();
    let step = lattice_step(total);
    let (mut seen, mut covered) = (0, 0);
    while seen < total && covered < most {
        let chunk = CHUNK.min(total - seen);
        let visit = |i: usize| {
            let place = ((i as u128 * step as u128) % total.max(1) as u128) as usize;
            let (map, texel) = (place / per_map, (place % per_map) as u32);
            let ((light, face), view) = &places[map];
            (map, texel_truth(casters, scene, (*light, *face, map), view, texel))
        };
        let found: Vec<_> = (seen..seen + chunk).into_par_iter().map(visit).collect();
        for (map, texel) in found {
            if covered == most {
                break;
            }
            seen += 1;
            let Some(texel) = texel else { continue };
            covered += 1;
            let truth = &mut truths[map];
            truth.texels.push(texel.texel);
            truth.points.extend(texel.points);
            truth.visibility.extend(texel.visibility);
            truth.segments += texel.segments;
        }
    }
    (truths, if seen == total { 1.0 } else { seen as f64 / total as f64 })
}

/// Returns a step of about 0.618 (the inverse golden ratio) times `total` and coprime to it, so that its multiples visit every index once.
fn lattice_step(total: usize) -> usize {
    const GOLDEN: f64 = 0.618_033_988_749_894_9;
    let divides = |mut a: usize, mut b: usize| {
        while b > 0 {
            (a, b) = (b, a % b);
        }
        a > 1
    };
    let mut step = ((total as f64 * GOLDEN) as usize).max(1);
    while divides(step, total) {
        step += 1;
    }
    step
}

/// The truth at one texel.
struct TexelTruth {
    texel: u32,
    points: Vec<[f32; 3]>,
    visibility: Vec<f64>,
    segments: u64,
}

/// Returns the truth on the ray through a texel's centre, at [`MAP_DEPTHS`] depths as far as the light reaches. `None` if no caster covers
/// the texel, if look-ups use another face there, or if the light ends before the range starts.
fn texel_truth(
    casters: &Casters,
    scene: &Scene,
    (light, face, map): (usize, usize, usize),
    view: &View,
    texel: u32,
) -> Option<TexelTruth> {
    // At the light's own position any face may be used.
    let asked_for = |p: &[f32; 3]| *p == view.origin || scene.lights[light].map_at(*p) == face;
    let (x, y) = (texel % view.width, texel / view.width);
    let ray = view.ray(DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5));
    let end = end_depth(&scene.lights[light], view, &ray);
    if end <= 0.0 {
        return None;
    }
    let depth = |k: u32| end * f64::from(k) / f64::from(MAP_DEPTHS - 1);
    let position = |k: u32| ray.at(view.z(depth(k)));
    if !(0..MAP_DEPTHS).all(|k| asked_for(&position(k).as_vec3().into())) {
        return None;
    }
    let (curve, segments) = casters.true_curve(map, view, &ray);
    if segments == 0 && !scene.has_only_meshes() {
        return None;
    }
    let mut truth = TexelTruth { texel, points: vec![], visibility: vec![], segments: segments.into() };
    for k in 0..MAP_DEPTHS {
        let unblocked = scene.meshes.is_empty() || casters.unblocked(light, position(k));
        truth.points.push(position(k).as_vec3().into());
        truth.visibility.push(if unblocked { curve.transmittance(depth(k)) } else { 0.0 });
    }
    Some(truth)
}

/// Returns the depth along a ray at which the light ends, or 1 if it does not end within the view's range.
fn end_depth(light: &Light, view: &View, ray: &Ray) -> f64 {
    // Ends slightly before the radius, by about the rounding error of an f32, since the light is 0 at the radius.
    let reach = light.position().map_or(f64::INFINITY, |_| light.radius * (1.0 - 1e-6));
    view.depth(reach / ray.direction.length()).min(1.0)
}

/// Returns the exact curve at a texel's centre.
pub(super) fn texel_curve(casters: &Casters, map: usize, view: &View, texel: u32) -> TrueCurve {
    let (x, y) = (texel % view.width, texel / view.width);
    casters.true_curve(map, view, &view.ray(DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5))).0
}

/// Returns the low and high corners of the box around all translucent casters, or around the meshes if the scene has only meshes; `None` if
/// the scene is empty.
pub fn bounds(scene: &Scene) -> Option<[DVec3; 2]> {
    let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    let mut include = |p: [f32; 3], radius: f64| {
        let p = DVec3::from(p.map(f64::from));
        low = low.min(p - radius);
        high = high.max(p + radius);
    };
    if scene.has_only_meshes() {
        scene.meshes.iter().flat_map(|m| &m.positions).for_each(|p| include(*p, 0.0));
    } else {
        scene.particles.iter().for_each(|p| include(p.position, p.radius.into()));
        scene.strands.iter().for_each(|s| {
            include(s.start, s.radius.into());
            include(s.end, s.radius.into());
        });
        scene.splats.iter().for_each(|g| include(g.position, Caster::from(g).radius.into()));
        scene.volumes.iter().flat_map(|v| v.cells()).for_each(|cell| include(cell.position, cell.radius.into()));
        let glass = scene.meshes.iter().filter(|mesh| mesh.is_see_through());
        glass.flat_map(|mesh| &mesh.positions).for_each(|p| include(*p, 0.0));
    }
    (low.x <= high.x).then_some([low, high])
}

/// Returns the first `count` points of a low-discrepancy sequence within [`bounds`] on which light `light` shines. Every run gives the same
/// result.
pub fn space_points(scene: &Scene, light: usize, count: usize) -> Vec<[f32; 3]> {
    bounds(scene).map_or_else(Vec::new, |bounds| points_within(bounds, &scene.lights[light], count))
}

/// Like [`space_points`], but within the given bounds.
pub fn points_within(bounds: [DVec3; 2], light: &Light, count: usize) -> Vec<[f32; 3]> {
    points_where(about(bounds, light), count, |position| light.shines_on(position))
}

/// Like [`points_within`], but without points inside a closed mesh ([`Casters::inside`]).
pub fn points_outside(casters: &Casters, bounds: [DVec3; 2], light: usize, count: usize) -> Vec<[f32; 3]> {
    let shines_on = |position| casters.scene.lights[light].shines_on(position);
    // Tested at the position rounded to f32, as the point will be.
    let outside = |position: DVec3| !casters.inside(light, position.as_vec3().as_dvec3());
    let bounds = about(bounds, &casters.scene.lights[light]);
    points_where(bounds, count, |position| shines_on(position) && outside(position))
}

/// Returns the part of the bounds that a light of limited reach covers: their intersection with the box around its sphere. Returns the
/// bounds themselves if that is empty or if the light has no position.
fn about([low, high]: [DVec3; 2], light: &Light) -> [DVec3; 2] {
    let Some(position) = light.position() else { return [low, high] };
    let (from, to) = (low.max(position - light.radius), high.min(position + light.radius));
    if from.cmple(to).all() { [from, to] } else { [low, high] }
}

fn points_where([low, high]: [DVec3; 2], count: usize, wanted: impl Fn(DVec3) -> bool + Sync) -> Vec<[f32; 3]> {
    first(count, |i| {
        let position = low + DVec3::from(r3(i)) * (high - low);
        wanted(position).then(|| position.as_vec3().into())
    })
}

/// Returns element i of Roberts' low-discrepancy sequence R3, from multiples of the powers of 1/x, where x is the positive root of x⁴ = x +
/// 1.
pub(super) fn r3(i: usize) -> [f64; 3] {
    const ROOT: f64 = 1.220_744_084_605_759_5;
    [1.0 / ROOT, 1.0 / (ROOT * ROOT), 1.0 / (ROOT * ROOT * ROOT)].map(|step| (0.5 + step * (i as f64)).fract())
}

/// Returns the first `count` values that `place` yields for 0, 1, 2, …, in order. Gives up after 64 · `count` tries, since `place` may
/// never yield a value, and returns those found so far.
pub(super) fn first<T: Send>(count: usize, place: impl Fn(usize) -> Option<T> + Sync) -> Vec<T> {
    let mut found = Vec::with_capacity(count);
    let (mut next, end) = (0, count.saturating_mul(64));
    while found.len() < count && next < end {
        let chunk = (count - found.len()).max(1024).min(end - next);
        found.par_extend((next..next + chunk).into_par_iter().filter_map(&place));
        next += chunk;
    }
    found.truncate(count);
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::tests::{cube, inside_out, on_the_axis};
    use crate::scene::{LightKind, Mesh};

    /// Points in a box of side 2, under a light shining straight down, avoid the inside of a cube, and later the space under a solid
    /// ground.
    #[test]
    fn nobody_asks_inside() {
        let bounds = [DVec3::ZERO, DVec3::splat(2.0)];
        let mut scene = on_the_axis(&[]);
        let all = |scene: &Scene, count| points_outside(&Casters::new(scene), bounds, 0, count);
        let plain = points_within(bounds, &scene.lights[0], 4000);
        assert_eq!(all(&scene, 4000), plain, "where nothing is closed none are left out");
        let inside = |p: &[f32; 3]| p.iter().all(|c| *c < 1.0);
        for cube in [cube([0.0; 3], 1.0), inside_out(cube([0.0; 3], 1.0))] {
            scene.meshes = vec![cube];
            // As many points as before, from the same sequence, leaving out those inside.
            let more = points_within(bounds, &scene.lights[0], 8000);
            let expected: Vec<_> = more.into_iter().filter(|p| !inside(p)).take(4000).collect();
            assert_eq!(all(&scene, 4000), expected);
            assert_ne!(expected, plain);
        }
        // With the lamp inside the cube too, no point counts as inside.
        scene.lights[0].kind = LightKind::Point { position: DVec3::splat(0.5) };
        assert_eq!(all(&scene, 4000), plain);
        // If everything is inside, there are no points.
        scene.meshes = vec![cube([-1.0; 3], 4.0)];
        scene.lights[0].kind = LightKind::Directional { direction: DVec3::NEG_Z };
        assert_eq!(all(&scene, 100), [[0.0; 3]; 0]);
        let ground: Mesh = Mesh {
            solid: true,
            ..crate::scene::tests::mesh(
                vec![[-9.0, -9.0, 1.0], [9.0, -9.0, 1.0], [9.0, 9.0, 1.0], [-9.0, 9.0, 1.0]],
                vec![[0, 1, 2], [0, 2, 3]],
            )
        };
        scene.meshes = vec![ground];
        let above = all(&scene, 4000);
        assert!(above.len() == 4000 && above.iter().all(|p| p[2] >= 1.0));
    }

    /// Under a lamp of limited reach, points in space lie within its reach, and the requested number is found even if the reach is a small
    /// part of the bounds. A map's points run from the start of the map's range to the lamp's reach. There are none if the lamp ends before
    /// that range starts.
    #[test]
    fn nobody_asks_beyond_a_light() {
        let mut scene = on_the_axis(&[]);
        let position = DVec3::new(3.0, -2.0, 1.0);
        scene.lights[0].kind = LightKind::Point { position };
        scene.lights[0].radius = 0.5;
        let far = |p: &[f32; 3]| (DVec3::from(p.map(f64::from)) - position).length();
        let bounds = [DVec3::splat(-10.0), DVec3::splat(10.0)];
        let within = points_within(bounds, &scene.lights[0], 4000);
        assert!(within.len() == 4000 && within.iter().all(|p| far(p) < 0.5 + 1e-6));
        assert_eq!(points_within([DVec3::splat(5.0), DVec3::splat(9.0)], &scene.lights[0], 4000), [[0.0; 3]; 0]);

        // A ground below the lamp, within the lamp's radius of 0.5 and beyond it.
        for (below, reached) in [(0.125, true), (0.75, false)] {
            scene.meshes = vec![cube([0.0, -5.0, 1.0 - below - 6.0], 6.0)];
            let casters = Casters::new(&scene);
            let views = View::volumes(&scene, 16);
            let truths = map_truths(&casters, &scene, &views);
            let down = truths.iter().zip(&views).find(|(_, view)| view.forward[2] < -0.9).expect("a face looks down").0;
            assert_eq!(down.points.is_empty(), !reached, "{below}");
            let farthest = down.points.iter().map(far).fold(0.0, f64::max);
            assert!(!reached || (0.4999..0.5).contains(&farthest), "{farthest}");
            assert_eq!(down.points.len(), down.texels.len() * MAP_DEPTHS as usize);
            assert!(truths.iter().flat_map(|truth| &truth.points).all(|p| far(p) < 0.5));
        }
    }

    #[test]
    fn a_lattice_visits_every_place_once() {
        for total in [1, 2, 3, 64, 97, 360, 4096, 6 * 24 * 24] {
            let step = lattice_step(total);
            let mut seen: Vec<usize> = (0..total).map(|i| i * step % total).collect();
            seen.sort_unstable();
            assert!(seen.into_iter().eq(0..total), "{total}");
        }
    }

    /// A sample's texels are a subset of all texels, and are the first texels of any larger sample.
    #[test]
    fn samples_are_parts_of_the_whole() {
        let scene = crate::scene::tests::on_the_axis(&[(0.0, 0.5, 1.0), (1.0, 0.25, 2.0)]);
        let casters = Casters::new(&scene);
        let views = View::volumes(&scene, 32);
        let all = map_truths(&casters, &scene, &views).remove(0);
        let sample = |most| {
            let (mut truths, share) = sample_maps(&casters, &scene, &views, most);
            (truths.remove(0), share)
        };
        let ((small, few), (large, more)) = (sample(50), sample(100));
        assert!(all.texels.len() > 200 && few < more && more < 1.0, "{few}, {more} of {}", all.texels.len());
        assert_eq!((small.texels.len(), large.texels.len()), (50, 100));
        assert_eq!(small.texels[..], large.texels[..50]);
        let depths = MAP_DEPTHS as usize;
        for (i, texel) in large.texels.iter().enumerate() {
            let place = all.texels.iter().position(|t| t == texel).expect("covered");
            assert_eq!(large.points[i * depths..][..depths], all.points[place * depths..][..depths]);
            assert_eq!(large.visibility[i * depths..][..depths], all.visibility[place * depths..][..depths]);
        }
        // Half of the sphere's texels lie on each side. The sample is evenly spread, so about half of its texels lie there too.
        let left = large.texels.iter().filter(|t| **t % 32 < 16).count();
        assert!((40..=60).contains(&left), "{left} of 100");
    }
}
