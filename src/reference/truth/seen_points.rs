//! Seen points: where the light of a picture comes from, and how much of each light is sent from there to the camera.
//!
//! A point of the picture is sampled, and then a place along its camera ray by the exact transmittance towards the camera: in smoke, hair,
//! splats and volumes, or, with the remaining probability, on the mesh behind. An estimate of the light in the picture is therefore a plain
//! sum over points. Sources: Pharr, Jakob and Humphreys 2023, Physically Based Rendering, section 14.1 (distances by transmittance, colors
//! by one-sample multiple importance sampling).

use super::casters::{Casters, optical_depth};
use super::grid::Grid;
use super::picture::{albedo, lift};
use super::points::first;
use super::surface::SurfacePoint;
use super::volume::{self, Cubic};
use crate::scene::{Ray, Scene, Shape, View};
use glam::{DVec2, DVec3};

/// Luminance of linear red, green and blue: Rec. ITU-R BT.709, section 3.2.
const LUMINANCE: DVec3 = DVec3::new(0.2126, 0.7152, 0.0722);

/// Pixels per side of a cell of the grid that finds candidates.
const CELL_PIXELS: u32 = 8;

/// Number of bisection steps, enough for f64 precision.
const HALVINGS: u32 = 52;

/// A point that sends light to the camera.
#[derive(Clone, Copy, Debug)]
pub struct SeenPoint {
    /// Position in world units.
    pub position: DVec3,
    /// What the point lies on.
    pub on: SeenOn,
    /// Share of each color of arriving light that goes to the camera: the albedo, times the sampling weight of this place.
    pub reflects: DVec3,
    /// A number in [0, 1) that selects one of many lights.
    lot: f64,
}

/// What a seen point lies on.
#[derive(Clone, Copy, Debug)]
pub enum SeenOn {
    /// A mesh.
    Surface(SurfacePoint),
    /// A sphere, strand or splat, by its index.
    Caster(u32),
    /// A volume, by its index.
    Volume(u32),
}

/// A query of one light at a seen point.
#[derive(Clone, Copy, Debug)]
pub struct SeenQuery {
    /// Index of the point in the list of points.
    pub point: u32,
    /// Index among the scene's lights.
    pub light: usize,
    /// Position at which the light is queried, in world units.
    pub position: DVec3,
    /// As in [`SurfacePoint::asked`]; `None` in smoke, hair and volumes, which have no side.
    pub normal: Option<[f32; 3]>,
    /// Luminance of each color that the light would send from here to the camera if nothing were in between.
    pub weight: DVec3,
}

/// Returns at most `count` seen points of `camera`'s picture, fewer if hardly anything is seen. `seed` shifts the low-discrepancy sequence;
/// the same seed gives the same points.
pub fn seen_points(casters: &Casters, scene: &Scene, camera: &View, count: usize, seed: u64) -> Vec<SeenPoint> {
    let cells =
        View { width: camera.width.div_ceil(CELL_PIXELS), height: camera.height.div_ceil(CELL_PIXELS), ..*camera };
    let size = DVec2::new(camera.width.into(), camera.height.into());
    let share = DVec2::new(cells.width.into(), cells.height.into()) / size;
    // Only pictures use the cells of volumes.
    let order: Vec<u32> = (0..(casters.all.len() - scene.cell_count()) as u32).collect();
    let grid = Grid::new(&cells, &casters.all, &order);
    let shift = shift(seed);
    first(count, |i| {
        let [x, y, depth, color, owner, lot] = r6(i, shift);
        let pixel = DVec2::new(x, y) * size;
        let ray = camera.ray(pixel);
        seen_along(casters, scene, camera, &ray, grid.at(pixel * share), [depth, color, owner])
            .map(|point| SeenPoint { lot, ..point })
    })
}

