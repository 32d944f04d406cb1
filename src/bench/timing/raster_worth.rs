//! Times the same work in a device's rasterizer and in compute shaders, for reports that compare hardware features.

use crate::Result;
use crate::bench::Timing;
use crate::bench::timing::stage_rates::stage_rates;
use crate::gpu::{
    Blend, Constants, Context, Format, Graphics, Image, ImageUse, Kernel, Pass, PassTime, Requirement, Target,
    push_struct,
};
use crate::shaders::{bench as shaders, set};
use serde::Serialize;

/// Pixels per side of the picture, and texels per side and layers of the volume. A software device uses fewer.
const SIDE: u32 = 1024;
const SIDE_ON_CPU: u32 = 256;
const VOLUME: u32 = 256;
const VOLUME_ON_CPU: u32 = 64;
const VOLUME_LAYERS: u32 = 64;

/// Number of overlapping layers, and the opacity of each.
pub const LAYERS: u32 = 16;
/// See [`LAYERS`].
pub const OPACITY: f32 = 0.25;

/// Number of timed runs, of which the median counts; one more run precedes them and is not counted.
const RUNS: usize = 8;

push_struct! {
    /// Twin: LayersPush in glsl/bench/layers.glsl.
    struct LayersPush {
        layers: u32,
        opacity: f32,
    }
}

/// Times of one kind of work, in the rasterizer and in a compute shader.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RasterWork {
    /// Name of the work.
    pub name: &'static str,
    /// Device time when drawn, in nanoseconds; `None` if the device cannot draw it.
    pub raster_ns: Option<f64>,
    /// Device time in compute, in nanoseconds; `None` if only a ratio is known.
    pub compute_ns: Option<f64>,
    /// `raster_ns` divided by `compute_ns`, or a ratio measured directly.
    pub ratio: Option<f64>,
    /// The feature the device would need to draw it.
    pub needs: Option<&'static str>,
}

impl RasterWork {
    fn of(name: &'static str, [raster_ns, compute_ns]: [Option<f64>; 2], needs: Option<&'static str>) -> Self {
        let ratio = raster_ns.zip(compute_ns).map(|(raster, compute)| raster / compute.max(1.0));
        Self { name, raster_ns, compute_ns, ratio, needs }
    }
}

/// Pictures of overlapping layers, one per way of compositing them.
pub struct LayeredPictures {
    context: Context,
    side: u32,
    drawn: Image,
    computed: Image,
    draw: Kernel<LayersPush>,
    compute: Kernel<LayersPush>,
    interlocked: Option<Kernel<LayersPush>>,
}

/// A way of compositing overlapping layers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LayerWay {
    /// Blending.
    Blended,
    /// A compute shader, one thread per pixel.
    Computed,
    /// A fragment shader with interlock.
    Interlocked,
}

impl LayeredPictures {
    /// Creates pictures of `side` × `side` pixels; `side` is a multiple of 8.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] if memory runs out or the driver rejects a shader.
    pub fn new(context: &Context, side: u32) -> Result<Self> {
        let half = !context.features().float32_blend;
        let format = if half { Format::R16G16B16A16_SFLOAT } else { Format::R32G32B32A32_SFLOAT };
        let drawn = Image::new(context, "layers.drawn", format, [side; 2], ImageUse::Color)?;
        let floats = Format::R32G32B32A32_SFLOAT;
        let computed = Image::new(context, "layers.computed", floats, [side; 2], ImageUse::Storage)?;
        let set = set::Layered { layered: &computed }.bind(context, "layers")?;
        let vertex = &shaders::LAYERS_VERT;
        let colors = [(format, Blend::Over)];
        let blended = Graphics { vertex, fragment: &shaders::LAYERS_FRAG, colors: &colors, depth: None };
        let stores = Graphics { vertex, fragment: &shaders::INTERLOCKED_FRAG, colors: &[], depth: None };
        let interlocked = match interlock_needs(context) {
            None => Some(Kernel::graphics(context, &stores, &[&set], &Constants::new())?),
            Some(_) => None,
        };
        Ok(Self {
            context: context.clone(),
            side,
            draw: Kernel::graphics(context, &blended, &[], &Constants::new())?,
            compute: Kernel::compute(context, &shaders::LAYERS, &[&set], &Constants::new())?,
            interlocked,
            drawn,
            computed,
        })
    }

