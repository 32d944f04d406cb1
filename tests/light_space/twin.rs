//! The CPU twins' view of a scene: each texel's curve, and whether rounding alone could produce another one.

mod grazed;

use crate::support::scenes::{self, Random};
use crate::support::{gpu_test, views};
use glam::DVec2;
use gobo::reference::twin::area::{CellLight, Taken, texel_part, texel_taken};
use gobo::reference::twin::avsm::cells::Cells;
use gobo::reference::twin::avsm::curve::{Build, Curve};
use gobo::reference::twin::avsm::node::Interpolation;
use gobo::reference::twin::bins::{TILE_TEXELS, caster_order, tile_key_within};
use gobo::reference::twin::order;
use gobo::reference::twin::segment::{MAX_OPTICAL_DEPTH, Segment, sort, texel_segment};
use gobo::reference::twin::sums::{DARK, bound};
use gobo::scene::{Caster, Scene, View};
use gobo::technique::avsm::{self, BuildPath, Fit, Interpolated, Resolve};
use gobo::technique::{NodeData, Spec};
use std::hash::{DefaultHasher, Hash, Hasher};

/// Depths at which curves are compared, 0 to 1.
pub const DEPTHS: usize = 65;

/// Largest difference between two f32 computations of the same depth: some tens of roundings of numbers up to 1.
pub const DEPTH_ROUNDING: f32 = 1e-5;

/// Transmittances that differ by more than this under rounding alone make a texel ambiguous.
const UNSTABLE: f32 = 1e-4;

/// Returns the tolerance within which two removal costs (areas, for a range of 1) are tied. A cost is a small difference of larger areas.
/// With optical depths, it is computed from three areas of up to a few tenths, each with a few rounding errors, including that of `exp`,
/// for which Vulkan allows 3 ulp; with transmittances, from two products, each rounded once.
fn tie(interpolation: Interpolation) -> f32 {
    match interpolation {
        Interpolation::Linear => 1e-8,
        Interpolation::Exponential => 1e-7,
    }
}

/// [`Curve::margin`] is the difference of two removal costs divided by the larger cost, or by this if the larger cost is smaller.
const MARGIN_FLOOR: f32 = 1e-5;

/// How far a trial moves depths (in the light's range), relative to the share of the light that the texel absorbs; it is also the largest
/// relative change of optical depths. Its standard deviation is at least five times that of the rounding errors of depths in any texel
/// (checked below). Both accumulate in the same way, so a quantity that decides a choice varies five times as much between trials as
/// between devices. If a device, at most three of its standard deviations away, chooses differently, a trial does so too with a probability
/// of at least 1 − Φ(3/5) = 0.27.
const MOVED: f32 = 6e-6;

/// Upper bound on how far a trial moves depths.
const MOVED_AT_MOST: f32 = 2.5e-4;

/// Number of trials. All of them miss such a choice in 0.73²⁴, i.e. one in 2,000 cases.
const TRIALS: u64 = 24;

/// The order in which segments meet the curve.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Order {
    /// Two-pass, order=sorted: by entry depth in each texel, ties by exit, optical depth and index.
    Entry,
    /// Interlock and raster order, order=captured: by particle index.
    Index,
    /// Interlock and raster order, order=sorted: particles by nearest depth.
    Near,
    /// Binned: particles by nearest depth within the texel's tile of 8×8, ties by index.
    Tile,
    /// Binned, resolve=cells: sums, for which order does not matter.
    Cells,
}

/// A texel's segments in the order of insertion, from which its curves are built.
pub struct Texel {
    pub segments: Vec<Segment>,
    /// The segments as rounded differently, trial by trial.
    rounded: Vec<Vec<Segment>>,
    /// Distance by which the trials moved depths.
    moved: f32,
    /// Bound of the texel's tile, if curves are built from sums in cells.
    bound: Option<u64>,
    /// Copies of a particle, and spheres around the light, which all begin at the near plane, produce pairs of nodes of which either can be
    /// removed at no cost: their margin is 0 and means nothing.
    has_pairs: bool,
}

