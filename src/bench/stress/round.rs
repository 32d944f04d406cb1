//! A round of a soak: techniques are built and queried in the moving scene of a seed, then everything is freed.

use super::case_truth::Subject;
use super::evaluate::{along_rays, answers};
use super::random_round::{RandomRound, drawn};
use super::results::{CaseResult, Figures, Outcome};
use super::verdict::broken_invariants;
use crate::advice::advised;
use crate::bench::{Points, host_bytes};
use crate::gpu::Context;
use crate::reference::truth::bounds;
use crate::scene::{Random, Scene};
use crate::technique::keys::word_of;
use crate::technique::settings::FILTER;
use crate::technique::{self, Lifetime, Name, Opened, Promises, Spec};
use crate::world::World;
use crate::{Error, Result};
use glam::DVec3;
use serde::{Deserialize, Serialize};

/// A failure, and the seed that repeats it.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Failure {
    /// `gobo stress --soak 0 --seed SEED` repeats the round.
    pub seed: u64,
    /// The technique being queried; empty if no technique caused the failure.
    pub technique: String,
    /// The promise that was broken.
    pub broken: String,
}

/// A round.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Round {
    /// The round's seed.
    pub seed: u64,
    /// Number of techniques queried.
    pub asked: u64,
    /// Number of techniques that refused: because of a key or light they do not support, or a feature that the device lacks.
    pub refused: u64,
    /// All failures of the round.
    pub failures: Vec<Failure>,
    /// The process's memory after the round, in bytes; absent if the system does not report it.
    pub host_bytes: Option<u64>,
    /// Device memory held by the process after the round, in bytes.
    pub device_bytes: u64,
}

/// Runs the round of a seed, and calls `asking` with each technique before querying it.
///
/// # Errors
/// Fails if `asking` does; other failures are in the round's result.
pub fn round(context: &Context, seed: u64, mut asking: impl FnMut(&Spec) -> Result<()>) -> Result<Round> {
    let (drawn, before) = (drawn(seed), context.allocated_bytes());
    let mut round = Round { seed, ..Round::default() };
    for spec in &drawn.specs {
        asking(spec)?;
        round.asked += 1;
        let said = context.messages().all().len();
        let mut broken = match check(context, &drawn, seed, spec) {
            Ok(broken) => broken,
            Err(Error::Refused(_) | Error::Input { .. } | Error::Usage { .. }) => {
                round.refused += 1;
                Vec::new()
            }
            Err(error) => vec![advised(error).to_string()],
        };
        broken.extend(context.messages().all().split_off(said));
        let failure = |broken| Failure { seed, technique: spec.short(), broken };
        round.failures.extend(broken.into_iter().map(failure));
    }
    // An empty submission, since the resources of a technique that refused are freed with the next submission.
    if let Err(error) = context.try_submit(|_| Ok(())) {
        round.failures.push(Failure { seed, technique: String::new(), broken: advised(error).to_string() });
    }
    (round.host_bytes, round.device_bytes) = (host_bytes(), context.allocated_bytes());
    if round.device_bytes != before {
        let broken = format!("{before} bytes of device memory before the round, {} after it", round.device_bytes);
        round.failures.push(Failure { seed, technique: String::new(), broken });
    }
    Ok(round)
}

/// Checks a technique in each frame, then builds it again for the last frame, then opens a new one with the other value of `skip=`. Returns
/// the promises that were broken.
fn check(context: &Context, drawn: &RandomRound, seed: u64, spec: &Spec) -> Result<Vec<String>> {
    let mut world = World::new(context, &drawn.most)?;
    let mut broken = Vec::new();
    let mut moved: Option<Opened> = None;
    let mut last = Vec::new();
    // Baked techniques are for static scenes, so they get only the last frame.
    let first = if spec.entry.lifetime == Lifetime::Baked { drawn.frames.len() - 1 } else { 0 };
    for (frame, scene) in drawn.frames.iter().enumerate().skip(first) {
        world.replace(scene)?;
        let opened = match &mut moved {
            Some(opened) => opened,
            None => moved.insert(technique::open(context, &world, spec)?),
        };
        opened.build(&world)?;
        let mut figures = Figures::default();
        on_rays(context, opened, scene, spec, &mut figures)?;
        last = anywhere(context, opened, scene, seed, &mut figures)?;
        let row = CaseResult {
            case: String::new(),
            value: frame as f64,
            technique: spec.short(),
            path: opened.technique.inspect().facts()?.path.into(),
            outcome: Outcome::Answered,
            reason: String::new(),
            figures: Some(figures),
        };
        broken.extend(broken_invariants(&row).into_iter().map(|words| format!("frame {frame}: {words}")));
    }
    let (Some(mut opened), Some(scene)) = (moved, drawn.frames.last()) else { return Ok(broken) };
    let ask = |opened: &Opened| anywhere(context, opened, scene, seed, &mut Figures::default());
    let promises = promises(spec, &opened)?;
    if promises.repeats {
        opened.rebuild(&world)?;
        let again = ask(&opened)?;
        broken.extend(differ("built again", &last, &again));
    }
    // With meshes, `skip=on` leaves out everything behind them, so answers there may differ.
    if promises.repeats && promises.skips_alike && !scene.has_triangles() {
        let mut other = spec.clone();
        other.set(Name::SKIP, if spec.skips() { "off" } else { "on" });
        match technique::open(context, &world, &other) {
            Ok(mut opened) => {
                opened.build(&world)?;
                let anew = ask(&opened)?;
                broken.extend(differ(&format!("opened anew with skip={}", other.text(Name::SKIP)), &last, &anew));
            }
            // The last frame no longer has the kind of caster that the technique needs.
            Err(Error::Refused(_)) => {}
            Err(error) => return Err(error),
        }
    }
    Ok(broken)
}

