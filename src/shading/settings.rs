//! Settings of pictures, as keys that a spec may have besides its technique's own.

use super::Lighting;
use crate::Result;
use crate::gpu::Features;
use crate::technique::keys::{word_of, words};
use crate::technique::runs::{self, List};
use crate::technique::settings::{Keyed, Setting, settings};
use crate::technique::{Entry, Key, Spec};

words! {
    /// Where the picture's casters ask for their light.
    pub enum LightingKind {
        /// At each pixel.
        Fragment = "fragment",
        /// At the vertices of tessellated quads.
        Vertex = "vertex",
    }
}

/// Storage buffers per shader stage with which compute passes paint under every technique.
const BUFFERS: u32 = 24;

words! {
    /// What makes the picture.
    pub enum PainterKind {
        /// Compute passes.
        Compute = "compute",
        /// The rasterizer and blending.
        Raster = "raster",
    }
}

impl PainterKind {
    /// Its word in specs.
    pub fn word(self) -> &'static str {
        word_of(self)
    }

    /// What makes the picture where nothing is said: what is faster on most devices of such a kind.
    pub fn usual(features: &Features) -> Self {
        // On lavapipe, quads and blending are faster: docs/notebook/painted.md.
        let draws = features.is_software() || features.max_per_stage_descriptor_storage_buffers < BUFFERS;
        if draws { Self::Raster } else { Self::Compute }
    }
}

words! {
    /// How the picture's meshes are shaded.
    pub enum ShadingKind {
        /// In the pass that draws them.
        Forward = "forward",
        /// Once per pixel, from a buffer with the surface that each pixel sees.
        Deferred = "deferred",
        /// Once per pixel, tile by tile, from one bit per light that says whether the light is shadowed.
        Tiled = "tiled",
        /// Each pixel of a 4 × 4 square asks for a different part of the lights; the mean over the square stands for all lights.
        Interleaved = "interleaved",
        /// Each pixel asks for one light, chosen at random by how much of its light the pixel would reflect, and keeps it from frame to
        /// frame.
        Reservoir = "reservoir",
    }
}

words! {
    /// Where neighbouring pixels ask for light, with `shading=tiled`.
    pub enum DitherKind {
        /// All at the same place within a step or a voxel.
        None = "none",
        /// Each pixel of a 4 × 4 square at a different place; the pattern repeats.
        Ordered = "ordered",
        /// At places that vary like noise over the picture.
        Noise = "noise",
    }
}

words! {
    /// How look-ups are spread over threads, with `shading=tiled`.
    pub enum ShadowsKind {
        /// Each pixel asks for its lights, one after the other.
        Direct = "direct",
        /// Pairs of a pixel and a light go into a list that threads share evenly.
        Queued = "queued",
    }
}

settings! {
    /// How a picture is lit and shaded.
    #[derive(Copy)]
    pub struct ShadingSettings {
        /// Where the picture's casters ask for their light.
        lighting: LightingKind = Setting::word(
            "fragment", "the picture's casters ask for light at each pixel, or at the vertices of tessellated quads");
        /// What makes the picture; none: the one that is faster on most devices of a kind.
        painter: Option<PainterKind> = Setting::auto(
            "what makes the picture: compute passes, the rasterizer with blending, or the faster of both on such devices");
        /// How the picture's meshes are shaded. The fields below are for tiled shading alone.
        shading: ShadingKind = Setting::word(
            "forward", "meshes: as drawn, per pixel, in tiles, or per pixel by some of the lights or one");
        /// Where neighbouring pixels ask.
        dither: DitherKind = Setting::word(
            "ordered", "with shading=tiled, where neighbouring pixels ask: all alike, 4 by 4, or at random").with(TILED.0, TILED.1);
        /// Shadows are averaged over 5 × 5 pixels of one surface.
        blur: bool = Setting::word(
            "on", "with shading=tiled, shadows are averaged over 5 by 5 pixels of one surface").with(TILED.0, TILED.1);
        /// Shadows are averaged with those of the last frame.
        history: bool = Setting::word(
            "on", "with shading=tiled, shadows are averaged with those of the last frame").with(TILED.0, TILED.1);
        /// How look-ups are spread over threads.
        shadows: ShadowsKind = Setting::word(
            "direct", "with shading=tiled, each pixel asks for its lights, or a list of them is shared out evenly")
            .with(TILED.0, TILED.1);
    }
}