    /// Composites `layers` layers over black. Returns nanoseconds, or `None` if the device has no timestamps or does not support this way.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] if the device is lost.
    pub fn run(&self, way: LayerWay, layers: u32) -> Result<Option<f64>> {
        let (size, push) = ([self.side; 2], LayersPush { layers, opacity: OPACITY });
        let work = |pass: &mut Pass| match (way, &self.interlocked) {
            (LayerWay::Blended, _) => {
                let target = [Target { image: &self.drawn, clear: None }];
                pass.render(size, &target, None, |draw| draw.draw(&self.draw, &push, 3, layers));
            }
            (LayerWay::Computed, _) => pass.dispatch(&self.compute, &push, [self.side / 8, self.side / 8, 1]),
            (LayerWay::Interlocked, Some(kernel)) => {
                pass.render(size, &[], None, |draw| draw.draw(kernel, &push, 3, layers));
            }
            (LayerWay::Interlocked, None) => {}
        };
        if way == LayerWay::Interlocked && self.interlocked.is_none() {
            return Ok(None);
        }
        let image = if way == LayerWay::Blended { &self.drawn } else { &self.computed };
        let passes = self.context.submit(|commands| {
            commands.pass("bench.clear", |pass| pass.clear_volume(image, 0.0));
            commands.pass("bench.layers", work);
        })?;
        Ok(passes.last().map(ns))
    }

    /// Returns red, green, blue and alpha of the last picture, row by row; `None` for one blended in half floats.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] if the device is lost.
    pub fn read(&self, way: LayerWay) -> Result<Option<Vec<[f32; 4]>>> {
        match way {
            LayerWay::Blended if !self.context.features().float32_blend => Ok(None),
            LayerWay::Blended => self.drawn.read().map(Some),
            _ => self.computed.read().map(Some),
        }
    }
}

/// Returns the feature that the device lacks for layers with interlock.
fn interlock_needs(context: &Context) -> Option<&'static str> {
    [Requirement::PixelInterlock, Requirement::FragmentStores].iter().find_map(|need| context.features().lacks(*need))
}

fn ns(pass: &PassTime) -> f64 {
    pass.end_ns - pass.start_ns
}

fn median(mut run: impl FnMut() -> Result<Option<f64>>) -> Result<Option<f64>> {
    let mut samples = Vec::new();
    for i in 0..=RUNS {
        let ns = run()?;
        samples.extend(ns.filter(|_| i > 0));
    }
    Ok(Timing::of(&samples).map(|time| time.median))
}

/// Times clearing all layers of a volume, by the driver and by a compute shader.
fn clears(context: &Context, [side, layers]: [u32; 2]) -> Result<[Option<f64>; 2]> {
    let volume = Image::volume(context, "layers.volume", Format::R32_SFLOAT, [side, side, layers], false)?;
    let set = set::ClearLayers { volume: &volume }.bind(context, "layers.clear")?;
    let kernel: Kernel = Kernel::compute(context, &shaders::CLEAR_LAYERS, &[&set], &Constants::new())?;
    let groups = [side / 8, side / 8, layers];
    let driver = || {
        let passes = context.submit(|commands| commands.pass("bench.clear", |pass| pass.clear_volume(&volume, 1.0)))?;
        Ok(passes.last().map(ns))
    };
    let shader = || {
        let passes = context
            .submit(|commands| commands.pass("bench.clear_layers", |pass| pass.dispatch(&kernel, &(), groups)))?;
        Ok(passes.last().map(ns))
    };
    Ok([median(driver)?, median(shader)?])
}

/// Times each kind of work: filling pixels, fragment-shader arithmetic, blending layers, clearing layers, and layers with interlock.
///
/// # Errors
/// [`crate::Error::Gpu`] if memory runs out or the device is lost.
pub fn raster_worth(context: &Context) -> Result<Vec<RasterWork>> {
    let software = context.features().is_software();
    let (side, texels) = if software { (SIDE_ON_CPU, VOLUME_ON_CPU) } else { (SIDE, VOLUME) };
    let pictures = LayeredPictures::new(context, side)?;
    let timed = |way, layers| median(|| pictures.run(way, layers));
    let both = |way, layers| -> Result<_> { Ok([timed(way, layers)?, timed(LayerWay::Computed, layers)?]) };
    let arithmetic = stage_rates(context)?;
    let rates = RasterWork::of("arithmetic in fragments", [None; 2], None);
    Ok(vec![
        RasterWork::of("filling pixels", both(LayerWay::Blended, 1)?, None),
        RasterWork { ratio: arithmetic.map(|rates| rates.fragment_slowdown), ..rates },
        RasterWork::of("blending 16 layers", both(LayerWay::Blended, LAYERS)?, None),
        RasterWork::of("clearing 64 layers", clears(context, [texels, VOLUME_LAYERS])?, None),
        RasterWork::of("16 layers with interlock", both(LayerWay::Interlocked, LAYERS)?, interlock_needs(context)),
    ])
}
