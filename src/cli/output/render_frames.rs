//! Pictures of a scene as `gobo render` shows them, frame by frame.

use crate::cli::commands::render::Arguments;
use crate::cli::frame_source::States;
use crate::cli::one_spec;
use crate::gpu::{Context, PassTime};
use crate::reference::truth::{Casters, fog, picture, shown_picture, tonemapped};
use crate::scene::{Fog, Picture, View};
use crate::shading::{Kernels, Lighting, Pictures, Renderer, Shading};
use crate::technique::{Opened, Spec, answers_in_space, open};
use crate::world::World;
use crate::{Error, Result};

/// Number of frames over which the median time is computed.
const TIMED: usize = 9;

/// A frame that was drawn.
pub(in crate::cli) struct RenderedFrame {
    /// Size in pixels.
    pub size: [u32; 2],
    /// The picture to show: three bytes per pixel, rows from the top.
    pub rgb8: Vec<u8>,
    /// The picture to measure, if requested.
    pub plain: Option<Picture>,
    /// Device time of a build and a plain picture, in milliseconds, if requested and the device has timestamps.
    pub frame_ms: Option<f64>,
}

impl RenderedFrame {
    /// Creates a frame from a picture that is shown as it is measured.
    pub(in crate::cli) fn of(picture: &Picture) -> Self {
        Self::of_bytes([picture.width, picture.height], picture.to_srgb8())
    }

    /// Creates a frame from bytes as they are written to the file.
    pub(in crate::cli) fn of_bytes(size: [u32; 2], rgb8: Vec<u8>) -> Self {
        Self { size, rgb8, plain: None, frame_ms: None }
    }
}

/// Draws each state with the f64 reference.
pub(in crate::cli) fn by_reference(
    arguments: &Arguments,
    states: &States,
    plain: bool,
    each: &mut dyn FnMut(RenderedFrame) -> Result<()>,
) -> Result<()> {
    let (show, air, size) = (arguments.show()?, arguments.air()?, arguments.size());
    let with_air = |casters: &Casters, camera: &View, picture: Picture, air: &Option<Fog>| match air {
        Some(air) => fog(casters, camera, &picture, air, |light, position| casters.arriving_colors(light, position)),
        None => picture,
    };
    for frame in 0..states.len() {
        let scene = &states.at(frame)?;
        let casters = Casters::new(scene);
        let measured = || {
            let camera = View::camera(&scene.camera, scene, size);
            with_air(&casters, &camera, picture(&casters, scene, &camera), &air)
        };
        let mut drawn = match &show {
            None => RenderedFrame::of(&measured()),
            Some(show) => {
                let camera = View::camera(&scene.camera, scene, show.sampled(size));
                let samples = with_air(&casters, &camera, shown_picture(&casters, scene, &camera), &air);
                RenderedFrame::of(&tonemapped(&samples, show))
            }
        };
        drawn.plain = plain.then(measured);
        each(drawn)?;
    }
    Ok(())
}

