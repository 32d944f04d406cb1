//! Evaluates a technique in the scene of one value, and measures its answers.

use super::case_truth::{MovedCasters, RoundedAnswers, Subject};
use super::results::{CaseResult, ErrorSummary, Figures, Outcome};
use crate::advice::advised;
use crate::bench::{Answers, Points, SeenError};
use crate::gpu::Context;
use crate::query;
use crate::query::Query;
use crate::reference::truth::MAP_DEPTHS;
use crate::scene::Resolution;
use crate::technique::{self, Name, Opened, Spec};
use crate::world::World;
use crate::{Error, Result};
use std::sync::Arc;

/// Error bound for rounding in a sum of weights: answers may fall outside [0, 1] by this much.
const ROUNDING: f32 = 1e-6;

/// Builds the technique of `spec` for the subject's scene and queries it. Then queries it again, first with the casters in other orders,
/// and then with the casters moved slightly. A failure gives a row too.
pub fn ask(context: &Context, subject: &Subject, (case, value): (&str, f64), spec: &Spec) -> CaseResult {
    let mut row = CaseResult {
        case: case.into(),
        value,
        technique: spec.short(),
        path: spec.text(Name::PATH).into(),
        outcome: Outcome::Answered,
        reason: String::new(),
        figures: None,
    };
    match figures(context, subject, spec, &mut row.path) {
        Ok(figures) => row.figures = Some(figures),
        Err(error) => {
            row.outcome = if matches!(error, Error::Refused(_)) { Outcome::Refused } else { Outcome::Failed };
            row.reason = advised(error).to_string();
        }
    }
    row
}

fn figures(context: &Context, subject: &Subject, spec: &Spec, path: &mut String) -> Result<Figures> {
    let said = context.messages().all().len();
    let mut world = World::new(context, subject.scene)?;
    let mut opened = technique::open(context, &world, spec)?;
    opened.build(&world)?;
    *path = opened.technique.inspect().facts()?.path.into();
    let views: Vec<_> = opened.technique.inspect().maps().iter().map(|map| map.caster_view).collect();
    let has_smoke = !subject.scene.has_only_meshes();
    // With meshes alone, most points on rays are in the boundary, so only points in space and on meshes are queried.
    let on_rays = if views.is_empty() || !has_smoke { Arc::default() } else { subject.maps(&views) };
    let (maps, rounded) = &*on_rays;
    let kinds = [&maps[..], subject.space(), subject.surface()];
    let mut figures = Figures::default();
    let first = answers(context, &opened, &kinds, &mut figures)?;
    let resolution = opened.technique.inspect().resolution();
    let mut asked = Vec::new();
    for (points, said) in kinds.iter().zip(&first) {
        asked.push(Some(compared(subject, points, said, &resolution)?).filter(|asked| asked.points > 0));
    }
    (figures.surface, figures.space, figures.map) =
        (asked.pop().flatten(), asked.pop().flatten(), asked.pop().flatten());
    figures.seen = seen(context, subject, &world, &opened, &mut figures)?;
    if !maps.is_empty() {
        let truth: Vec<f64> = maps.iter().flat_map(|points| &points.visibility).copied().collect();
        let finer = spec.plan_on(path).map_or(1.0, |plan| plan.promises.finer);
        (figures.rise, figures.tail) = along_rays(&first[0], &truth, rounded, finer);
    }
    figures.order_spread = order_spread(context, subject, &mut world, &mut opened, (&kinds, &first), &mut figures)?;
    figures.step_rms = step_rms(context, subject, &mut world, &mut opened, &first[1], &mut figures)?;
    figures.messages = (context.messages().all().len() - said) as u64;
    Ok(figures)
}

/// Returns answers at the points of each kind. Answers that are not finite or outside [0, 1] are counted in `figures`.
pub(super) fn answers(
    context: &Context,
    opened: &Opened,
    kinds: &[&[Points]],
    figures: &mut Figures,
) -> Result<Vec<Vec<f32>>> {
    let mut of = |all: &&[Points]| {
        let asked: Vec<_> = all.iter().map(in_query).collect();
        if asked.iter().all(|part| part.points.is_empty()) {
            return Ok(Vec::new());
        }
        let said = Query::of_lights(context, &asked)?.ask(&opened.technique.answer())?;
        count(&said, figures);
        Ok(said)
    };
    kinds.iter().map(&mut of).collect()
}

/// Counts answers that are not finite, or outside [0, 1].
fn count(said: &[f32], figures: &mut Figures) {
    figures.not_finite += said.iter().filter(|answer| !answer.is_finite()).count() as u64;
    let outside = |answer: &&f32| answer.is_finite() && !(-ROUNDING..=1.0 + ROUNDING).contains(*answer);
    figures.outside += said.iter().filter(outside).count() as u64;
}

/// Returns the seen error; `None` if an answer is not finite.
fn seen(
    context: &Context,
    subject: &Subject,
    world: &World,
    opened: &Opened,
    figures: &mut Figures,
) -> Result<Option<SeenError>> {
    let said = subject.seen().ask(context, world, opened.technique.as_ref())?;
    said.iter().for_each(|said| count(said, figures));
    let is_finite = said.iter().flatten().all(|answer| answer.is_finite());
    if is_finite { subject.seen().error(&said) } else { Ok(None) }
}