impl Texel {
    /// Returns the curve, and whether rounding alone may change it, because two removals cost nearly the same or two entries lie at nearly
    /// the same depth: then there is no single right answer.
    pub fn curve(&self, build: Build) -> (Curve, bool) {
        let curve = curve(&self.segments, self.bound, build);
        let tied = !self.has_pairs && curve.margin < tie(build.interpolation) / MARGIN_FLOOR;
        let differs = |other: Curve| {
            (0..DEPTHS).any(|i| beyond(&curve, depth(i), other.transmittance(depth(i)), self.moved) > UNSTABLE)
        };
        let another = |rounded: &Vec<Segment>| differs(self::curve(rounded, self.bound, build));
        let ambiguous = tied || self.has_other_ends(build) || self.rounded.iter().any(another);
        (curve, ambiguous)
    }

    /// Returns the mean distance of a curve from the exact transmittance of all segments.
    fn off(&self, found: impl Fn(f32) -> f32) -> f32 {
        let part = |s: &Segment, depth: f32| match s.exit - s.entry {
            length if length > 0.0 => ((depth - s.entry) / length).clamp(0.0, 1.0),
            _ => f32::from(depth >= s.entry),
        };
        let whole = |depth| (-self.segments.iter().map(|s| s.optical_depth * part(s, depth)).sum::<f32>()).exp();
        (0..DEPTHS).map(|i| (found(depth(i)) - whole(depth(i))).abs()).sum::<f32>() / DEPTHS as f32
    }

    fn off_with(&self, segments: &[Segment], build: Build) -> f32 {
        let curve = curve(segments, self.bound, build);
        self.off(|depth| curve.transmittance(depth))
    }

    /// Returns whether the twin's curve matches all segments exactly, up to rounding.
    pub fn is_met(&self, build: Build) -> bool {
        self.off_with(&self.segments, build) <= UNSTABLE
    }

    /// Returns whether a device's nodes are about as near to the exact transmittance as the twin's curve or the worst trial's: at most a
    /// quarter farther, in the mean.
    pub fn is_no_worse(&self, build: Build, nodes: &[NodeData]) -> bool {
        let trials = self.rounded.iter().chain([&self.segments]).map(|segments| self.off_with(segments, build));
        self.off(|depth| look_up(nodes, depth, build.interpolation)) <= 1.25 * trials.fold(0.0, f32::max) + UNSTABLE
    }

    /// Returns whether some trial builds the curve from different ends of cells.
    fn has_other_ends(&self, build: Build) -> bool {
        let Some(bound) = self.bound else { return false };
        let ends = |segments: &[Segment]| Cells::new(segments, bound).map(|cells| cells.ends(build));
        let own = ends(&self.segments);
        self.rounded.iter().any(|segments| ends(segments) != own)
    }
}

/// Looks up a curve of nodes in the light's view as glsl/technique/avsm/visibility.glsl does: between the last node at or in front of
/// `depth` and the next.
pub fn look_up(nodes: &[NodeData], depth: f32, interpolation: Interpolation) -> f32 {
    let before = nodes.iter().filter(|n| n.depth <= depth).count();
    if before == 0 {
        return 1.0;
    }
    let (near, far) = (nodes[before - 1], nodes[before.min(nodes.len() - 1)]);
    let along =
        if far.depth > near.depth { ((depth - near.depth) / (far.depth - near.depth)).clamp(0.0, 1.0) } else { 0.0 };
    let value = near.value * (1.0 - along) + far.value * along;
    match interpolation {
        Interpolation::Linear => value,
        Interpolation::Exponential => (-value).exp(),
    }
}

