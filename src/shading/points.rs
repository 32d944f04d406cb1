//! Particles in motion, drawn from a buffer that passes on the device write: one triangle each, colored by speed or density, on top of the
//! picture's meshes. They need no sorting, so nothing is read back from the device.

use super::{Kernels, Renderer};
use crate::Result;
use crate::gpu::{
    Blend, Buffer, Commands, Constants, Format, Graphics, Image, ImageUse, Kernel, PassTime, Target, push_struct,
};
use crate::query::colored;
use crate::shaders::set;
use crate::shaders::{constant, shading as shaders};
use crate::technique::Answer;

/// Meaning of the particles' colors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Colors {
    /// The speed of each particle, lit by a technique.
    Speed {
        /// The speed that gets the last color of the ramp.
        fastest: f32,
    },
    /// No meaning: each particle is as white as smoke, so that only light and shadow show.
    Light,
    /// The number of particles that cover a pixel.
    Density {
        /// The number of particles over a pixel at which its color is 63 % of the way to the dense color.
        many: f32,
    },
}

/// Colors by speed, from slow to fast, linear RGB. Twin: RAMP in glsl/shading/points.frag.
const RAMP: [[f32; 3]; 4] = [[0.02, 0.10, 0.45], [0.03, 0.55, 0.65], [0.95, 0.80, 0.25], [1.0, 0.22, 0.06]];

/// Twins: THIN, THICK in glsl/shading/density.frag.
const DENSITIES: [[f32; 3]; 2] = [[0.04, 0.22, 0.50], [0.93, 0.98, 1.0]];

fn mixed(from: [f32; 3], to: [f32; 3], share: f32) -> [f32; 3] {
    [0, 1, 2].map(|i| from[i] + share * (to[i] - from[i]))
}

impl Colors {
    /// Returns the color for a speed, or for a number of particles over a pixel, in linear RGB; `None` with
    /// [`Colors::Light`].
    pub fn of(self, number: f32) -> Option<[f32; 3]> {
        match self {
            Self::Speed { fastest } => {
                let at = 3.0 * (number / fastest).clamp(0.0, 1.0);
                let first = (at as usize).min(2);
                Some(mixed(RAMP[first], RAMP[first + 1], at - first as f32))
            }
            Self::Light => None,
            Self::Density { many } => Some(mixed(DENSITIES[0], DENSITIES[1], 1.0 - (-number / many).exp())),
        }
    }

    /// Returns colors by density for `count` particles of at most this radius, in world units. Both set the scale.
    pub fn density(count: u32, radius: f32) -> Self {
        Self::Density { many: DENSE * count as f32 * radius * radius }
    }
}

push_struct! {
    /// Twin: PointsPush in glsl/shading/points.frag.
    struct PointsPush { fastest: f32 }
}

push_struct! {
    /// Twin: DensityPush in glsl/shading/density.frag.
    struct DensityPush { many: f32 }
}

/// Distance from a triangle's centre to its corners when colored by speed, as a multiple of the particle's radius. It is small, so that
/// particles hide little of each other.
const SPECK: f32 = 0.5;

/// Factor from the sum of all particles' squared radii to [`Colors::Density`]'s `many`.
const DENSE: f32 = 0.17;

/// Kernels that draw particles in motion.
pub struct Points {
    vertices: u32,
    way: BuildPath,
}

enum BuildPath {
    Speed(Kernel<PointsPush>, PointsPush),
    Density { counts: Image, count: Kernel, density: Kernel<DensityPush>, push: DensityPush },
}

