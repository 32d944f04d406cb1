//! The error sampler: computes the truth of a scene in each frame, and the errors of a technique's answers and pictures.

use crate::Result;
use crate::bench::case::camera_sweep::{references, sweep};
use crate::bench::case::device_scene::DeviceScene;
use crate::bench::case::frame_truths::FrameTruths;
use crate::bench::case::frames::Traced;
use crate::bench::case::picture_settings::PictureSettings;
use crate::bench::case::points::ask;
use crate::bench::case::sampled_errors::{SampledErrors, moments};
use crate::bench::case::truth::{LitPicture, Points, Truth};
use crate::bench::error::flicker::Flicker;
use crate::bench::error::footprint::{FootprintError, Footprints, footprint_errors, footprints};
use crate::bench::error::picture_error::bounce_error;
use crate::bench::{Answers, Extent, FramesError, ImageError, picture_error};
use crate::query::{PointBatch, Query};
use crate::reference::truth::{Bounce, Casters, bounce};
use crate::scene::{Picture, Resolution, View};
use crate::technique::{Opened, Technique};
use std::cell::OnceCell;

/// See the module documentation.
pub(in crate::bench) struct ErrorSampler<'a> {
    extent: Extent,
    truths: FrameTruths<'a>,
    /// How to trace the bounce of light that virtual lights represent; `None` if pictures are not compared with it.
    traced: Option<Traced<'a>>,
    /// The traced bounce of light, once computed.
    bounce: OnceCell<Bounce>,
    /// Reference pictures of consecutive frames of the circling camera, once rendered.
    references: OnceCell<Vec<Picture>>,
    /// Means of the truth over areas, once computed.
    footprints: OnceCell<Footprints>,
}

impl<'a> ErrorSampler<'a> {
    pub fn new(extent: Extent, truths: FrameTruths<'a>, traced: Option<Traced<'a>>) -> Self {
        let (bounce, references, footprints) = (OnceCell::new(), OnceCell::new(), OnceCell::new());
        Self { extent, truths, traced, bounce, references, footprints }
    }

    /// Whether there is a truth at all.
    pub fn has_truth(&self) -> bool {
        self.extent != Extent::None
    }

    /// Returns the picture lit by the truth; `None` if it has not been rendered.
    pub fn reference(&self) -> Option<&Picture> {
        let lit = if self.has_truth() { self.truths.picture() } else { None };
        lit.map(|lit| &lit.picture)
    }

    /// Returns the traced bounce of light, if a picture has been compared with it.
    pub fn bounce_picture(&self) -> Option<&Picture> {
        self.bounce.get().map(|bounce| &bounce.picture)
    }

    /// Visits all frames. Measures the seen error and flicker in every frame, and the other errors in some frames.
    pub fn sample(&self, scene: &mut DeviceScene, opened: &mut Opened) -> Result<SampledErrors> {
        let count = self.truths.states.count();
        let (moments, mut sampled, mut flicker) = (moments(count), SampledErrors::default(), Flicker::default());
        for frame in 0..count {
            if count > 1 {
                scene.show(frame)?;
                opened.build(&scene.world)?;
            }
            let technique = opened.technique.as_ref();
            let has_look_up = technique.answer().painter.is_none();
            self.truths.with(frame, |truth| {
                if count > 1 && has_look_up {
                    let watched = answers(scene, technique, truth, truth.watched(), &technique.inspect().resolution())?;
                    flicker.frame(watched, truth.watched(), truth.scene());
                }
                if has_look_up {
                    let seen = truth.seen();
                    sampled.seen.add(seen, &seen.ask(scene.context, &scene.world, technique)?)?;
                }
                let is_wanted = moments.contains(&frame) && self.extent.has_reasons();
                if is_wanted { sample_moment(scene, technique, truth, &mut sampled) } else { Ok(()) }
            })?;
        }
        sampled.flicker_rms = flicker.rms();
        Ok(sampled)
    }

    /// Returns the errors against means of the truth over areas of each size. Each look-up is given the size of its area.
    pub fn footprint_errors(&self, scene: &DeviceScene, technique: &dyn Technique) -> Result<Vec<FootprintError>> {
        let areas = match self.footprints.get() {
            Some(areas) => areas,
            None => {
                let made = self.truths.with(0, |truth| Ok(footprints(truth, truth.scene())))?;
                self.footprints.get_or_init(|| made)
            }
        };
        let batches: Vec<_> =
            areas.points.iter().map(|p| PointBatch { light: p.light, points: &p.positions, normals: &[] }).collect();
        let of = |sides: &Vec<f32>| Query::of_areas(scene.context, &batches, sides)?.ask(&technique.answer());
        let answers: Vec<_> = areas.sides.iter().map(of).collect::<Result<_>>()?;
        Ok(footprint_errors(&answers, areas))
    }