/// Returns the twin's build settings for `spec`.
pub fn build(spec: &Spec) -> Build {
    let settings: avsm::Settings = spec.settings();
    let nodes = settings.nodes as usize;
    Build {
        nodes,
        // Whole curves are compressed with 16 more nodes than are stored (technique::avsm, WHOLE_NODES). The binned path has room for 4
        // more (BINNED_NODES), with cells for 2 (CELLS_NODES).
        work: nodes
            + match (settings.resolve, settings.path) {
                (Some(Resolve::Whole), _) => 16,
                (Some(Resolve::Streaming), Some(BuildPath::Binned)) => 4,
                (_, Some(BuildPath::Binned)) => 2,
                _ => 0,
            },
        interpolation: match settings.curve {
            Interpolated::Transmittance => Interpolation::Linear,
            Interpolated::OpticalDepth => Interpolation::Exponential,
        },
        nudge: settings.nudge,
        // FIT_TURNS: for optical depth, from sums in cells by default, and from whole curves on request.
        turns: match (settings.curve, settings.resolve, settings.fit) {
            (Interpolated::OpticalDepth, Some(Resolve::Cells), None | Some(Fit::Refined))
            | (Interpolated::OpticalDepth, Some(Resolve::Whole), Some(Fit::Refined)) => 3,
            _ => 0,
        },
    }
}

/// Returns the twin's curve of these segments inserted in this order or, with a `bound`, from sums in cells, for which order does not
/// matter.
pub fn curve(segments: &[Segment], bound: Option<u64>, build: Build) -> Curve {
    let mut curve = Curve::new(build);
    if let Some(bound) = bound {
        return Cells::new(segments, bound).map_or(curve, |cells| cells.curve(build));
    }
    segments.iter().for_each(|s| curve.insert(*s));
    if build.turns > 0 {
        curve.reduce_refined();
    } else {
        curve.reduce();
    }
    curve
}

/// Twins of the texels of one map of a scene at one size.
pub struct Twins<'a> {
    scene: &'a Scene,
    casters: Vec<Caster>,
    pub view: View,
    /// Whether a texel represents all rays through it.
    area: bool,
    /// Position of each caster in the drawing order.
    places: Vec<u32>,
    /// Rank of each caster by its contents; identical casters share a rank.
    ranks: Vec<usize>,
}

/// A segment before any trial moves it.
struct Cut {
    caster: u32,
    /// Rank of the caster by its contents.
    rank: usize,
    /// Sort key of the caster in the texel's tile.
    key: f32,
    segment: Segment,
    /// Share absorbed in each cell of a texel that represents its area.
    taken: Taken,
}

/// Returns the segments in the order of insertion; in a trial, each is moved by up to the given distance.
fn in_order(cuts: &[Cut], order: Order, trial: Option<(f32, u64)>) -> Vec<Segment> {
    let rounded = |segment| trial.map_or(segment, |(by, trial)| rounded_otherwise(segment, by, trial));
    if order == Order::Tile {
        // Two keys may lie so close that rounding alone orders them: a trial moves them as it moves depths. In a texel of cells the first
        // of two strands absorbs the light of both, so strands with equal keys, such as consecutive ones of a polyline, are moved apart.
        let key = |cut: &Cut| {
            let apart = if trial.is_some() && cut.taken.is_some() { cut.rank as u32 % 16 } else { 0 };
            let key = f32::from_bits(cut.key.to_bits() + apart);
            rounded(Segment { entry: key, exit: key, optical_depth: 1.0 }).entry
        };
        let mut all: Vec<_> = cuts.iter().map(|c| (key(c), c.rank, c)).collect();
        all.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let mut light = CellLight::whole();
        let mut seen = |c: &Cut| Segment { optical_depth: light.seen(&c.taken, c.segment.optical_depth), ..c.segment };
        return all.into_iter().map(|(_, _, cut)| rounded(seen(cut))).collect();
    }
    let mut all: Vec<_> = cuts.iter().map(|c| (c.caster, rounded(c.segment))).collect();
    if order == Order::Entry {
        sort(&mut all);
    }
    all.into_iter().map(|(_, segment)| segment).collect()
}

