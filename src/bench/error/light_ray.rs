//! Transmittance along one light ray: the truth and the answers of techniques.

use crate::gpu::Context;
use crate::maps::Map;
use crate::query::Query;
use crate::reference::truth::Casters;
use crate::scene::{Scene, View};
use crate::technique::{Opened, answers_in_space};
use crate::{Error, Result};
use glam::{DVec2, DVec3};
use std::ops::Range;

/// Pairs of (depth in the range of the light's map, transmittance), in order of depth.
pub type RayPoints = Vec<(f64, f64)>;

/// One technique's curve.
#[derive(Clone, Debug, PartialEq)]
pub struct RayLine {
    /// The technique's answers at the depths of [`LightRay::truth`].
    pub points: RayPoints,
    /// Nodes of the technique's curve. Empty for a technique without nodes, or with maps whose view of the light is not [`LightRay::view`].
    /// Nodes behind a mesh are left out, since the line ends there.
    pub nodes: RayPoints,
}

/// The ray from a light through the centre of a texel of its map.
#[derive(Clone, Debug, PartialEq)]
pub struct LightRay {
    /// The map's view.
    pub view: View,
    /// Number of translucent casters that the ray meets.
    pub segments: u32,
    /// The truth at points spread evenly over the range, and on both sides of each depth where the truth bends or jumps or where a
    /// technique has a node.
    pub truth: RayPoints,
    /// One line per technique.
    pub lines: Vec<RayLine>,
}

/// Number of intervals into which the range is divided evenly.
const SAMPLES: u32 = 1024;

/// Number of candidate texels per side, spread evenly over the map.
const LOOKED_AT: u32 = 32;

/// Transmittance behind all casters of a ray worth plotting: some light is left, but not all.
const SOME_LIGHT: Range<f64> = 0.05..0.95;

/// Returns a texel of map `map` whose ray is worth plotting. Only candidates spread evenly over the map are considered, and among them rays
/// with some light left behind all casters (`SOME_LIGHT`) are preferred. The result is the first of these with the most translucent
/// casters. Arguments are as for [`LightRay::new`].
///
/// # Errors
/// [`Error::Input`] if the first technique has no maps, or if no candidate ray meets a translucent caster.
pub fn telling_texel(casters: &Casters, opened: &[Opened], map: usize) -> Result<[u32; 2]> {
    let view = view_of(opened, map)?;
    let place = |i: u32, side: u32| ((2 * i + 1) * side) / (2 * LOOKED_AT.min(side));
    let [across, down] = [view.width, view.height].map(|side| LOOKED_AT.min(side));
    let mut best: Option<((bool, u32), [u32; 2])> = None;
    for (x, y) in (0..down).flat_map(|y| (0..across).map(move |x| (x, y))) {
        let texel = [place(x, view.width), place(y, view.height)];
        let ray = view.ray(DVec2::new(f64::from(texel[0]) + 0.5, f64::from(texel[1]) + 0.5));
        if light_of(casters.scene(), map, ray.at(view.z(1.0))).is_none() {
            continue;
        }
        let (curve, segments) = casters.true_curve(map, &view, &ray);
        let worth = (SOME_LIGHT.contains(&curve.transmittance(1.0)), segments);
        if segments > 0 && best.is_none_or(|(most, _)| worth > most) {
            best = Some((worth, texel));
        }
    }
    best.map(|(_, texel)| texel).ok_or_else(|| {
        let name = casters.scene().name.clone();
        Error::input(
            name,
            "nothing translucent covers the map where it was looked at",
            "choose another map, or name a texel",
        )
    })
}

fn view_of(opened: &[Opened], map: usize) -> Result<View> {
    let view = opened.first().and_then(|opened| seen(opened, map));
    view.ok_or_else(|| Error::input("the first technique", "it has no maps", "name one that has"))
}

/// Returns the view of a technique's map, if it has one.
fn seen(opened: &Opened, map: usize) -> Option<View> {
    opened.technique.inspect().maps().get(map).map(|map: &Map| map.caster_view)
}