/// Draws each state, lit by a technique. Returns notes for the user.
pub(in crate::cli) fn by_technique(
    arguments: &Arguments,
    context: &Context,
    spec: &Spec,
    states: &States,
    plain: bool,
    each: &mut dyn FnMut(RenderedFrame) -> Result<()>,
) -> Result<Vec<String>> {
    let settings = spec.settings();
    let lighting = Lighting::of(&settings);
    settings.check(context.features())?;
    let (show, air, size) = (arguments.show()?, arguments.air()?, arguments.size());
    let first = states.at(0)?;
    let mut world = World::new(context, &first)?;
    let mut opened = open(context, &world, spec)?;
    if air.is_some() {
        answers_in_space(opened.technique.as_ref())?;
    }
    let draws = Draws { spacing: arguments.wireframe.then_some(lighting), air, still: states.len() == 1 };
    let shading = arguments.shading(spec);
    let mut shown = Pictures::new(context, &world, &first, size, show)?;
    let mut measured = match plain || arguments.timed {
        true => Some(Pictures::new(context, &world, &first, size, None)?),
        false => None,
    };
    [Some(&mut shown), measured.as_mut()].into_iter().flatten().for_each(|p| p.renderer.paint_by(settings.painter));
    let mut path = "";
    let mut first = Some(first);
    for frame in 0..states.len() {
        // The previous frame is freed before the next is created.
        let scene = &first.take().map_or_else(|| states.at(frame), Ok)?;
        if frame > 0 {
            world.replace(scene)?;
        }
        opened.build(&world)?;
        path = opened.technique.inspect().facts()?.path;
        shown.look(&world, scene)?;
        let picture = draws.picture(&shown, &opened, shading, lighting)?;
        if let Some(bad) = picture.pixels.iter().position(|p| p.iter().any(|c| !c.is_finite())) {
            let name = format!("pixel {bad} of picture {frame}");
            return Err(Error::input(name, "not a number", "report this as a bug, with the scene"));
        }
        let mut drawn = RenderedFrame::of(&picture);
        if let Some(measured) = &mut measured {
            measured.look(&world, scene)?;
            drawn.plain = plain.then(|| draws.picture(measured, &opened, shading, lighting)).transpose()?;
            if arguments.timed {
                drawn.frame_ms = frame_ms(&mut opened, &world, &measured.renderer, shading, lighting)?;
            }
        }
        each(drawn)?;
    }
    Ok(vec![format!("{} on {}, path {path}", spec.short(), context.features().name)])
}

/// How a frame is drawn.
struct Draws {
    /// With `--wireframe`, the spacing of the vertices whose triangles are drawn.
    spacing: Option<Lighting>,
    air: Option<Fog>,
    /// Whether all frames show the same world. In a moving world, the previous frame shows another state.
    still: bool,
}

impl Draws {
    fn picture(&self, pictures: &Pictures, opened: &Opened, shading: Shading, lighting: Lighting) -> Result<Picture> {
        let (renderer, technique) = (&pictures.renderer, opened.technique.as_ref());
        let answer = technique.answer();
        match self.spacing {
            Some(Lighting::Vertex { spacing }) => drop(renderer.wireframe(&answer, shading, spacing)?),
            _ if self.still => drop(renderer.picture_of(technique, shading, lighting)?),
            _ => drop(renderer.draw(&renderer.kernels_of(technique, shading, lighting)?)?),
        }
        if let Some(air) = &self.air {
            renderer.fog(&answer, air)?;
        }
        pictures.read()
    }
}

/// Returns the median time of a build and a picture, over some frames.
fn frame_ms(
    opened: &mut Opened,
    world: &World,
    renderer: &Renderer,
    shading: Shading,
    lighting: Lighting,
) -> Result<Option<f64>> {
    let kernels: Kernels = renderer.kernels_of(opened.technique.as_ref(), shading, lighting)?;
    let mut frames_ms = Vec::new();
    for _ in 0..TIMED {
        let Some(build_ns) = opened.rebuild(world)?.device_ns else { return Ok(None) };
        renderer.forget_order();
        let passes: Vec<PassTime> = renderer.draw(&kernels)?;
        let draw_ns = passes.iter().map(|pass| pass.end_ns).fold(0.0, f64::max);
        frames_ms.push(1e-6 * (build_ns + draw_ns));
    }
    frames_ms.sort_by(f64::total_cmp);
    Ok(Some(frames_ms[TIMED / 2]))
}

/// Checks that `--wireframe` has triangles to draw.
pub(in crate::cli) fn lines_spacing(arguments: &Arguments, technique: &str, lighting: Lighting) -> Result<()> {
    match lighting {
        Lighting::Fragment if arguments.wireframe => Err(Error::usage(
            "--wireframe",
            format!("--technique {technique} tessellates nothing"),
            "set lighting=vertex of a technique that has that key",
        )),
        _ => Ok(()),
    }
}

/// Returns the spec of the only technique given.
pub(in crate::cli) fn spec_alone(arguments: &Arguments, what: &str) -> Result<Spec> {
    one_spec(arguments.alone(what)?)
}
