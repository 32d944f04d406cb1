//! How the meshes of a picture are shaded.

use crate::technique::Spec;
use crate::technique::keys::{DitherKind, SHADING, ShadingKind, ShadowsKind};

/// How meshes are shaded. Forward and deferred pictures are the same.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shading {
    /// In the pass that draws them.
    Forward,
    /// Once a pixel, from a buffer of albedo, normal and distance.
    Deferred,
    /// The same in tiles, each with the lights that reach it, from a bit a light that says whether it is shadowed.
    Tiled(Tiled),
    /// Once a pixel, by a part of the lights: each of 4 × 4 pixels has one of its own, and what they find is averaged over those
    /// that see the same surface.
    Interleaved,
}

/// What there is to choose of [`Shading::Tiled`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Tiled {
    /// Where neighbouring pixels ask for light.
    pub dither: DitherKind,
    /// Shadows are averaged over the pixels about.
    pub blur: bool,
    /// Shadows are averaged with those of the last frame.
    pub history: bool,
    /// Who asks.
    pub shadows: ShadowsKind,
}

impl Default for Tiled {
    fn default() -> Self {
        Self { dither: DitherKind::Ordered, blur: true, history: true, shadows: ShadowsKind::Direct }
    }
}

impl Tiled {
    /// Each pixel's own bits and nothing else: the deferred picture, where answers are one bit.
    pub const BARE: Self = Self { dither: DitherKind::None, blur: false, history: false, shadows: ShadowsKind::Direct };
}

impl Shading {
    /// What `shading=` of a spec says, and the keys about tiles.
    pub fn of(spec: &Spec) -> Self {
        match spec.word(SHADING.name) {
            Some(ShadingKind::Deferred) => Self::Deferred,
            Some(ShadingKind::Interleaved) => Self::Interleaved,
            Some(ShadingKind::Tiled) => Self::Tiled(Tiled {
                dither: spec.word("dither").unwrap_or(DitherKind::Ordered),
                blur: spec.is_on("blur"),
                history: spec.is_on("history"),
                shadows: spec.word("shadows").unwrap_or(ShadowsKind::Direct),
            }),
            _ => Self::Forward,
        }
    }

    /// How often a picture of what stands still is drawn until it no longer changes.
    pub fn frames_to_settle(self) -> usize {
        match self {
            Self::Tiled(Tiled { history: true, .. }) => 2,
            _ => 1,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::technique::parse;

    #[test]
    fn specs_say_how_meshes_are_shaded() {
        let of = |text: &str| Shading::of(&parse(text).expect(text)[0]);
        assert_eq!((of("avsm"), of("avsm:shading=deferred")), (Shading::Forward, Shading::Deferred));
        assert_eq!(of("avsm:shading=interleaved"), Shading::Interleaved);
        assert_eq!(of("avsm:shading=tiled"), Shading::Tiled(Tiled::default()));
        let bare = "avsm:shading=tiled,dither=none,blur=off,history=off";
        assert_eq!(of(bare), Shading::Tiled(Tiled::BARE));
        let queued = Tiled { shadows: ShadowsKind::Queued, dither: DitherKind::Noise, ..Tiled::default() };
        assert_eq!(of("avsm:shading=tiled,shadows=queued,dither=noise"), Shading::Tiled(queued));
    }
}
