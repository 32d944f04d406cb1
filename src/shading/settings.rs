//! Settings of pictures, as keys that a spec may have in addition to its technique's own.

use super::Lighting;
use crate::Result;
use crate::gpu::Features;
use crate::technique::keys::{word_of, words};
use crate::technique::runs::{self, List};
use crate::technique::settings::{Keyed, Setting, settings};
use crate::technique::{Entry, Key, Spec};

words! {
    /// Where the picture's casters look up their light.
    pub enum LightingKind {
        /// At each pixel.
        Fragment = "fragment",
        /// At the vertices of tessellated quads.
        Vertex = "vertex",
    }
}

/// Number of storage buffers per shader stage that compute passes need to paint with any technique.
const BUFFERS: u32 = 24;

words! {
    /// How the picture is made.
    pub enum PainterKind {
        /// By compute passes.
        Compute = "compute",
        /// By the rasterizer, with blending.
        Raster = "raster",
    }
}

impl PainterKind {
    /// Returns the painter's word in specs.
    pub fn word(self) -> &'static str {
        word_of(self)
    }

    /// Returns the default painter, which is faster on most devices of this kind.
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
        /// Once per pixel, tile by tile, from one bit per light that tells whether the light is shadowed.
        Tiled = "tiled",
        /// Each pixel of a 4 × 4 square queries a different part of the lights; the mean over the square represents all lights.
        Interleaved = "interleaved",
        /// Each pixel queries one light, chosen at random by how much of its light the pixel would reflect, and keeps it from frame to
        /// frame.
        Reservoir = "reservoir",
    }
}

words! {
    /// Where neighbouring pixels look up light, with `shading=tiled`.
    pub enum DitherKind {
        /// All at the same position within a step or a voxel.
        None = "none",
        /// Each pixel of a 4 × 4 square at a different position; the pattern repeats.
        Ordered = "ordered",
        /// At positions that vary like noise over the picture.
        Noise = "noise",
    }
}

words! {
    /// How look-ups are spread over threads, with `shading=tiled`.
    pub enum ShadowsKind {
        /// Each pixel queries its lights, one after another.
        Direct = "direct",
        /// Pairs of a pixel and a light go into a list that threads share evenly.
        Queued = "queued",
    }
}

settings! {
    /// How a picture is lit and shaded.
    #[derive(Copy)]
    pub struct ShadingSettings {
        /// Where the picture's casters look up their light.
        lighting: LightingKind = Setting::word(
            "fragment", "the picture's casters ask for light at each pixel, or at the vertices of tessellated quads");
        /// How the picture is made; `None` chooses the painter that is faster on most devices of this kind.
        painter: Option<PainterKind> = Setting::auto(
            "what makes the picture: compute passes, the rasterizer with blending, or the faster of both on such devices");
        /// How the picture's meshes are shaded. The fields below apply only to tiled shading.
        shading: ShadingKind = Setting::word(
            "forward", "meshes: as drawn, per pixel, in tiles, or per pixel by some of the lights or one");
        /// Where neighbouring pixels look up light.
        dither: DitherKind = Setting::word(
            "ordered", "with shading=tiled, where neighbouring pixels ask: all alike, 4 by 4, or at random").with(TILED.0, TILED.1);
        /// Whether shadows are averaged over 5 × 5 pixels of one surface.
        blur: bool = Setting::word(
            "on", "with shading=tiled, shadows are averaged over 5 by 5 pixels of one surface").with(TILED.0, TILED.1);
        /// Whether shadows are averaged with those of the last frame.
        history: bool = Setting::word(
            "on", "with shading=tiled, shadows are averaged with those of the last frame").with(TILED.0, TILED.1);
        /// How look-ups are spread over threads.
        shadows: ShadowsKind = Setting::word(
            "direct", "with shading=tiled, each pixel asks for its lights, or a list of them is shared out evenly")
            .with(TILED.0, TILED.1);
    }
}

impl ShadingSettings {
    /// Checks that the device supports these settings.
    ///
    /// # Errors
    /// [`crate::Error::Refused`] if the device lacks a feature that these settings need.
    pub fn check(&self, features: &Features) -> Result<()> {
        let painter = self.painter.unwrap_or(PainterKind::usual(features));
        features.require(Lighting::of(self).requires(painter))
    }
}

/// The key and word without which keys of tiled shading are refused.
const TILED: (&str, &str) = ("shading", "tiled");

/// Keys of pictures, which specs of every technique accept.
pub const KEYS: &[Key] = ShadingSettings::KEYS;

/// Parses specs with keys of techniques and of pictures: [`crate::technique::parse`] with [`KEYS`].
///
/// # Errors
/// Same as [`crate::technique::parse`].
pub fn parse(text: &str) -> Result<Vec<Spec>> {
    crate::technique::parse(text, KEYS)
}

/// Returns the specs that run if a command names no technique: [`runs::specs`] with [`KEYS`].
///
/// # Errors
/// Same as [`runs::specs`].
pub fn runs(list: List, on_cpu: bool) -> Result<Vec<Spec>> {
    runs::specs(list, on_cpu, KEYS)
}

/// Returns all keys that a technique's spec may have, the technique's own first.
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

    /// Keys of tiled shading must appear only in specs with tiled shading.
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

    /// Counts the specs that run for many lights: `voxel-grid` in three sizes with seven variants each, some also with other shading, and
    /// one for triangles; shadow maps; rays; and no shadow.
    #[test]
    fn many_lights_have_a_table_of_their_own() {
        for (on_cpu, maps) in [(false, 2), (true, 1)] {
            let specs = runs(|runs| runs.many_lights, on_cpu).expect("they are known");
            let count = |name: &str| specs.iter().filter(|spec| spec.entry.name == name).count();
            // Three sizes with seven variants each; two of these 21 with twelve kinds of shading, one of which is already among the 21.
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
