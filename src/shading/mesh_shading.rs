//! How the meshes of a picture are shaded.

use super::reservoir::MOST_FRAMES;
use super::settings::{DitherKind, ShadingKind, ShadingSettings, ShadowsKind};

/// How meshes are shaded. Forward and deferred give the same picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shading {
    /// In the pass that draws them.
    Forward,
    /// Once per pixel, from a buffer of albedo, normal and distance.
    Deferred,
    /// Once per pixel. The picture is divided into tiles, and each tile has a list of the lights that reach it. Each pixel has one bit per
    /// light, which tells whether the light is shadowed there.
    Tiled(Tiled),
    /// Once per pixel, with a part of the lights. Each pixel of a 4 × 4 square has a different part; the results are averaged over pixels
    /// that see the same surface.
    Interleaved,
    /// Once per pixel, with one light, chosen at random from new candidates and the light kept from earlier frames. Its probability follows
    /// how much of its light the pixel would reflect.
    Reservoir,
}

/// Settings of [`Shading::Tiled`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Tiled {
    /// Where neighbouring pixels look up light.
    pub dither: DitherKind,
    /// Whether shadows are averaged over neighbouring pixels.
    pub blur: bool,
    /// Whether shadows are averaged with the shadows of the last frame.
    pub history: bool,
    /// Whether each pixel queries its own lights, or threads share a list of pixels and lights.
    pub shadows: ShadowsKind,
}

impl Default for Tiled {
    fn default() -> Self {
        Self { dither: DitherKind::Ordered, blur: true, history: true, shadows: ShadowsKind::Direct }
    }
}

impl Tiled {
    /// Only each pixel's own bits, without dither, blur or history: equals the deferred picture if every look-up gives
    /// 0 or 1.
    pub const BARE: Self = Self { dither: DitherKind::None, blur: false, history: false, shadows: ShadowsKind::Direct };
}

impl Shading {
    /// Returns the shading that the settings name.
    pub fn of(settings: &ShadingSettings) -> Self {
        let ShadingSettings { dither, blur, history, shadows, .. } = *settings;
        match settings.shading {
            ShadingKind::Forward => Self::Forward,
            ShadingKind::Deferred => Self::Deferred,
            ShadingKind::Interleaved => Self::Interleaved,
            ShadingKind::Reservoir => Self::Reservoir,
            ShadingKind::Tiled => Self::Tiled(Tiled { dither, blur, history, shadows }),
        }
    }

    /// Returns the number of frames after which the picture of a static world no longer changes or improves.
    pub fn frames_to_settle(self) -> usize {
        match self {
            Self::Tiled(Tiled { history: true, .. }) => 2,
            Self::Reservoir => MOST_FRAMES,
            _ => 1,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shading::parse;

    #[test]
    fn specs_say_how_meshes_are_shaded() {
        let of = |text: &str| Shading::of(&parse(text).expect(text)[0].settings());
        assert_eq!((of("avsm"), of("avsm:shading=deferred")), (Shading::Forward, Shading::Deferred));
        assert_eq!(of("avsm:shading=interleaved"), Shading::Interleaved);
        assert_eq!(of("avsm:shading=reservoir"), Shading::Reservoir);
        assert_eq!(of("avsm:shading=tiled"), Shading::Tiled(Tiled::default()));
        let bare = "avsm:shading=tiled,dither=none,blur=off,history=off";
        assert_eq!(of(bare), Shading::Tiled(Tiled::BARE));
        let queued = Tiled { shadows: ShadowsKind::Queued, dither: DitherKind::Noise, ..Tiled::default() };
        assert_eq!(of("avsm:shading=tiled,shadows=queued,dither=noise"), Shading::Tiled(queued));
    }
}
