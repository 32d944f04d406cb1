//! The error sampler: the truth of a scene in each frame, and how far a technique's answers and pictures are from it.

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

/// See the module.
pub(in crate::bench) struct ErrorSampler<'a> {
    extent: Extent,
    truths: FrameTruths<'a>,
    /// How the bounce of light is computed that virtual lights represent; none where pictures are not compared with it.
    traced: Option<Traced<'a>>,
    /// That bounce, once it is computed.
    bounce: OnceCell<Bounce>,
    /// True pictures of consecutive frames, once a camera goes around.
    references: OnceCell<Vec<Picture>>,
    /// Means over areas, once they are needed.
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

    /// The picture lit by the truth; none where it has not been made.
    pub fn reference(&self) -> Option<&Picture> {
        let lit = if self.has_truth() { self.truths.picture() } else { None };
        lit.map(|lit| &lit.picture)
    }

    /// One bounce of light, if pictures were compared with it by now.
    pub fn bounce_picture(&self) -> Option<&Picture> {
        self.bounce.get().map(|bounce| &bounce.picture)
    }

    /// Goes through all frames. Asks in all of them at seen points and for flicker, and in some of them for the other errors.
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

    /// Errors against means over areas of each size; look-ups are told the size.
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

    /// The error of the last frame's `picture`, as `camera` sees it, and the picture at the size of its truth. None where no truth is wanted
    /// or it would take long.
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

    /// The seen error and the mean FLIP of pictures without shadows, which `none` draws.
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

    /// Errors of pictures of consecutive frames, in which the camera goes around.
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

    /// The last frame's picture, lit by the truth; none where none is wanted or it would take long.
    fn lit(&self) -> Result<Option<&LitPicture>> {
        self.truths.make_picture()
    }

    /// One bounce of light in the picture that the truth lights, where it is compared with one.
    fn bounce(&self, camera: &View) -> Option<&Bounce> {
        let Traced { scene, samples } = self.traced?;
        Some(self.bounce.get_or_init(|| bounce(&Casters::new(scene), scene, camera, samples)))
    }
}

/// Asks for errors in one frame.
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

/// Answers at points of all lights, beside the truth there.
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