impl ShadingSettings {
    /// # Errors
    /// [`crate::Error::Refused`] where the device lacks a feature that these settings need.
    pub fn check(&self, features: &Features) -> Result<()> {
        let painter = self.painter.unwrap_or(PainterKind::usual(features));
        features.require(Lighting::of(self).requires(painter))
    }
}

/// The keys of tiled shading are allowed only together with this key and word.
const TILED: (&str, &str) = ("shading", "tiled");

/// Keys of pictures, which specs of every technique have.
pub const KEYS: &[Key] = ShadingSettings::KEYS;

/// Reads specs whose keys are those of techniques and of pictures: [`crate::technique::parse`] with [`KEYS`].
///
/// # Errors
/// As that.
pub fn parse(text: &str) -> Result<Vec<Spec>> {
    crate::technique::parse(text, KEYS)
}

/// The specs that run where a command names no technique: [`runs::specs`] with [`KEYS`].
///
/// # Errors
/// As that.
pub fn runs(list: List, on_cpu: bool) -> Result<Vec<Spec>> {
    runs::specs(list, on_cpu, KEYS)
}

/// All keys that a technique's spec may have, the technique's own first.
pub fn keys(entry: &'static Entry) -> impl Iterator<Item = &'static Key> {
    entry.all_keys().chain(KEYS)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn texts<const N: usize>(spec: &Spec, keys: [&str; N]) -> [String; N] {
        keys.map(|key| spec.variant().get(key).cloned().unwrap_or_default())
    }

    #[test]
    fn specs_and_settings_are_one() {
        crate::technique::settings::tests::goes_both_ways::<ShadingSettings>(&crate::technique::avsm::ENTRY, KEYS);
    }

    /// Keys of tiled shading are only in specs with tiled shading.
    #[test]
    fn tiles_have_keys_of_their_own() {
        let specs = parse("avsm:shading=forward|tiled,dither=none|noise").expect("valid");
        let picked: Vec<_> = specs.iter().map(|s| texts(s, ["shading", "dither", "blur"])).collect();
        assert_eq!(picked, [["forward", "", ""], ["tiled", "none", "on"], ["tiled", "noise", "on"]]);
        let mut spec = parse("avsm").expect("valid").remove(0);
        assert!(!spec.variant().contains_key("history"));
        spec = spec.with(&ShadingSettings { shading: ShadingKind::Tiled, ..Default::default() });
        assert_eq!((texts(&spec, ["history"])[0].as_str(), spec.short().as_str()), ("on", "avsm:shading=tiled"));
    }

    #[test]
    fn keys_of_tiles_are_refused_elsewhere() {
        for text in ["avsm:blur=off", "avsm:shading=deferred,dither=noise"] {
            let error = parse(text).expect_err(text).to_string();
            assert!(error.contains("add shading=tiled") && error.contains(text) && !error.contains('\n'), "{error}");
        }
    }

    /// The specs that are run for many lights: `voxel-grid` in three sizes with seven variants each, some of these also with other shading, and
    /// of triangles; shadow maps; rays; and no shadow.
    #[test]
    fn many_lights_have_a_table_of_their_own() {
        for (on_cpu, maps) in [(false, 2), (true, 1)] {
            let specs = runs(|runs| runs.many_lights, on_cpu).expect("they are known");
            let count = |name: &str| specs.iter().filter(|spec| spec.entry.name == name).count();
            // Three sizes with seven ways each; and two of these 21 with twelve ways to shade, one of which is already among the 21.
            assert_eq!(["voxel-grid", "shadow-map", "ray-query", "none"].map(count), [21 + 2 * 11 + 1, maps, 1, 1]);
            assert_eq!(specs.len(), 46 + maps);
            let mut all: Vec<_> = specs.iter().map(ToString::to_string).collect();
            all.sort();
            all.dedup();
            assert_eq!(all.len(), specs.len(), "{all:?}");
            let of_few = runs(|runs| runs.compare, on_cpu).expect("they are known");
            assert_eq!(of_few.iter().filter(|spec| spec.entry.name == "none").count(), 1);
        }
    }
}
