//! Keys of specs: what may be set, and the types that settings are read into.

use super::Spec;
use crate::maps::{Filter, FilterKind, OpaqueMaps, OpaqueWay};

/// A setting of a technique.
pub struct Key {
    /// Its name.
    pub name: &'static str,
    /// What it may be.
    pub values: Values,
    /// What it is where a spec does not say.
    pub default: &'static str,
    /// One line.
    pub about: &'static str,
}

/// What a setting may be.
pub enum Values {
    /// One of these words, [`Word::WORDS`] of the type that it is read into, or the default word.
    OneOf(&'static [&'static str]),
    /// A whole number in this range, or the default word.
    Number(u32, u32),
    /// A multiple of the first number, from the second to the third.
    Multiple(u32, u32, u32),
    /// The name of a file, or the default word. A comma or a `|` ends it, so that neither can be in the name. The file has the
    /// values of these keys: a spec that names a file has them only where it gives them.
    Path(&'static [&'static str]),
}

/// A type whose values are words in specs.
pub trait Word: Copy + 'static {
    /// Word and value.
    const ALL: &'static [(&'static str, Self)];
    /// The words.
    const WORDS: &'static [&'static str];
}

/// The word that means `value`.
pub fn word_of<T: Word + PartialEq>(value: T) -> &'static str {
    T::ALL.iter().find(|(_, v)| *v == value).map_or("", |(word, _)| word)
}

/// Declares an enum whose values are words in specs.
#[macro_export]
#[doc(hidden)]
macro_rules! __words {
    ($(#[$meta:meta])* $visibility:vis enum $name:ident { $($(#[$variant_meta:meta])* $variant:ident = $word:literal),+ $(,)? }) => {
        $(#[$meta])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        $visibility enum $name { $($(#[$variant_meta])* $variant),+ }

        $crate::technique::keys::word!($name { $($variant = $word),+ });
    };
}

/// Says which words mean the values of a type that is declared elsewhere.
#[macro_export]
#[doc(hidden)]
macro_rules! __word {
    ($name:ident { $($variant:ident = $word:literal),+ $(,)? }) => {
        impl $crate::technique::keys::Word for $name {
            const ALL: &'static [(&'static str, Self)] = &[$(($word, Self::$variant)),+];
            const WORDS: &'static [&'static str] = &[$($word),+];
        }
    };
}

pub use crate::{__word as word, __words as words};

word!(OpaqueWay { Raster = "raster", Compute = "compute" });

word!(FilterKind { Bilinear = "bilinear", Box = "box", Gaussian = "gaussian" });

words! {
    /// Yes or no.
    pub enum Switch {
        /// Yes.
        On = "on",
        /// No.
        Off = "off",
    }
}

words! {
    /// Where the picture's casters ask for their light.
    pub enum LightingKind {
        /// At each pixel.
        Fragment = "fragment",
        /// At the vertices of tessellated quads.
        Vertex = "vertex",
    }
}

/// Of every technique with maps of any size.
pub const SIZE: Key =
    Key { name: "size", values: Values::Number(1, 16384), default: "256", about: "texels a side of a light's map" };

/// How a look-up averages texels.
pub const FILTER: Key = Key {
    name: "filter",
    values: Values::OneOf(FilterKind::WORDS),
    default: "bilinear",
    about: "how a look-up weighs texels: the nearest four, or all within a radius",
};

/// How far it reaches.
pub const RADIUS: Key = Key {
    name: "radius",
    values: Values::Number(1, 8),
    default: "2",
    about: "texels that the box and the Gaussian reach; the Gaussian's deviation is half of it",
};

/// How many comparisons a look-up of opaque shadows averages (Reeves, Salesin and Cook 1987).
pub const PCF: Key = Key {
    name: "filter",
    values: Values::OneOf(&["1", "3", "5", "7", "9"]),
    default: "1",
    about: "texels a side of the square whose comparisons a look-up averages",
};

/// Who draws the meshes as a light sees them.
pub const OPAQUE: Key = Key {
    name: "opaque",
    values: Values::OneOf(OpaqueWay::WORDS),
    default: "auto",
    about: "opaque maps are drawn by the device's rasterizer, or in compute, all maps at once; auto: compute on GPUs",
};

/// Whether work is left out.
pub const SKIP: Key = Key {
    name: "skip",
    values: Values::OneOf(Switch::WORDS),
    default: "on",
    about: "leave out casters and tiles that no look-up misses, and builds where nothing has changed",
};

/// Read by whoever draws the picture.
pub const LIGHTING: Key = Key {
    name: "lighting",
    values: Values::OneOf(LightingKind::WORDS),
    default: "fragment",
    about: "the picture's casters ask for light at each pixel, or at the vertices of tessellated quads",
};

words! {
    /// How the picture's meshes are shaded.
    pub enum ShadingKind {
        /// In the pass that draws them.
        Forward = "forward",
        /// Once a pixel, from a buffer of what is seen.
        Deferred = "deferred",
        /// The same tile by tile, from a bit a light that says whether it is shadowed.
        Tiled = "tiled",
        /// Each of 4 × 4 pixels asks a part of the lights, and all of them are its neighbours' mean.
        Interleaved = "interleaved",
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
    /// Who asks for light, with `shading=tiled`.
    pub enum ShadowsKind {
        /// Each pixel, for one light after the other.
        Direct = "direct",
        /// A list of pixels and lights, evenly spread over threads.
        Queued = "queued",
    }
}

/// Read by whoever draws the picture.
pub const SHADING: Key = Key {
    name: "shading",
    values: Values::OneOf(ShadingKind::WORDS),
    default: "forward",
    about: "meshes are shaded as drawn, once a pixel, in tiles, or by a part of the lights a pixel",
};

/// Keys that a spec has with `shading=tiled` alone.
pub const TILED: &[Key] = &[
    Key {
        name: "dither",
        values: Values::OneOf(DitherKind::WORDS),
        default: "ordered",
        about: "with shading=tiled, where neighbouring pixels ask: all alike, 4 by 4, or at random",
    },
    Key {
        name: "blur",
        values: Values::OneOf(Switch::WORDS),
        default: "on",
        about: "with shading=tiled, shadows are averaged over 5 by 5 pixels of one surface",
    },
    Key {
        name: "history",
        values: Values::OneOf(Switch::WORDS),
        default: "on",
        about: "with shading=tiled, shadows are averaged with those of the last frame",
    },
    Key {
        name: "shadows",
        values: Values::OneOf(ShadowsKind::WORDS),
        default: "direct",
        about: "with shading=tiled, each pixel asks for its lights, or a list of them is shared out evenly",
    },
];

/// Keys that every technique has, besides [`TILED`].
pub const EVERY: &[Key] = &[SKIP, LIGHTING, SHADING];

/// The opaque maps that techniques share, drawn as [`OPAQUE`] says.
pub fn opaque(spec: &Spec) -> OpaqueMaps {
    OpaqueMaps::shared(spec.word(OPAQUE.name))
}

/// What [`FILTER`] and [`RADIUS`] say.
pub fn filter(spec: &Spec) -> Filter {
    Filter { kind: spec.word(FILTER.name).unwrap_or(FilterKind::Bilinear), radius: spec.number(RADIUS.name) }
}
