//! The run loop: measures the rows of a plan in turn, and notifies an observer.

pub(super) mod observer;
pub(super) mod plan;

use crate::Result;
use crate::bench::run::observer::{Observer, RowPictures};
use crate::bench::run::plan::Plan;
use crate::bench::{CasePictures, Margins, Results, Row, SceneCase, Status, change_of, marks, with_case};
use crate::gpu::Context;
use crate::technique::Spec;
use std::ops::Range;

/// Maximum number of repeated measurements if a row seems slower than its baseline. A build that has become slower stays slower, while
/// interference from another program is temporary.
const MEASURED_AGAIN: u32 = 2;

/// Measures the remaining rows of `plan`; stops early if the device is lost. `results` holds all measured rows, in the order of the plan.
///
/// # Errors
/// Errors that the observer returns: by default, every error from [`with_case`].
pub fn run(context: &Context, plan: &mut Plan, results: &mut Results, observer: &mut dyn Observer) -> Result<()> {
    results.rows = plan.measured();
    let mut first = 0;
    for scene in 0..plan.scenes.len() {
        let rows = first..first + plan.scenes[scene].specs.len();
        first = rows.end;
        if plan.left_in(rows.clone()).is_empty() || context.is_lost() {
            continue;
        }
        if let Err(error) = run_scene(context, plan, (scene, rows), results, observer) {
            observer.scene_fails(error)?;
        }
    }
    Ok(())
}

/// Measures the remaining rows of a scene; `places` holds the indices of its rows in the plan's list.
fn run_scene(
    context: &Context,
    plan: &mut Plan,
    (scene, places): (usize, Range<usize>),
    results: &mut Results,
    observer: &mut dyn Observer,
) -> Result<()> {
    let left = plan.left_in(places.clone());
    let Plan { scenes, rows, baseline, .. } = plan;
    let scene = &scenes[scene];
    let spec = |place: usize| &scene.specs[place - places.start];
    with_case(context, scene.frames, plan.effort, |case| {
        if plan.makes_pipelines_first {
            case.prepare(&left.iter().map(|place| spec(*place)).collect::<Vec<_>>())?;
        }
        case.learn(plan.earlier);
        for place in left {
            if context.is_lost() {
                break;
            }
            observer.row_begins(scene.name(), spec(place));
            let (mut row, drawn) = measure(case, spec(place), *baseline);
            row.marks = marks(&row, results.device.stages.as_ref());
            if let Some(drawn) = &drawn {
                let (number, bounce, before) = (place - places.start + 1, case.traced(), &*results);
                let reference = drawn.beside_truth.as_ref().and_then(|_| case.reference());
                observer.row_is_drawn(&mut row, &RowPictures { number, drawn, reference, bounce, before });
            }
            rows[place] = Some(row.clone());
            results.rows = rows.iter().flatten().cloned().collect();
            results.executables = context.executables();
            observer.row_ends(&row, spec(place), results)?;
        }
        Ok(())
    })
}

/// Measures a row, and again if it seems slower than in the baseline, since something else may have been running.
fn measure(case: &mut SceneCase, spec: &Spec, baseline: Option<(&Results, Margins)>) -> (Row, Option<CasePictures>) {
    let mut measured = case.measure(spec);
    let Some((before, margins)) = baseline else { return measured };
    let is_slower = |row: &Row| change_of(before, row, margins).is_some_and(|change| change.is_slower());
    // A repeated measurement that is too unsteady to judge does not prove that the row is no slower.
    let is_no_slower = |row: &Row| change_of(before, row, margins).is_some_and(|change| change.is_no_slower());
    for _ in 0..MEASURED_AGAIN {
        if !is_slower(&measured.0) {
            break;
        }
        let again = case.measure(spec);
        if is_no_slower(&again.0) || is_slower(&again.0) && is_quicker(&again.0, &measured.0) {
            measured = again;
        }
    }
    measured
}

/// Whether a row's build is faster than another's; other times do not count.
fn is_quicker(row: &Row, other: &Row) -> bool {
    row.status == Status::Ok && row.build_ns.zip(other.build_ns).is_some_and(|(a, b)| a.median < b.median)
}
