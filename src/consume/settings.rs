//! Settings of a picture: the keys that specs have besides those of techniques.

use crate::Result;
use crate::technique::keys::words;
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

words! {
    /// How the picture's meshes are shaded.
    pub enum ShadingKind {
        /// In the pass that draws them.
        Forward = "forward",
        /// Once per pixel, from a buffer with the surface that each pixel sees.
        Deferred = "deferred",
        /// The same tile by tile, from a bit per light that says whether it is shadowed.
        Tiled = "tiled",
        /// Each of 4 × 4 pixels asks a part of the lights, and all of them are its neighbours' mean.
        Interleaved = "interleaved",
        /// Each pixel asks one light, drawn by how much it would reflect of it, and keeps it from frame to frame.
        Reservoir = "reservoir",
    }
}

words! {
    /// Where neighbouring pixels ask for light, with `shading=tiled`.
    pub enum DitherKind {
        /// All at the same place of a step or a voxel.
        None = "none",
        /// Each of 4 × 4 at another one, the same over and over.
        Ordered = "ordered",
        /// Everywhere at another one.
        Noise = "noise",
    }
}

words! {
    /// How pixels ask for light, with `shading=tiled`.
    pub enum ShadowsKind {
        /// Each pixel, for one light after the other.
        Direct = "direct",
        /// A list of pixels and lights, evenly spread over threads.
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
        /// How the picture's meshes are shaded. The fields below are of tiles alone.
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
        /// What asks.
        shadows: ShadowsKind = Setting::word(
            "direct", "with shading=tiled, each pixel asks for its lights, or a list of them is shared out evenly")
            .with(TILED.0, TILED.1);
    }
}

/// The keys of tiled shading are allowed only together with this key and word.
const TILED: (&str, &str) = ("shading", "tiled");

/// Keys of pictures, which specs of every technique have.
pub const KEYS: &[Key] = ShadingSettings::KEYS;

/// Reads specs of techniques, and of the pictures of them: [`crate::technique::parse`] with [`KEYS`].
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

/// All keys of specs of a technique, its own first.
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

    /// Keys of tiles stand only in specs with tiles.
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

    /// Six numbers of steps and every voxel, in each of three sizes; maps of each light, rays, and no shadow.
    #[test]
    fn many_lights_have_a_table_of_their_own() {
        for (on_cpu, maps) in [(false, 2), (true, 1)] {
            let specs = runs(|runs| runs.many_lights, on_cpu).expect("they are known");
            let count = |name: &str| specs.iter().filter(|spec| spec.entry.name == name).count();
            // Three sizes with seven ways each, and twelve ways to shade with two of these that are among the seven.
            assert_eq!(["voxel-grid", "shadow-map", "ray-query", "none"].map(count), [21 + 2 * 11, maps, 1, 1]);
            assert_eq!(specs.len(), 45 + maps);
            let mut all: Vec<_> = specs.iter().map(ToString::to_string).collect();
            all.sort();
            all.dedup();
            assert_eq!(all.len(), specs.len(), "{all:?}");
            let of_few = runs(|runs| runs.compare, on_cpu).expect("they are known");
            assert_eq!(of_few.iter().filter(|spec| spec.entry.name == "none").count(), 1);
        }
    }
}