/// Returns the promises of the path that runs.
fn promises(spec: &Spec, opened: &Opened) -> Result<Promises> {
    let plan = spec.plan_on(opened.technique.inspect().facts()?.path);
    Ok(plan.map_or(Promises::NONE, |plan| plan.promises))
}

/// Describes how two lists of answers differ in their bits, if they do.
pub(super) fn differ(what: &str, before: &[f32], after: &[f32]) -> Option<String> {
    let others: Vec<_> = before.iter().zip(after).filter(|(a, b)| a.to_bits() != b.to_bits()).collect();
    let most = others.iter().map(|(a, b)| (*a - *b).abs()).fold(0.0, f32::max);
    let lost = before.len() != after.len();
    (lost || !others.is_empty())
        .then(|| format!("{what}: {} of {} answers differ, by up to {most:.1e}", others.len(), before.len()))
}

/// Returns answers for all lights at points in and around the scene.
fn anywhere(context: &Context, opened: &Opened, scene: &Scene, seed: u64, figures: &mut Figures) -> Result<Vec<f32>> {
    let positions = points(scene, seed);
    let of_light = |light| Points::in_space(light, positions.clone(), Vec::new());
    let all: Vec<_> = (0..scene.lights.len()).map(of_light).collect();
    Ok(answers(context, opened, &[&all], figures)?.concat())
}

/// Checks answers on the rays of texels, in scenes whose truth is known.
fn on_rays(context: &Context, opened: &Opened, scene: &Scene, spec: &Spec, figures: &mut Figures) -> Result<()> {
    let views: Vec<_> = opened.technique.inspect().maps().iter().map(|map| map.caster_view).collect();
    // With meshes, answers depend on the resolution of opaque shadows; with wider filters, on other texels' rays. No truth is computed here
    // for either.
    let is_plain = ["", word_of(FILTER.default)].contains(&spec.text(Name::FILTER));
    if !is_plain || views.is_empty() || scene.has_triangles() || scene.casters().is_empty() {
        return Ok(());
    }
    let on_rays = Subject::new(scene).maps(&views);
    let said = answers(context, opened, &[&on_rays.0], figures)?.concat();
    let truth: Vec<f64> = on_rays.0.iter().flat_map(|points| &points.visibility).copied().collect();
    let finer = promises(spec, opened)?.finer;
    (figures.rise, figures.tail) = along_rays(&said, &truth, &on_rays.1, finer);
    Ok(())
}

/// Returns points around the casters, inside them, at the lights and far from everything.
fn points(scene: &Scene, seed: u64) -> Vec<[f32; 3]> {
    const SOMEWHERE: usize = 160;
    const OF_CASTERS: usize = 32;
    let [low, high] = bounds(scene).unwrap_or([DVec3::NEG_ONE, DVec3::ONE]);
    let mut random = Random::new([seed, 0x901]);
    let somewhere = (0..SOMEWHERE).map(|_| (low + high + 1.5 * (high - low) * random.in_ball()) / 2.0);
    let lights = scene.lights.iter().filter_map(|light| light.position());
    let far = [DVec3::ZERO, DVec3::splat(1e6), high + 1e3 * (high - low)];
    let points = somewhere.chain(lights).chain(far).map(|p| p.as_vec3().into());
    let in_casters = scene.particles.iter().map(|p| p.position).chain(scene.strands.iter().map(|s| s.start));
    points.chain(in_casters.take(OF_CASTERS)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Answers that differ in any bit, even of a NaN, and missing answers must be reported.
    #[test]
    fn what_differs_is_said() {
        assert_eq!(differ("again", &[0.5, f32::NAN], &[0.5, f32::NAN]), None);
        assert_eq!(
            differ("again", &[0.5, 1.0], &[0.25, 1.0]).as_deref(),
            Some("again: 1 of 2 answers differ, by up to 2.5e-1")
        );
        assert!(differ("again", &[0.0], &[-0.0]).is_some() && differ("again", &[0.0], &[]).is_some());
    }
}