impl<'a> Twins<'a> {
    /// Creates the twins of one map, with the view as the device fitted it.
    pub fn new(scene: &'a Scene, view: View) -> Self {
        let casters = scene.casters();
        let keys: Vec<u32> = order::keys(&view, &casters).into_iter().map(order::float_order).collect();
        let mut places = vec![0; casters.len()];
        (0..).zip(order::sort(&keys)).for_each(|(place, caster)| places[caster as usize] = place);
        let mut sorted: Vec<&Caster> = casters.iter().collect();
        sorted.sort_by(|a, b| caster_order(a, b));
        let ranks = casters.iter().map(|c| sorted.partition_point(|s| caster_order(s, c).is_lt())).collect();
        Self { scene, view, places, ranks, casters, area: false }
    }

    /// Switches to texel=area.
    pub fn of_area(self) -> Self {
        Self { area: true, ..self }
    }

    /// Returns the caster's sort key in the texel's tile, or `None` if it does not meet the tile.
    fn key(&self, caster: &Caster, at: [u32; 2]) -> Option<f32> {
        tile_key_within(&self.view, caster, at.map(|t| t / TILE_TEXELS), if self.area { 0.0 } else { 0.5 })
    }

    /// Returns the texel's segments in the order of their casters; for [`Order::Tile`] only those of casters in its tile.
    fn cuts(&self, texel: u32, order: Order) -> Vec<Cut> {
        let at = [texel % self.view.width, texel / self.view.width];
        let key = |caster: &Caster| match order {
            Order::Tile => self.key(caster, at),
            _ => Some(0.0),
        };
        let cut = |(i, caster): (u32, &Caster)| {
            let segment = if self.area {
                // Cells skip casters behind which no light is left.
                texel_part(&self.view, at, caster, if order == Order::Cells { DARK } else { MAX_OPTICAL_DEPTH })?
            } else {
                texel_segment(&self.view, at, caster)?
            };
            let by_cells = self.area && order == Order::Tile;
            let taken = if by_cells { texel_taken(&self.view, at, caster, MAX_OPTICAL_DEPTH) } else { None };
            Some(Cut { caster: i, rank: self.ranks[i as usize], key: key(caster)?, segment, taken })
        };
        let mut cuts: Vec<Cut> = (0..).zip(&self.casters).filter_map(cut).collect();
        if order == Order::Near {
            cuts.sort_by_key(|cut| self.places[cut.caster as usize]);
        }
        cuts
    }

