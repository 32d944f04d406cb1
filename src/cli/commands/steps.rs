//! `gobo render --steps`: how many steps look-ups take, as colors.

use crate::Result;
use crate::cli::commands::render::Arguments;
use crate::cli::frame_source::States;
use crate::cli::output::render_frames::RenderedFrame;
use crate::gpu::Context;
use crate::report::{StepRange, step_color, with_scale};
use crate::scene::View;
use crate::shading::Renderer;
use crate::technique::{Spec, open};
use crate::world::World;

/// Counts the steps in each state, then paints all states in the same range of colors. Returns notes for the user.
pub(in crate::cli) fn by_technique(
    arguments: &Arguments,
    context: &Context,
    spec: &Spec,
    states: &States,
    each: &mut dyn FnMut(RenderedFrame) -> Result<()>,
) -> Result<Vec<String>> {
    let size = arguments.size();
    let first = states.at(0)?;
    let mut world = World::new(context, &first)?;
    let mut opened = open(context, &world, spec)?;
    let mut renderer = Renderer::new(context, &world, &View::camera(&first.camera, &first, size))?;
    let mut counts = Vec::new();
    let mut first = Some(first);
    for frame in 0..states.len() {
        let scene = &first.take().map_or_else(|| states.at(frame), Ok)?;
        if frame > 0 {
            world.replace(scene)?;
        }
        opened.build(&world)?;
        renderer.look(&world, &View::camera(&scene.camera, scene, size))?;
        counts.push(renderer.steps(&opened.technique.answer())?);
    }
    let path = opened.technique.inspect().facts()?.path;
    let range = StepRange::of(&counts);
    let ends = range.map_or(["no mesh".into(), String::new()], |range| range.ends().map(|n| n.to_string()));
    for counts in &counts {
        let painted = StepRange::paint(range, counts);
        if arguments.show()?.is_none() {
            each(RenderedFrame::of_bytes(size, painted))?;
            continue;
        }
        let paper = with_scale(&painted, size, step_color, [&ends[0], "steps of all look-ups", &ends[1]]);
        each(RenderedFrame::of_bytes(paper.size, paper.rgb8))?;
    }
    let said = format!("{} on {}, path {path}", spec.short(), context.features().name);
    Ok(std::iter::once(said).chain(range.map(|range| range.to_string())).collect())
}