impl LightRay {
    /// Traces the ray of `texel` in map `map`, an index over the maps of all lights in the first of `opened`. All of `opened` must be built
    /// for the scene of `casters`.
    ///
    /// # Errors
    /// [`Error::Input`] if the first technique has no maps, or if the texel lies outside the map, is never looked up, or has no translucent
    /// caster on its ray; [`Error::Gpu`] if memory runs out.
    pub fn new(context: &Context, casters: &Casters, opened: &[Opened], map: usize, texel: [u32; 2]) -> Result<Self> {
        opened.iter().try_for_each(|opened| answers_in_space(opened.technique.as_ref()))?;
        let (name, [x, y]) = (format!("texel {},{}", texel[0], texel[1]), texel);
        let view = view_of(opened, map)?;
        if x >= view.width || y >= view.height {
            let cause = format!("outside the map of {} texels per side", view.width);
            return Err(Error::input(name, cause, "choose one inside"));
        }
        let ray = view.ray(DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5));
        let Some(light) = light_of(casters.scene(), map, ray.at(view.z(1.0))) else {
            let cause = "in the margin of the face, which belongs to another face";
            return Err(Error::input(name, cause, "go further in"));
        };
        let (curve, segments) = casters.true_curve(map, &view, &ray);
        if segments == 0 {
            let way_out = "choose another (`gobo slice` shows the map)";
            return Err(Error::input(name, "nothing translucent covers it", way_out));
        }
        let mut nodes = Vec::new();
        for opened in opened {
            let stands_in_it = seen(opened, map) == Some(view);
            nodes.push(if stands_in_it { opened.technique.inspect().nodes(map, texel)? } else { Vec::new() });
        }

        // Points are queried as three floats, so depths are rounded. No two points are closer than floats can tell apart.
        let [near, far] = [0.0, 1.0].map(|depth| ray.at(view.z(depth)));
        let apart =
            2.0 * f64::from(f32::EPSILON) * near.abs().max(far.abs()).max_element() / (view.z(1.0) - view.z(0.0));
        let even = (0..=SAMPLES).map(|i| f64::from(i) / f64::from(SAMPLES));
        let bends = curve.depths.iter().chain(nodes.iter().flatten().map(|(depth, _)| depth));
        let mut depths: Vec<f64> = even.chain(bends.flat_map(|depth| [depth - apart, depth + apart])).collect();
        depths.retain(|depth| (0.0..=1.0).contains(depth));
        depths.sort_unstable_by(f64::total_cmp);
        let positions: Vec<[f32; 3]> = depths.iter().map(|d| ray.at(view.z(*d)).as_vec3().into()).collect();
        let depth_of = |position: &[f32; 3]| view.depth(view.project(DVec3::from(position.map(f64::from))).1);
        let depths: Vec<f64> = positions.iter().map(depth_of).collect();
        let lit = |depth: f64| casters.unblocked(light, ray.at(view.z(depth)));
        let through = |depth: f64| if lit(depth) { curve.transmittance(depth) } else { 0.0 };
        let truth = depths.iter().map(|depth| (*depth, through(*depth))).collect();

        let query = Query::new(context, light, &positions)?;
        let mut lines = Vec::new();
        for (opened, mut nodes) in opened.iter().zip(nodes) {
            let answers = query.ask(&opened.technique.answer())?;
            nodes.retain(|(depth, _)| lit(*depth));
            lines.push(RayLine {
                points: depths.iter().copied().zip(answers.into_iter().map(f64::from)).collect(),
                nodes,
            });
        }
        Ok(Self { view, segments, truth, lines })
    }

    /// Returns the title of the ray's plot.
    pub fn title(&self, scene: &str, [x, y]: [u32; 2]) -> String {
        format!("{scene}, texel {x},{y}: {} segments", self.segments)
    }

    /// Returns the depths worth plotting: those at which something changes, plus a fifth of their range in front and behind.
    pub fn range(&self) -> Range<f64> {
        let covered = self.truth.iter().filter(|(_, t)| *t < 1.0).map(|p| p.0);
        let last = self.truth.last().map_or(1.0, |p| p.1);
        let first = covered.fold(1.0, f64::min);
        let settled = self.truth.iter().filter(|(_, t)| *t > last + 1e-4).map(|p| p.0).fold(first, f64::max);
        let margin = 0.2 * (settled - first).max(0.01);
        (first - margin).max(0.0)..(settled + margin).min(1.0)
    }
}

/// Returns the light that is looked up through map `map` at `position`; `None` if it is looked up through another map.
fn light_of(scene: &Scene, map: usize, position: DVec3) -> Option<usize> {
    let light = (0..scene.lights.len()).rfind(|light| scene.first_map(*light) <= map)?;
    let asked = scene.first_map(light) + scene.lights[light].map_at(position.as_vec3().into());
    (asked == map).then_some(light)
}