/// Returns the queries of lights at seen points. With at most `most` lights, every light that shines on a point is queried; with more
/// lights, one is chosen by the light it would send to the camera.
pub fn seen_queries(casters: &Casters, scene: &Scene, points: &[SeenPoint], most: usize) -> Vec<SeenQuery> {
    use rayon::prelude::*;
    let of = |(place, point): (usize, &SeenPoint)| {
        let weigh = |(light, _)| {
            let query = query(casters, scene, place as u32, point, light);
            (query.weight.element_sum() > 0.0).then_some(query)
        };
        let all: Vec<SeenQuery> = scene.lights.iter().enumerate().filter_map(weigh).collect();
        if scene.lights.len() <= most { all } else { chosen(&all, point.lot).into_iter().collect() }
    };
    points.par_iter().enumerate().flat_map_iter(of).collect()
}

/// Chooses one of the queries with a probability proportional to its weight; it then represents all of them.
fn chosen(all: &[SeenQuery], lot: f64) -> Option<SeenQuery> {
    let weight = |query: &SeenQuery| query.weight.element_sum();
    let total: f64 = all.iter().map(weight).sum();
    let mut left = lot * total;
    let query = all.iter().find(|query| {
        left -= weight(query);
        left < 0.0
    });
    query.or(all.last()).map(|query| SeenQuery { weight: query.weight * (total / weight(query)), ..*query })
}

fn query(casters: &Casters, scene: &Scene, place: u32, point: &SeenPoint, light: usize) -> SeenQuery {
    let shining = &scene.lights[light];
    let towards = shining.towards(point.position);
    let (position, normal, turned) = match point.on {
        SeenOn::Surface(surface) => (point.position, Some(surface.asked(shining)), surface.normal.dot(towards).abs()),
        SeenOn::Volume(_) => (point.position, None, 1.0),
        SeenOn::Caster(number) => {
            let caster = &casters.all[number as usize];
            let normal = caster.is_splat().then(|| {
                let axis = Shape::of(caster).axes[2];
                (if axis.dot(towards) < 0.0 { -axis } else { axis }).as_vec3().into()
            });
            (point.position + lift(caster, towards) * towards, normal, 1.0)
        }
    };
    let sent = if shining.shines_on(point.position) { shining.falloff(point.position) * turned } else { 0.0 };
    let weight = LUMINANCE * point.reflects * DVec3::from(shining.radiance.map(f64::from)) * sent;
    SeenQuery { point: place, light, position, normal, weight }
}

/// Returns the place along a camera ray selected by three numbers in [0, 1): the first by transmittance, the second by color, the third
/// among casters at the same place. `None` if the sky is seen.
fn seen_along(
    casters: &Casters,
    scene: &Scene,
    camera: &View,
    ray: &Ray,
    candidates: &[u32],
    [depth, color, owner]: [f64; 3],
) -> Option<SeenPoint> {
    let (near, far) = (f64::from(camera.near), f64::from(camera.far));
    let hit = casters.meshes.hit(ray.origin, ray.direction).filter(|hit| hit.distance < far);
    let pieces = pieces(casters, scene, ray, candidates, (near, hit.map_or(far, |hit| hit.distance)));
    let color = ((3.0 * color) as usize).min(2);
    let wanted = -(1.0 - depth).ln();
    // Remaining light of each color, relative to the mean over the three colors.
    let share = |left: DVec3| left / (left.element_sum() / 3.0);
    let Some((z, piece, left)) = pick(&pieces, wanted, color, owner) else {
        let hit = hit?;
        let left = (-pieces.iter().map(|piece| piece.ratio * piece.depth).sum::<DVec3>()).exp();
        let surface = SurfacePoint { position: ray.at(hit.distance), normal: hit.normal, closed: hit.closed };
        let reflects = DVec3::from(hit.albedo.map(f64::from)) * share(left);
        return Some(SeenPoint { position: surface.position, on: SeenOn::Surface(surface), reflects, lot: 0.0 });
    };
    let albedo = match piece.on {
        SeenOn::Caster(number) => albedo(scene, number as usize, &casters.all[number as usize]),
        SeenOn::Volume(number) => DVec3::from(scene.volumes[number as usize].placed().color.map(f64::from)),
        SeenOn::Surface(_) => DVec3::ONE,
    };
    Some(SeenPoint { position: ray.at(z), on: piece.on, reflects: albedo * share(left), lot: 0.0 })
}