    /// Returns the depths at which the texel's ray enters and leaves spheres, in f64 and as the twin computes them.
    fn ends(&self, texel: u32) -> Vec<(f64, f32)> {
        let (x, y) = (texel % self.view.width, texel / self.view.width);
        let ray = self.view.ray(DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5));
        let (near, far) = (f64::from(self.view.near), f64::from(self.view.far));
        let ends = |cut: &Cut| {
            let sphere = &self.casters[cut.caster as usize];
            let offset = sphere.start() - ray.origin;
            let middle = offset.dot(ray.direction) / ray.direction.length_squared();
            let square = f64::from(sphere.radius).powi(2) - (offset - middle * ray.direction).length_squared();
            let half = (square.max(0.0) / ray.direction.length_squared()).sqrt();
            let exact = [middle - half, middle + half].map(|z| (z.max(near) - near) / (far - near));
            [(exact[0], cut.segment.entry), (exact[1], cut.segment.exit)]
        };
        self.cuts(texel, Order::Cells).iter().flat_map(ends).collect()
    }

    /// Returns the bound of the optical depth in the texel's tile.
    fn bound(&self, texel: u32) -> u64 {
        let met = |c: &&Caster| self.key(c, [texel % self.view.width, texel / self.view.width]).is_some();
        bound(&self.casters.iter().filter(met).copied().collect::<Vec<_>>(), DARK)
    }

    pub fn texel(&self, texel: u32, order: Order) -> Texel {
        let cuts = self.cuts(texel, order);
        let segments = in_order(&cuts, order, None);
        let lost = 1.0 - (-segments.iter().map(|s| s.optical_depth).sum::<f32>()).exp();
        let moved = (MOVED / lost).min(MOVED_AT_MOST);
        let rounded = |trial| in_order(&cuts, order, Some((moved, trial)));
        Texel {
            rounded: (0..TRIALS).map(rounded).collect(),
            bound: (order == Order::Cells).then(|| self.bound(texel)),
            has_pairs: ["duplicates", "inside"].contains(&self.scene.name.as_str()),
            segments,
            moved,
        }
    }

    /// Returns the number of segments of all texels.
    pub fn fragments(&self) -> u64 {
        (0..self.view.texels() as u32).map(|texel| self.cuts(texel, Order::Index).len() as u64).sum()
    }

    /// Returns how much rounding of the spheres' positions may change the optical depth along the texel's ray: the shorter a chord, the
    /// more. A coordinate in view space is three products and their sum, and both sides of a comparison round some of these.
    pub fn chord_rounding(&self, texel: u32) -> f64 {
        let (x, y) = (texel % self.view.width, texel / self.view.width);
        let ray = self.view.ray(DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5));
        let of = |caster: &Caster| {
            let offset = caster.start() - ray.origin;
            let distance = offset.reject_from(ray.direction).length();
            let square = f64::from(caster.radius).powi(2) - distance * distance;
            let moved = 5.0 * f64::from(f32::EPSILON) * offset.length();
            let chord = |moved: f64| 2.0 * (square - 2.0 * distance * moved).max(0.0).sqrt();
            f64::from(caster.density) * (chord(-moved) - chord(moved)).max(0.0) / 2.0
        };
        self.casters.iter().filter(|caster| !caster.is_strand() && !caster.is_splat()).map(of).sum()
    }

    /// Returns how much rounding of the strands' positions may change the optical depth of a texel that represents its area. An edge
    /// displaced by a fraction of a texel's side covers that much more or less of it, along at most √2 of a side. Positions as in
    /// [`Twins::chord_rounding`].
    pub fn area_rounding(&self, texel: u32) -> f64 {
        if !self.area {
            return 0.0;
        }
        let at = [texel % self.view.width, texel / self.view.width];
        let ray = self.view.ray(DVec2::new(f64::from(at[0]) + 0.5, f64::from(at[1]) + 0.5));
        let beside = self.view.ray(DVec2::new(f64::from(at[0]) + 1.5, f64::from(at[1]) + 1.5));
        let of = |caster: &Caster| {
            let segment = texel_part(&self.view, at, caster, MAX_OPTICAL_DEPTH)?;
            let z = (caster.start() - ray.origin).dot(ray.direction) / ray.direction.length_squared();
            let diagonal = (beside.at(z) - ray.at(z)).length();
            let moved = 5.0 * f64::from(f32::EPSILON) * (caster.start() - ray.origin).length() / diagonal;
            // Two edges, each along √2 of a side, which is the diagonal over √2.
            let share = 2.0 * 2.0 * moved;
            let left = (-f64::from(segment.optical_depth)).exp();
            Some(share * (1.0 - (-f64::from(caster.density)).exp()) / left)
        };
        self.casters.iter().filter(|caster| caster.is_strand()).filter_map(of).sum()
    }
}

pub fn depth(i: usize) -> f32 {
    i as f32 / (DEPTHS - 1) as f32
}

/// Returns how far `transmittance` at `depth` lies outside the range of `curve` within `rounding` of that depth, so that a step at a
/// rounded depth is no difference. Transmittance falls with depth, so the ends of the interval give the extremes.
pub fn beyond(curve: &Curve, depth: f32, transmittance: f32, rounding: f32) -> f32 {
    let high = curve.transmittance(depth - rounding);
    let low = curve.transmittance(depth + rounding);
    (transmittance - high).max(low - transmittance)
}

/// Moves a segment's depths by up to `by`, and its optical depth by more than rounding would. Equal numbers are moved equally, so equal
/// depths stay equal.
fn rounded_otherwise(segment: Segment, by: f32, trial: u64) -> Segment {
    let moved = |number: f32, by: f32| {
        let mut hasher = DefaultHasher::new();
        (trial, number.to_bits()).hash(&mut hasher);
        Random::new(hasher.finish()).between(-by, by)
    };
    let entry = segment.entry + moved(segment.entry, by);
    Segment {
        entry,
        exit: (segment.exit + moved(segment.exit, by)).max(entry),
        optical_depth: segment.optical_depth * (1.0 + moved(segment.optical_depth, MOVED)),
    }
}

