//! `gobo render --steps`: how many steps look-ups take, as colours.

use super::drawn::Drawn;
use super::render::Arguments;
use crate::Result;
use crate::consume::Renderer;
use crate::gpu::Context;
use crate::report::with_scale;
use crate::scene::{Scene, View};
use crate::technique::{Spec, open};
use crate::world::World;

/// Counts of one picture, rows from the top; none where no mesh is.
pub type Counts = Vec<Option<u32>>;

/// Few to many, sRGB: ends and middle of cividis, which is read alike with any colour vision (Nuñez, Anderton and Renslow 2018).
const COLOURS: [[f64; 3]; 3] = [[0.0, 32.0, 77.0], [124.0, 123.0, 120.0], [255.0, 234.0, 70.0]];

/// Where no mesh is.
const NOTHING: [u8; 3] = [0; 3];

/// The colour of a share from 0 to 1.
fn colour(share: f64) -> [u8; 3] {
    let at = 2.0 * share;
    let [from, to] = if at < 1.0 { [COLOURS[0], COLOURS[1]] } else { [COLOURS[1], COLOURS[2]] };
    let share = if at < 1.0 { at } else { at - 1.0 };
    [0, 1, 2].map(|i| (from[i] + share * (to[i] - from[i])).round() as u8)
}

/// Counts each state's steps, then paints all of them by one range. Returns what is to be said of it.
pub(super) fn by_technique(
    arguments: &Arguments,
    context: &Context,
    spec: &Spec,
    states: &[Scene],
    each: &mut dyn FnMut(Drawn) -> Result<()>,
) -> Result<Vec<String>> {
    let size = arguments.size();
    let mut world = World::new(context, &states[0])?;
    let mut opened = open(context, &world, spec)?;
    let mut renderer = Renderer::new(context, &world, &View::camera(&states[0].camera, &states[0], size))?;
    let mut counts = Vec::new();
    for (frame, scene) in states.iter().enumerate() {
        if frame > 0 {
            world.replace(scene)?;
        }
        opened.build(&world)?;
        renderer.look(&world, &View::camera(&scene.camera, scene, size))?;
        counts.push(renderer.steps(&opened.technique.answer())?);
    }
    let path = opened.technique.facts()?.path;
    let range = Range::of(&counts);
    let ends =
        range.map_or(["no mesh".into(), String::new()], |range| [range.least, range.most].map(|n| n.to_string()));
    for counts in &counts {
        let painted = Range::paint(range, counts);
        if arguments.show()?.is_none() {
            each(Drawn::of_bytes(size, painted))?;
            continue;
        }
        let paper = with_scale(&painted, size, colour, [&ends[0], "steps of all look-ups", &ends[1]]);
        each(Drawn::of_bytes(paper.size, paper.rgb8))?;
    }
    let said = format!("{spec} on {}, path {path}", context.features().name);
    Ok(std::iter::once(said).chain(range.map(|range| range.to_string())).collect())
}

/// The least, the mean and the greatest of all counts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Range {
    least: u32,
    mean: f64,
    most: u32,
}

impl Range {
    /// The steps of several pictures; none where they show no mesh.
    pub fn of(pictures: &[Counts]) -> Option<Self> {
        let all = || pictures.iter().flatten().flatten().copied();
        let mean = all().map(f64::from).sum::<f64>() / all().count() as f64;
        Some(Self { least: all().min()?, mean, most: all().max()? })
    }

    /// Three bytes per pixel, of pictures of that range.
    pub fn paint(range: Option<Self>, counts: &[Option<u32>]) -> Vec<u8> {
        let (least, most) = range.map_or((0, 1), |range| (range.least, range.most));
        let colour = |count: u32| colour(f64::from(count - least) / f64::from((most - least).max(1)));
        counts.iter().flat_map(|count| count.map_or(NOTHING, colour)).collect()
    }
}

impl std::fmt::Display for Range {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { least, mean, most } = self;
        write!(f, "steps of a pixel's look-ups: {least} (dark blue) to {most} (yellow), {mean:.2} in the mean")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dark_blue_to_yellow() {
        let pictures = [vec![Some(2), None], vec![Some(10), Some(6)]];
        let range = Range::of(&pictures).expect("counts");
        assert_eq!(range, Range { least: 2, mean: 6.0, most: 10 });
        assert_eq!(Range::paint(Some(range), &pictures[0]), [0, 32, 77, 0, 0, 0]);
        assert_eq!(Range::paint(Some(range), &pictures[1]), [255, 234, 70, 124, 123, 120]);
        assert_eq!(Range::of(&[vec![None]]), None);
        assert_eq!(Range::paint(None, &[None]), [0, 0, 0]);
        assert_eq!(Range::paint(Range::of(&[vec![Some(3)]]), &[Some(3)]), [0, 32, 77]);
    }
}
