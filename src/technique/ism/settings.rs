//! Keys, and specs that are read.

use super::super::keys::{Key, Switch, Values, Word, words};
use super::super::{Path, Spec};
use crate::gpu::Features;

words! {
    /// Who splats the points.
    pub enum Way {
        /// A workgroup a light, its map in shared memory.
        Tiled = "tiled",
        /// A thread a point, by atomic operations on all maps in memory.
        Atomic = "atomic",
        /// Drawn, a square each.
        Quads = "quads",
        /// Drawn, a triangle each.
        Triangles = "triangles",
    }
}

words! {
    /// How it is told which side of a closed thing a light sees.
    pub enum Facing {
        /// By the normal and the direction from the light.
        Exact = "exact",
        /// By the normals of point and light, as in Tokuyoshi 2014: an approximation.
        Slide = "slide",
    }
}

pub(super) const PATH: Key = Key {
    name: "path",
    values: Values::OneOf(Way::WORDS),
    default: "auto",
    about: "a workgroup a light, its map in shared memory; a thread a point; drawn; auto: the first that runs",
};

pub(super) const SIZE: Key = Key {
    name: "size",
    values: Values::OneOf(&["32", "64", "128"]),
    default: "64",
    about: "texels a side of a light's map",
};

pub(super) const POINTS: Key = Key {
    name: "points",
    values: Values::OneOf(&["1024", "2048", "4096", "8192", "16384"]),
    default: "8192",
    about: "points on the meshes that each light takes, of sixteen times as many",
};

pub(super) const ADAPTIVE: Key = Key {
    name: "adaptive",
    values: Values::OneOf(Switch::WORDS),
    default: "off",
    about: "each light takes its points where it and the viewer see more of them",
};

pub(super) const CULLING: Key = Key {
    name: "culling",
    values: Values::OneOf(Switch::WORDS),
    default: "on",
    about: "leave out the near sides of closed things; of points that are drawn, list those that a light sees",
};

pub(super) const FACING: Key = Key {
    name: "facing",
    values: Values::OneOf(Facing::WORDS),
    default: "exact",
    about: "which side of a closed thing is seen: by the direction to the point, or by the normals alone, which is not exact",
};

pub(super) const FILL: Key = Key {
    name: "fill",
    values: Values::OneOf(Switch::WORDS),
    default: "on",
    about: "fill holes between points by pull-push",
};

pub(super) const PATHS: &[Path] = &[
    Path { name: "tiled", requires: &[] },
    Path { name: "atomic", requires: &[] },
    Path { name: "quads", requires: &[] },
    Path { name: "triangles", requires: &[] },
];

/// A spec, read.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Texels a side of a light's map: a power of two from 32 to 128.
    pub size: u32,
    /// Points that a light takes: a power of two from 1024 to 16384.
    pub points: u32,
    /// Whether lights choose their points by what they see.
    pub adaptive: bool,
    /// Who splats; none where the device decides.
    pub way: Option<Way>,
    /// Whether points that a light does not see are left out.
    pub culling: bool,
    /// Whether facing is told by the normals alone.
    pub slide: bool,
    /// Whether holes are filled.
    pub fill: bool,
}

/// Texels a side of the smallest level.
const SMALLEST: u32 = 4;

impl Settings {
    /// What `spec` says.
    pub fn of(spec: &Spec) -> Self {
        Self {
            size: spec.number(SIZE.name),
            points: spec.number(POINTS.name),
            adaptive: spec.is_on(ADAPTIVE.name),
            way: spec.word(PATH.name),
            culling: spec.is_on(CULLING.name),
            slide: spec.word(FACING.name) == Some(Facing::Slide),
            fill: spec.is_on(FILL.name),
        }
    }

    /// Levels of a map, the finest first. Twin: ISM_LEVELS.
    pub fn levels(&self) -> u32 {
        (self.size / SMALLEST).ilog2() + 1
    }

    /// Texels of all levels of a map. Twin: ISM_TEXELS.
    pub fn texels(&self) -> u32 {
        (0..self.levels()).map(|level| (self.size >> level).pow(2)).sum()
    }

    /// Why no workgroup of the device holds a map; none where one does.
    pub(super) fn lacks_room(&self, features: &Features) -> Option<String> {
        let (needs, has) = (4 * self.texels(), features.max_compute_shared_memory_bytes);
        (has < needs).then(|| format!("maxComputeSharedMemorySize of at least {needs} (this device has {has})"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::technique::parse;

    #[test]
    fn a_spec_is_read() {
        let of = |text: &str| Settings::of(&parse(text).expect(text)[0]);
        let plain =
            Settings { size: 64, points: 8192, adaptive: false, way: None, culling: true, slide: false, fill: true };
        assert_eq!(of("ism"), plain);
        let way = Some(Way::Atomic);
        let other = Settings { size: 32, points: 1024, adaptive: true, way, culling: false, slide: true, fill: false };
        assert_eq!(of("ism:size=32,points=1024,adaptive=on,path=atomic,culling=off,facing=slide,fill=off"), other);
        assert_eq!(
            [32, 64, 128].map(|size| Settings { size, ..plain }).map(|s| (s.levels(), s.texels())),
            [(4, 1360), (5, 5456), (6, 21840)]
        );
    }
}