impl Renderer {
    /// Creates the kernels that draw the first `count` of `bodies` ([`crate::scene::Body`]), lit by `answer`.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] if memory runs out or the driver rejects a shader.
    pub fn points(&self, answer: &Answer, bodies: &Buffer, count: u32, colors: Colors) -> Result<Points> {
        let set =
            set::PicturePoints { bodies, distances: &self.targets.distance }.bind(&self.context, "picture.points")?;
        let sets = [&self.scene.set, answer.bindings, &set];
        let vertex = &shaders::POINTS_VERT;
        let way = match colors {
            Colors::Speed { .. } | Colors::Light => {
                let fastest = if let Colors::Speed { fastest } = colors { fastest } else { 0.0 };
                let colors = [(self.targets.format, Blend::None)];
                let fragment = shaders::POINTS_FRAG.of(answer.folder);
                let state = Graphics { vertex, fragment, colors: &colors, depth: Some(Format::D32_SFLOAT) };
                let constants = colored(answer.constants, self.kinds.extinction_ratio).set(constant::POINT_SIZE, SPECK);
                let kernel = Kernel::graphics(&self.context, &state, &sets, &constants)?;
                BuildPath::Speed(kernel, PointsPush { fastest })
            }
            Colors::Density { many } => {
                let size = self.targets.color.size();
                let counts = Image::new(&self.context, "picture.counts", self.targets.format, size, ImageUse::Color)?;
                let counted = set::PictureCounted { counts: &counts }.bind(&self.context, "picture.counted")?;
                let colors = [(self.targets.format, Blend::Add)];
                let state = Graphics { vertex, fragment: &shaders::COUNT_FRAG, colors: &colors, depth: None };
                let adding = Kernel::graphics(&self.context, &state, &sets, &Constants::new())?;
                let colors = [(self.targets.format, Blend::Over)];
                let (vertex, fragment) = (&shaders::FULLSCREEN_VERT, &shaders::DENSITY_FRAG);
                let state = Graphics { vertex, fragment, colors: &colors, depth: None };
                let density = Kernel::graphics(&self.context, &state, &[&counted], &Constants::new())?;
                BuildPath::Density { counts, count: adding, density, push: DensityPush { many } }
            }
        };
        Ok(Points { vertices: 3 * count, way })
    }

    /// Draws the meshes, lit by a technique, and the particles on top; the picture stays on the device. Returns the time of each pass.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] if the device is lost.
    pub fn draw_points(&self, kernels: &Kernels, points: &Points) -> Result<Vec<PassTime>> {
        self.frame(kernels, |commands| self.record_points(commands, points))
    }

    /// Records the passes that draw the particles on top of the last picture recorded.
    pub fn record_points(&self, commands: &mut Commands, points: &Points) {
        match &points.way {
            BuildPath::Speed(kernel, push) => self.speeds(commands, kernel, push, points.vertices),
            BuildPath::Density { counts, count, density, push } => {
                self.count(commands, counts, count, points.vertices);
                self.density(commands, density, push);
            }
        }
    }

    /// Returns how many particles cover each pixel of the last picture, with rows from the top; empty unless colored by
    /// density.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] if they cannot be read back.
    pub fn counts(&self, points: &Points) -> Result<Vec<f32>> {
        let BuildPath::Density { counts, .. } = &points.way else { return Ok(Vec::new()) };
        Ok(self.read_colors(counts)?.into_iter().map(|[count, _, _]| count).collect())
    }

    fn speeds(&self, commands: &mut Commands, kernel: &Kernel<PointsPush>, push: &PointsPush, vertices: u32) {
        commands.pass("shading.points", |pass| {
            let colors = [Target { image: &self.targets.color, clear: None }];
            let depth = Target { image: &self.targets.depth, clear: None };
            pass.render(self.targets.color.size(), &colors, Some(depth), |draw| draw.draw(kernel, push, vertices, 1));
        });
    }

    fn count(&self, commands: &mut Commands, counts: &Image, kernel: &Kernel, vertices: u32) {
        commands.pass("shading.count", |pass| {
            let colors = [Target { image: counts, clear: Some([0.0; 4]) }];
            pass.render(self.targets.color.size(), &colors, None, |draw| draw.draw(kernel, &(), vertices, 1));
        });
    }

    fn density(&self, commands: &mut Commands, kernel: &Kernel<DensityPush>, push: &DensityPush) {
        commands.pass("shading.density", |pass| {
            let colors = [Target { image: &self.targets.color, clear: None }];
            pass.render(self.targets.color.size(), &colors, None, |draw| draw.draw(kernel, push, 3, 1));
        });
    }
}