/// A segment of a camera ray in one caster, or in one cell of a volume.
struct Piece<'a> {
    entry: f64,
    exit: f64,
    /// Optical depth of the whole segment, at an extinction ratio of 1.
    depth: f64,
    /// Extinctions of red, green and blue light, as multiples of the scalar extinction.
    ratio: DVec3,
    on: SeenOn,
    /// How optical depth rises along the segment.
    rise: Rise<'a>,
}

enum Rise<'a> {
    /// All at once, at the entry.
    Step,
    /// As in a sphere or splat.
    Caster(&'a Ray, &'a crate::scene::Caster),
    Cell(Cubic),
}

impl Piece<'_> {
    /// Returns the optical depth up to `z`, at an extinction ratio of 1.
    fn depth_to(&self, z: f64) -> f64 {
        if z >= self.exit {
            return self.depth;
        }
        if z < self.entry {
            return 0.0;
        }
        match &self.rise {
            Rise::Step => self.depth,
            Rise::Caster(ray, caster) => optical_depth(ray, caster, self.entry, z),
            Rise::Cell(cubic) => cubic.optical_depth(z) - cubic.before,
        }
    }

    fn is_step(&self) -> bool {
        matches!(self.rise, Rise::Step)
    }
}

/// Returns all segments of a ray in casters and volumes, between two values of z.
fn pieces<'a>(
    casters: &'a Casters,
    scene: &Scene,
    ray: &'a Ray,
    candidates: &[u32],
    (near, far): (f64, f64),
) -> Vec<Piece<'a>> {
    let of_caster = |&number: &u32| {
        let caster = &casters.all[number as usize];
        let (entry, exit) = casters.overlap(ray, number)?;
        let (entry, exit) = (entry.max(near), exit.min(far));
        if exit < entry {
            return None;
        }
        let rise = if exit > entry { Rise::Caster(ray, caster) } else { Rise::Step };
        let depth = casters.depth_within(ray, number, entry, exit);
        let (ratio, on) = (casters.ratio_of(number), SeenOn::Caster(number));
        (depth > 0.0).then_some(Piece { entry, exit, depth, ratio, on, rise })
    };
    let mut pieces: Vec<Piece> = candidates.iter().filter_map(of_caster).collect();
    for (number, field) in (0..).zip(&scene.volumes) {
        let (ratio, on) = (casters.ratio_of_volume(number), SeenOn::Volume(number));
        for cubic in volume::curve(field, ray, near, |z| z).into_iter().filter(|cubic| cubic.entry < far) {
            let (entry, exit) = (cubic.entry, cubic.exit.min(far));
            let depth = cubic.optical_depth(exit) - cubic.before;
            if depth > 0.0 {
                pieces.push(Piece { entry, exit, depth, ratio, on, rise: Rise::Cell(cubic) });
            }
        }
    }
    pieces
}