fn in_query(points: &Points) -> query::PointBatch<'_> {
    query::PointBatch { light: points.light, points: &points.positions, normals: &points.normals }
}

/// Returns the errors of the finite answers.
fn compared(subject: &Subject, all: &[Points], said: &[f32], resolution: &[Resolution]) -> Result<ErrorSummary> {
    let mut kept = Answers::default();
    let mut said = said.iter();
    for points in all {
        let boundary = subject.boundary(points, resolution);
        for (i, truth) in points.visibility.iter().enumerate() {
            let Some(&answer) = said.next() else { break };
            if !answer.is_finite() {
                continue;
            }
            kept.approximate.push(answer);
            kept.truth.push(*truth);
            kept.within.extend(boundary.get(i));
        }
    }
    Ok(ErrorSummary { points: kept.truth.len() as u64, error: kept.error()? })
}

/// Returns the largest rise of answers along a texel's ray, and the largest error of the last answer on a ray. Points are rounded and so
/// lie slightly off their rays; the error bound for this is subtracted from both figures. The technique's texels may be smaller by a factor
/// of up to `finer`, which increases the error bound by the same factor.
pub(super) fn along_rays(
    said: &[f32],
    truth: &[f64],
    rounded: &[RoundedAnswers],
    finer: f64,
) -> (Option<f64>, Option<f64>) {
    let (mut rise, mut tail) = (0.0_f64, 0.0_f64);
    let depths = MAP_DEPTHS as usize;
    for (first, said) in said.chunks_exact(depths).enumerate() {
        let (truth, rounded) = (&truth[first * depths..], &rounded[first * depths..]);
        for k in (1..depths).filter(|k| rounded[*k].z > rounded[k - 1].z) {
            let off = finer * (rounded[k].off + rounded[k - 1].off);
            rise = rise.max(f64::from(said[k]) - f64::from(said[k - 1]) - off);
        }
        tail = tail.max((f64::from(said[depths - 1]) - truth[depths - 1]).abs() - finer * rounded[depths - 1].off);
    }
    (Some(rise), Some(tail))
}

/// Returns the largest difference between finite answers over all orders of the casters.
fn order_spread(
    context: &Context,
    subject: &Subject,
    world: &mut World,
    opened: &mut Opened,
    (kinds, first): (&[&[Points]], &[Vec<f32>]),
    figures: &mut Figures,
) -> Result<Option<f64>> {
    let mut spread = None;
    let (mut low, mut high) = (first.concat(), first.concat());
    for scene in subject.shuffled() {
        world.replace(&scene)?;
        opened.build(world)?;
        let said = answers(context, opened, kinds, figures)?.concat();
        for ((low, high), said) in low.iter_mut().zip(&mut high).zip(said) {
            (*low, *high) = (low.min(said), high.max(said));
        }
        let between = low.iter().zip(&high).map(|(low, high)| f64::from(high - low));
        let most = between.filter(|spread| spread.is_finite()).fold(0.0, f64::max);
        spread = Some(most);
    }
    world.replace(subject.scene)?;
    opened.build(world)?;
    Ok(spread)
}

/// Returns the root mean square, over all steps and points in space, of how much more an answer changes than the truth. A technique with
/// maps of smoke is compared with the filtered truth, so that the size of its texels does not count as an error. `before` holds the answers
/// before the first step.
fn step_rms(
    context: &Context,
    subject: &Subject,
    world: &mut World,
    opened: &mut Opened,
    before: &[f32],
    figures: &mut Figures,
) -> Result<Option<f64>> {
    let mut boundary = subject.boundary_after(0, &opened.technique.inspect().resolution());
    let views =
        |opened: &Opened| opened.technique.inspect().maps().iter().map(|map| map.caster_view).collect::<Vec<_>>();
    let has_maps = !views(opened).is_empty() && !subject.scene.has_only_meshes();
    let mut truth_before: Arc<Vec<f64>> = match has_maps {
        true => subject.filtered(0, &views(opened)),
        false => Arc::new(subject.space().iter().flat_map(|points| points.visibility.clone()).collect()),
    };
    let mut before = before.to_vec();
    let (mut sum, mut count) = (0.0, 0.0);
    for (step, MovedCasters { scene, visibility }) in (1..).zip(subject.moved()) {
        world.replace(scene)?;
        opened.build(world)?;
        let Some(now) = answers(context, opened, &[subject.space()], figures)?.pop() else { break };
        let truth = if has_maps { subject.filtered(step, &views(opened)) } else { visibility.clone() };
        // Points in the boundary before or after the step are left out.
        let boundary_now = subject.boundary_after(step, &opened.technique.inspect().resolution());
        for i in (0..now.len()).filter(|i| !boundary[*i] && !boundary_now[*i]) {
            let more = f64::from(now[i]) - f64::from(before[i]) - (truth[i] - truth_before[i]);
            if more.is_finite() {
                (sum, count) = (sum + more * more, count + 1.0);
            }
        }
        (before, truth_before, boundary) = (now, truth, boundary_now);
    }
    Ok((count > 0.0).then(|| f64::sqrt(sum / count)))
}
