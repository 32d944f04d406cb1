//! Beer shadow maps: where the medium on a texel's ray begins, its mean extinction and its greatest optical depth. Source:
//! Hillaire 2020 (Unreal Engine's clouds).

use super::keys::{FILTER, RADIUS, SIZE};
use super::texel_map::{BINNED, PATH, RASTER, TexelMap};
use super::{Casts, Entry, Lifetime, Path};
use crate::gpu::{Blend, Format};
use crate::maps::TexelKernels;
use crate::shaders::{beer_shadow_map, folder};

/// For the registry.
pub const ENTRY: Entry = Entry {
    name: "beer-shadow-map",
    about: "front depth, mean extinction and greatest optical depth a texel (Hillaire 2020, Unreal Engine's clouds)",
    casts: Casts::ALL,
    lifetime: Lifetime::Frame,
    keys: &[PATH, SIZE, FILTER, RADIUS],
    paths: &[Path { name: BINNED, requires: &[] }, Path { name: RASTER, requires: &[] }],
    open: |context, world, spec| {
        let kernels = TexelKernels {
            labels: ["beer_shadow_map.blend", "beer_shadow_map.collect"],
            format: Format::R16G16B16A16_SFLOAT,
            fragment: &beer_shadow_map::BLEND_FRAG,
            blend: Blend::MaxAndAdd,
            empty: [0.0; 4],
            binned: &beer_shadow_map::COLLECT,
        };
        Ok(Box::new(TexelMap::new(context, world, spec, folder::BEER_SHADOW_MAP, &kernels)?))
    },
};