/// Finds where the optical depth of a color reaches `wanted`: the z, the piece that absorbs the light there, and how much of each color it
/// absorbs, up to a factor. `None` if it is never reached.
fn pick<'p, 'a>(pieces: &'p [Piece<'a>], wanted: f64, color: usize, owner: f64) -> Option<(f64, &'p Piece<'a>, DVec3)> {
    let total = |z: f64| pieces.iter().map(|piece| piece.ratio[color] * piece.depth_to(z)).sum::<f64>();
    let mut ends: Vec<f64> = pieces.iter().flat_map(|piece| [piece.entry, piece.exit]).collect();
    ends.sort_unstable_by(f64::total_cmp);
    let k = ends.partition_point(|z| total(*z) < wanted);
    let (high, low) = (*ends.get(k)?, ends[k.saturating_sub(1)]);
    let depths = |z: f64| pieces.iter().map(|piece| piece.ratio * piece.depth_to(z)).sum::<DVec3>();
    let steps = || pieces.iter().filter(|piece| piece.is_step() && piece.entry == high);
    let jump: DVec3 = steps().map(|piece| piece.ratio * piece.depth).sum();
    let mut before = depths(high) - jump;
    if before[color] < wanted {
        // The last piece absorbs what rounding leaves over.
        let mut left = steps().count();
        for piece in steps() {
            let own = piece.ratio * piece.depth;
            left -= 1;
            if left == 0 || before[color] + own[color] >= wanted {
                return Some((high, piece, (-before).exp() * (1.0 - (-own).exp())));
            }
            before += own;
        }
    }
    let active: Vec<&Piece> = pieces.iter().filter(|p| !p.is_step() && p.entry < high && p.exit > low).collect();
    let rises = |z: f64| active.iter().map(|piece| piece.ratio[color] * piece.depth_to(z)).sum::<f64>();
    let others = total(low) - rises(low);
    let (mut from, mut to) = (low, high);
    for _ in 0..HALVINGS {
        let middle = 0.5 * (from + to);
        *(if others + rises(middle) < wanted { &mut from } else { &mut to }) = middle;
    }
    let z = 0.5 * (from + to);
    let reach = 1e-3 * (high - low);
    let (before, behind) = ((z - reach).max(low), (z + reach).min(high));
    let density = |piece: &Piece| piece.ratio[color] * (piece.depth_to(behind) - piece.depth_to(before));
    let mut left = owner * active.iter().map(|piece| density(piece)).sum::<f64>();
    let found = active.iter().find(|piece| {
        left -= density(piece);
        left < 0.0
    });
    found.or(active.last()).map(|piece| (z, *piece, (-depths(z)).exp() * piece.ratio))
}

/// Returns the `i`-th point of the R6 sequence (Roberts 2018, The Unreasonable Effectiveness of Quasirandom Sequences), shifted.
fn r6(i: usize, shift: [f64; 6]) -> [f64; 6] {
    /// The root of x⁷ = x + 1.
    const ROOT: f64 = 1.112_775_684_278_705_5;
    let mut step = 1.0;
    shift.map(|shift| {
        step /= ROOT;
        (shift + step * (i as f64)).fract()
    })
}