/// Returns how much packing may change a transmittance at a node: half a code, plus a little for the rounding of the code. A code is
/// 1/65,535 of T, or 1/65,536 of t / (1 + t), which changes T by at most 4/e of that.
pub fn half_code(interpolation: Interpolation) -> f64 {
    0.51 / 65535.0 * if interpolation == Interpolation::Linear { 1.0 } else { 4.0 / std::f64::consts::E }
}

/// Returns how much two adjacent codes may differ in transmittance on a ramp from full light to an optical depth of `deepest`. Past an
/// optical depth of 1 the difference peaks where 1/e is left, a share 1 / t down the ramp, and a code is (1 + t)² / 65,536 wide.
pub fn code(interpolation: Interpolation, deepest: f32) -> f32 {
    let deepest = deepest.max(1.0);
    match interpolation {
        Interpolation::Linear => 1.0 / 65535.0,
        Interpolation::Exponential => (1.0 + deepest).powi(2) / (std::f32::consts::E * deepest) / 65536.0,
    }
}

/// Asserts what holds for any curve, whatever was removed: transmittance in [0, 1], never rising with depth, and at the far end the product
/// of all segments, to within `rounding`.
pub fn check_invariants(
    what: &str,
    nodes: &[NodeData],
    segments: &[Segment],
    interpolation: Interpolation,
    rounding: f64,
) {
    assert!(nodes.iter().all(|n| n.value.is_finite() && n.depth.is_finite()), "{what}: {nodes:?}");
    assert!(nodes.windows(2).all(|n| n[0].depth <= n[1].depth), "{what}: depths fall: {nodes:?}");
    let mut last = 1.0f32;
    for i in 0..DEPTHS {
        let transmittance = look_up(nodes, depth(i), interpolation);
        assert!((0.0..=1.0).contains(&transmittance), "{what}: {transmittance} at {}: {nodes:?}", depth(i));
        assert!(transmittance <= last + 1e-6, "{what}: rises to {transmittance} at {}: {nodes:?}", depth(i));
        last = transmittance;
    }
    let product = (-segments.iter().map(|s| f64::from(s.optical_depth)).sum::<f64>()).exp();
    let tail = f64::from(look_up(nodes, 2.0, interpolation));
    assert!((tail - product).abs() <= rounding, "{what}: the tail is {tail}, the product of all segments {product}");
}

/// Checks the basis of [`MOVED`] in every texel: standard deviations of f32 depths from f64, and of the moves.
#[test]
fn trials_move_depths_five_times_as_far_as_rounding() {
    gpu_test("trials_move_depths_five_times_as_far_as_rounding", |context| {
        let [thin, many] = [[scenes::random(), scenes::nested()], [scenes::crowd(), scenes::inside()]];
        for scene in thin.iter().chain(&many) {
            let (mut worst, mut ends) = (0.0f64, 0);
            for twins in views(context, scene, 12).into_iter().map(|view| Twins::new(scene, view)) {
                for texel in 0..twins.view.texels() as u32 {
                    let square = |(exact, f32): (f64, f32)| (f64::from(f32) - exact).powi(2);
                    let squares: Vec<_> = twins.ends(texel).into_iter().map(square).collect();
                    // A uniform number from -b to b has a standard deviation of b / √3.
                    let moves = f64::from(twins.texel(texel, Order::Cells).moved) / 3f64.sqrt();
                    let rounding = (squares.iter().sum::<f64>() / squares.len().max(1) as f64).sqrt();
                    worst = worst.max(rounding / moves);
                    ends += squares.len();
                }
            }
            println!("{}: rounding is up to {worst:.3} of the moves, {ends} depths", scene.name);
            assert!(worst < 0.2 && worst > 0.0 && ends > 0, "{}: {worst} of {ends} depths", scene.name);
        }
    });
}
