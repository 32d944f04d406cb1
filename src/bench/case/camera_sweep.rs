//! Pictures of consecutive frames, compared with the true pictures while the camera circles the scene.

use crate::Result;
use crate::bench::case::device_scene::DeviceScene;
use crate::bench::case::picture_settings::PictureSettings;
use crate::bench::{FramesError, States, picture_error, picture_flicker};
use crate::reference::truth::{Casters, picture};
use crate::scene::{Picture, Scene, View};
use crate::technique::Opened;

/// Size of a picture in pixels: small, since the reference must render every pixel too.
const PICTURE: [u32; 2] = [320, 180];

/// Maximum number of frames compared, counted from the first.
const MOST_FRAMES: usize = 16;

/// Renders the true pictures of the compared frames.
pub(in crate::bench) fn references(states: &States) -> Result<Vec<Picture>> {
    let of = |scene: &Scene| picture(&Casters::new(scene), scene, &View::camera(&scene.camera, scene, PICTURE));
    (0..states.count().min(MOST_FRAMES)).map(|frame| Ok(of(states.at(frame)?.as_ref()))).collect()
}

/// Draws each frame once, in order. Returns the errors against the truth, and the frame-to-frame changes that do not occur in the truth.
/// The first frame is not counted, since no frame precedes it.
pub(in crate::bench) fn sweep(
    scene: &mut DeviceScene,
    opened: &mut Opened,
    settings: PictureSettings,
    references: &[Picture],
) -> Result<Option<FramesError>> {
    let states = scene.frames.states;
    let camera = |frame| states.at(frame).map(|scene| View::camera(&scene.camera, &scene, PICTURE));
    let mut renderer = scene.renderer(&camera(0)?, settings)?;
    let mut pictures = Vec::new();
    for frame in 0..references.len() {
        scene.show(frame)?;
        opened.build(&scene.world)?;
        renderer.look(&scene.world, &camera(frame)?)?;
        renderer.draw(&renderer.kernels_of(opened.technique.as_ref(), settings.shading, settings.lighting)?)?;
        pictures.push(renderer.read()?);
    }
    let later = 1.min(pictures.len());
    let (pictures, references) = (&pictures[later..], &references[later..]);
    let squares = pictures.iter().zip(references).map(|(a, b)| picture_error(a, b).rmse.powi(2));
    let rmse = (squares.sum::<f64>() / pictures.len().max(1) as f64).sqrt();
    Ok(picture_flicker(pictures, references).map(|flicker_rms| FramesError { rmse, flicker_rms }))
}