/// Returns a shift for each coordinate, derived from a seed (Cranley and Patterson 1976). Random numbers by SplitMix64 (Steele, Lea and
/// Flood 2014).
fn shift(seed: u64) -> [f64; 6] {
    let mut state = seed;
    [0; 6].map(|_| {
        state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = state;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::tests::{mesh, on_the_axis};
    use crate::scene::{Camera, Splat, Strand};

    /// Looks straight down from z = 10 through a window so narrow that every ray runs along the axis.
    fn along_the_axis(scene: &Scene) -> View {
        let position = DVec3::new(0.0, 0.0, 10.0);
        let camera = Camera { position, target: DVec3::ZERO, up: DVec3::Y, fov_y_degrees: 0.001 };
        View::camera(&camera, scene, [64, 64])
    }

    fn with_wall(mut scene: Scene) -> Scene {
        let corners = vec![[-9.0, -9.0, -3.0], [9.0, -9.0, -3.0], [9.0, 9.0, -3.0], [-9.0, 9.0, -3.0]];
        scene.meshes = vec![mesh(corners, vec![[0, 1, 2], [0, 2, 3]])];
        scene
    }

    /// Returns the mean weight per point of a picture without sky, for each color, and the share of points on casters.
    fn sent(scene: &Scene, count: usize) -> (DVec3, f64) {
        let casters = Casters::new(scene);
        let points = seen_points(&casters, scene, &along_the_axis(scene), count, 1);
        assert_eq!(points.len(), count);
        let weight: DVec3 = seen_queries(&casters, scene, &points, 8).iter().map(|query| query.weight).sum();
        let on_casters = points.iter().filter(|point| !matches!(point.on, SeenOn::Surface(_))).count();
        (weight / count as f64, on_casters as f64 / count as f64)
    }

    /// Returns the total light sent by a caster with this albedo and optical depth and by the wall of albedo ½ behind it.
    fn expected(albedo: DVec3, depth: DVec3) -> DVec3 {
        let left = (-depth).exp();
        LUMINANCE * (albedo * (1.0 - left) + 0.5 * left)
    }

    fn near(found: DVec3, expected: DVec3, what: &str) {
        let apart = ((found - expected) / expected).abs().max_element();
        assert!(apart < 2e-3, "{what}: {found}, not {expected}");
    }

    /// Each kind of caster in front of a wall sends the light that its optical depth absorbs, and the wall sends the rest.
    #[test]
    fn weights_are_what_the_camera_gets() {
        const SMOKE: DVec3 = DVec3::new(0.92, 0.92, 0.95);
        let sphere = with_wall(on_the_axis(&[(0.0, 1.0, 0.6)]));
        let (weight, share) = sent(&sphere, 8192);
        near(weight, expected(SMOKE, DVec3::splat(1.2)), "a sphere");
        assert!((share - (1.0 - (-1.2f64).exp())).abs() < 2e-3, "{share}");

        // Two overlapping spheres that absorb the colors in different ratios: the result is the same as if each color were sampled alone.
        let mut colored = with_wall(on_the_axis(&[(0.0, 1.0, 0.3), (0.5, 1.0, 0.3)]));
        colored.extinction_ratio = [1.0, 0.25, 3.0];
        near(sent(&colored, 32768).0, expected(SMOKE, 1.2 * DVec3::new(1.0, 0.25, 3.0)), "colored smoke");

        let mut hair = with_wall(on_the_axis(&[]));
        let strand = |z: f32| Strand { start: [-1.0, 0.0, z], end: [1.0, 0.0, z], radius: 0.5, opacity: 0.5 };
        hair.strands = vec![strand(0.0), strand(1.0), strand(0.0)];
        let depth = DVec3::splat(8.0f64.ln());
        near(sent(&hair, 8192).0, expected(DVec3::new(0.70, 0.42, 0.20), depth), "three strands, two at one place");

        let mut splats = with_wall(on_the_axis(&[]));
        splats.splats = vec![Splat {
            position: [0.0; 3],
            deviations: [0.5; 3],
            rotation: [0.0, 0.0, 0.0, 1.0],
            opacity: 0.75,
            color: [0.2, 0.4, 0.8],
        }];
        let depth = DVec3::splat(4.0f64.ln());
        near(sent(&splats, 8192).0, expected(DVec3::new(0.2, 0.4, 0.8), depth), "a splat");
    }

    /// Places in smoke are sampled by transmittance: half of them lie where half of the light has come from.
    #[test]
    fn places_are_where_light_comes_from() {
        let scene = on_the_axis(&[(0.0, 1.0, 2.0)]);
        let casters = Casters::new(&scene);
        let points = seen_points(&casters, &scene, &along_the_axis(&scene), 4096, 0);
        let mut z: Vec<f64> = points.iter().map(|point| point.position.z).collect();
        z.sort_unstable_by(f64::total_cmp);
        for share in [0.1, 0.5, 0.9] {
            // The sphere absorbs 1 − exp(−4) of the light.
            let taken = share * (1.0 - (-4.0f64).exp());
            let expected = 1.0 + (1.0 - taken).ln() / 2.0;
            let found = z[((1.0 - share) * z.len() as f64) as usize];
            assert!((found - expected).abs() < 5e-3, "{found}, not {expected}");
        }
    }

    /// With many lights, each point queries only one. Lights are chosen in proportion to the light they send, and each query carries the
    /// weight of all lights together.
    #[test]
    fn one_of_many_lights_stands_for_all() {
        let mut scene = with_wall(on_the_axis(&[]));
        let light = scene.lights[0];
        scene.lights = (0..10).map(|i| crate::scene::Light { radiance: [i as f32; 3], ..light }).collect();
        let casters = Casters::new(&scene);
        let points = seen_points(&casters, &scene, &along_the_axis(&scene), 9000, 0);
        let queries = seen_queries(&casters, &scene, &points, 8);
        assert_eq!(queries.len(), 9000);
        for query in &queries {
            near(query.weight, 45.0 * 0.5 * LUMINANCE, "all lights");
        }
        for i in 0..10 {
            let count = queries.iter().filter(|query| query.light == i).count();
            assert!(count.abs_diff(200 * i) < 30, "light {i}: {count}");
        }
    }
}