    /// Returns the error of the last frame's `picture`, as `camera` sees it, and the picture at the size of its truth. `None` if no truth
    /// is wanted or it would take too long.
    pub fn picture_error(
        &self,
        scene: &DeviceScene,
        opened: &Opened,
        settings: PictureSettings,
        (camera, picture): (&View, &Picture),
    ) -> Result<Option<(ImageError, Picture)>> {
        let Some(lit) = self.lit()? else { return Ok(None) };
        let drawn = match lit.camera == *camera {
            true => picture.clone(),
            false => scene.picture(&lit.camera, opened, settings)?,
        };
        let mut error = picture_error(&drawn, &lit.picture);
        if let Some(bounce) = self.bounce(&lit.camera) {
            [error.bounce_rmse, error.bounce_noise] = bounce_error(&drawn, bounce).map(Some);
        }
        Ok(Some((error, drawn)))
    }

    /// Returns the seen error and the mean FLIP of pictures without shadows, drawn with `none`.
    pub fn unshadowed(
        &self,
        scene: &DeviceScene,
        none: &Opened,
        settings: PictureSettings,
    ) -> Result<[Option<f64>; 2]> {
        if !self.has_truth() {
            return Ok([None; 2]);
        }
        let seen = self.truths.with(self.truths.states.count() - 1, |truth| truth.seen().unshadowed())?;
        let mut flip_mean = None;
        if let Some(lit) = self.lit()? {
            let drawn = scene.picture(&lit.camera, none, settings)?;
            flip_mean = Some(picture_error(&drawn, &lit.picture).flip_mean);
        }
        Ok([seen.map(|error| error.mean), flip_mean])
    }

    /// Returns the errors of pictures of consecutive frames while the camera circles the scene.
    pub fn frames_error(
        &self,
        scene: &mut DeviceScene,
        opened: &mut Opened,
        settings: PictureSettings,
    ) -> Result<Option<FramesError>> {
        let references = match self.references.get() {
            Some(references) => references,
            None => {
                let made = references(&self.truths.states)?;
                self.references.get_or_init(|| made)
            }
        };
        sweep(scene, opened, settings, references)
    }

    /// Returns the last frame's picture, lit by the truth; `None` if it is not wanted or would take too long.
    fn lit(&self) -> Result<Option<&LitPicture>> {
        self.truths.make_picture()
    }

    /// Returns one bounce of light in the picture lit by the truth, if pictures are compared with it.
    fn bounce(&self, camera: &View) -> Option<&Bounce> {
        let Traced { scene, samples } = self.traced?;
        Some(self.bounce.get_or_init(|| bounce(&Casters::new(scene), scene, camera, samples)))
    }
}

/// Samples the errors in one frame.
fn sample_moment(
    scene: &DeviceScene,
    technique: &dyn Technique,
    truth: &Truth,
    sampled: &mut SampledErrors,
) -> Result<()> {
    let resolution = technique.inspect().resolution();
    let paints = technique.answer().painter.is_some();
    if !paints {
        sampled.space.extend(answers(scene, technique, truth, truth.space(), &resolution)?);
    }
    sampled.surface.extend(answers(scene, technique, truth, truth.surface(), &resolution)?);
    sampled.colors.ask(scene.context, &scene.world, technique, truth)?;
    // A technique without maps has no map error.
    let views: Vec<View> = technique.inspect().maps().iter().map(|m| m.caster_view).collect();
    if !views.is_empty() && !paints {
        let maps = truth.maps(views);
        sampled.map.extend(answers(scene, technique, truth, &maps.maps, &resolution)?);
        sampled.maps.push(maps);
    }
    Ok(())
}

/// Returns a technique's answers at points of all lights, with the truth at these points.
fn answers(
    scene: &DeviceScene,
    technique: &dyn Technique,
    truth: &Truth,
    all: &[Points],
    resolution: &[Resolution],
) -> Result<Answers> {
    let mut answers = Answers { approximate: ask(scene.context, technique, all)?, ..Answers::default() };
    for points in all {
        answers.truth.extend(&points.visibility);
        answers.casters.extend(&points.casters);
        answers.within.extend(truth.boundary(points, resolution).iter());
    }
    Ok(answers)
}
