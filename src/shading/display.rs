//! Pictures for display: a sky behind the picture, a ground that fades out, smooth normals, many samples per pixel and a filmic tone curve.
//! These are separate passes, which measured pictures do without. Twin: reference::truth::shown.

use super::Renderer;
use crate::Result;
use crate::gpu::{
    Blend, Buffer, Commands, Constants, Context, Format, Graphics, Image, ImageUse, Kernel, Memory, Target, push_struct,
};
use crate::scene::{Backdrop, Picture, Show, smooth_normals};
use crate::shaders::{set, shading as shaders};
use crate::world::{CameraPush, World};

/// Pixels per side of a workgroup.
const BLOCK: u32 = 8;

push_struct! {
    /// Twin: BackdropPush in glsl/shading/backdrop.glsl.
    struct BackdropPush {
        up: [f32; 3],
        sun: [f32; 3],
        sunlight: [f32; 3],
        horizon: [f32; 3],
        zenith: [f32; 3],
        middle: [f32; 3],
        fade_begin: f32,
        fade_end: f32,
        thick: f32,
    }
}

push_struct! {
    /// Twin: TonemapPush in glsl/shading/tonemap.comp.
    struct TonemapPush {
        grid: [u32; 2],
        size: [u32; 2],
        exposure: f32,
    }
}

impl BackdropPush {
    fn of(backdrop: &Backdrop) -> Self {
        let Backdrop { up, sun, sunlight, horizon, zenith, middle, fade: [fade_begin, fade_end], thick } = *backdrop;
        Self { up, sun, sunlight, horizon, zenith, middle, fade_begin, fade_end, thick }
    }
}

/// Kernel and buffers of the backdrop, which pictures for display show between the meshes and the casters.
pub(super) struct DisplayState {
    backdrop: Kernel<BackdropPush>,
    push: BackdropPush,
    /// Normals at each triangle's corners; `None` if all meshes have only sharp edges.
    pub(super) normals: Option<Buffer>,
}

impl DisplayState {
    /// Updates the sun, which may have moved; the ground's fade stays the same.
    pub(super) fn look(&mut self, world: &World) -> Result<()> {
        let BackdropPush { sun, sunlight, horizon, zenith, .. } = BackdropPush::of(&Backdrop::of(world.scene()?));
        self.push = BackdropPush { sun, sunlight, horizon, zenith, ..self.push };
        Ok(())
    }
}

/// Writes smooth normals into a G-buffer.
pub(super) struct Smooth(Kernel<CameraPush>);

impl Smooth {
    /// Both `numbers` and `seen` can hold the triangle that each pixel sees; `constants` selects the one to read.
    pub(super) fn new(
        renderer: &Renderer,
        (numbers, corners): (&Image, &Buffer),
        seen: &Buffer,
        constants: &Constants,
    ) -> Result<Self> {
        let (distances, normals) = (&renderer.targets.distance, &renderer.targets.normal);
        let sets = set::PictureSmooth { numbers, distances, normals, corners, seen };
        let bindings = sets.bind(&renderer.context, "picture.smooth")?;
        let all = [&renderer.scene.set, &bindings];
        Ok(Self(Kernel::compute(&renderer.context, &shaders::SMOOTH, &all, constants)?))
    }

    pub(super) fn record(&self, commands: &mut Commands, push: &CameraPush) {
        let groups = push.size.map(|side| side.div_ceil(BLOCK));
        commands.pass("shading.smooth", |pass| pass.dispatch(&self.0, push, [groups[0], groups[1], 1]));
    }
}

impl Renderer {
    /// Adds a sky, a ground that fades into it and smooth normals to pictures from now on. [`Backdrop::of`] derives sky and ground from the
    /// world's scene. Kernels that [`Renderer::kernels`] created before do not change.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] if memory runs out or the driver rejects a shader; [`crate::Error::Refused`] if the host knows no scene.
    pub fn show(&mut self, world: &World) -> Result<()> {
        let scene = world.scene()?;
        let state = Graphics {
            vertex: &shaders::FULLSCREEN_VERT,
            fragment: &shaders::BACKDROP_FRAG,
            colors: &[(self.targets.format, Blend::Over)],
            depth: None,
        };
        // The pass queries no technique. Its sets have numbers before and after the technique's, so some set must be bound in between.
        let sets = [&self.scene.set, &self.targets.distances, &self.targets.distances];
        let backdrop = Kernel::graphics(&self.context, &state, &sets, &Constants::new())?;
        let normals: Vec<[f32; 3]> = scene.meshes.iter().flat_map(smooth_normals).flatten().collect();
        let is_round = normals.chunks_exact(3).any(|corners| corners[0] != corners[1] || corners[1] != corners[2]);
        let buffer = || {
            let buffer = Buffer::new(&self.context, "picture.corners", 12 * normals.len() as u64, Memory::Device)?;
            buffer.write(&normals).map(|()| buffer)
        };
        let normals = if is_round { Some(buffer()?) } else { None };
        self.display = Some(DisplayState { backdrop, push: BackdropPush::of(&Backdrop::of(scene)), normals });
        Ok(())
    }

    /// Draws the sky behind the meshes.
    pub(super) fn backdrop(&self, commands: &mut Commands) {
        let Some(shown) = &self.display else { return };
        commands.pass("shading.backdrop", |pass| {
            let colors = [Target { image: &self.targets.color, clear: None }];
            pass.render(self.targets.color.size(), &colors, None, |draw| draw.draw(&shown.backdrop, &shown.push, 3, 1));
        });
    }
}

/// Turns the picture of all samples into the finished picture for display.
pub struct Tonemapped {
    context: Context,
    kernel: Kernel<TonemapPush>,
    push: TonemapPush,
    shown: Image,
}

impl Tonemapped {
    /// Creates the pass for pictures of `renderer`, with the samples per pixel and the exposure of `show`.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] if memory runs out.
    pub fn new(renderer: &Renderer, show: &Show) -> Result<Self> {
        let context = &renderer.context;
        let sampled = renderer.targets.color.size();
        let size = [0, 1].map(|i| sampled[i] / show.grid[i]);
        let shown = Image::new(context, "picture.shown", Format::R32G32B32A32_SFLOAT, size, ImageUse::Storage)?;
        let bindings = set::PictureTonemapped { samples: &renderer.targets.color, shown: &shown }
            .bind(context, "picture.tonemapped")?;
        let kernel = Kernel::compute(context, &shaders::TONEMAP, &[&bindings], &Constants::new())?;
        let push = TonemapPush { grid: show.grid, size, exposure: show.stops.exp2() };
        Ok(Self { context: context.clone(), kernel, push, shown })
    }

    /// Records the pass, which must run after the passes that draw.
    pub fn record(&self, commands: &mut Commands) {
        let groups = self.push.size.map(|side| side.div_ceil(BLOCK));
        commands.pass("shading.tonemap", |pass| pass.dispatch(&self.kernel, &self.push, [groups[0], groups[1], 1]));
    }

    /// Returns the finished picture on the device, in linear RGB from 0 to 1.
    pub fn image(&self) -> &Image {
        &self.shown
    }

    /// Tone-maps the last picture, and reads it back.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] if the device is lost.
    pub fn picture(&self) -> Result<Picture> {
        self.context.submit(|commands| self.record(commands))?;
        let pixels = self.shown.read::<[f32; 4]>()?.into_iter().map(|[r, g, b, _]| [r, g, b]).collect();
        let [width, height] = self.push.size;
        Ok(Picture { width, height, pixels })
    }
}
