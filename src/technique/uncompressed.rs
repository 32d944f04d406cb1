//! The whole list, searched at each look-up: exact at texel centres, the yardstick that the seed's demonstration
//! compares with.

use super::drawn::Drawn;
use super::light::{Maps, SceneData};
use super::list::{Keep, List};
use super::opaque::OpaqueMap;
use super::{Entry, Key, Path, Spec, Technique, Values, Visibility, filter};
use crate::Result;
use crate::gpu::{Bindings, Context, PassTime, Requirement, Resource};
use crate::scene::Scene;
use std::collections::BTreeMap;

/// For the registry.
pub const ENTRY: Entry = Entry {
    name: "uncompressed",
    about: "per-texel lists of all segments, exact at texel centres (the yardstick of seed 000's demonstration)",
    keys: &[
        Key { name: "size", values: Values::Number(1, 16384), default: "256", about: "texels a side of a light's map" },
        filter::FILTER,
        filter::RADIUS,
        super::SKIP,
        super::LIGHTING,
    ],
    paths: &[Path { name: "list", requires: &[Requirement::FragmentStores] }],
    open: |context, scene, data, spec| Ok(Box::new(Uncompressed::new(context, scene, data, spec)?)),
};

/// The technique, opened for one scene.
struct Uncompressed {
    context: Context,
    maps: Maps,
    opaque: OpaqueMap,
    list: List,
    visibility: Bindings,
    skip: bool,
    built: bool,
    /// FILTER, FILTER_RADIUS.
    constants: [u32; 2],
}

impl Uncompressed {
    fn new(context: &Context, scene: &Scene, data: &SceneData, spec: &Spec) -> Result<Self> {
        super::require(context, ENTRY.paths[0].requires)?;
        let constants = filter::constants(scene, spec)?;
        let maps = Maps::new(context, scene, spec.number("size"))?;
        let opaque = OpaqueMap::new(context, data, &maps)?;
        let orders: Vec<u32> = (0..maps.count()).flat_map(|_| 0..data.caster_count).collect();
        let drawn = Drawn::new(context, data, &maps, &orders, None)?;
        let list = List::new(context, &maps, drawn, Keep::All, None)?;
        let visibility = visibility(context, &maps, &list, &opaque)?;
        let skip = spec.value("skip") == "on";
        Ok(Self { context: context.clone(), maps, opaque, list, visibility, skip, built: false, constants })
    }
}

fn visibility(context: &Context, maps: &Maps, list: &List, opaque: &OpaqueMap) -> Result<Bindings> {
    let resources = [
        Resource::Buffer(maps.lights.clone()),
        Resource::StorageImage(list.heads.clone()),
        Resource::Buffer(list.segments.clone()),
        Resource::Texture(opaque.image.clone()),
        Resource::Buffer(maps.buffer.clone()),
    ];
    Bindings::new(context, "uncompressed.visibility", &resources)
}

impl Technique for Uncompressed {
    fn changed(&mut self) {
        self.built = false;
    }

    fn build(&mut self) -> Result<Vec<PassTime>> {
        if self.built && self.skip {
            return Ok(Vec::new());
        }
        loop {
            let passes = self.context.submit(|commands| {
                self.opaque.depth(commands);
                for map in 0..self.maps.count() {
                    self.list.clear(commands, map);
                    self.list.capture(commands, map, None);
                }
            })?;
            if !self.list.grow()? {
                self.built = true;
                return Ok(passes);
            }
            self.visibility = visibility(&self.context, &self.maps, &self.list, &self.opaque)?;
        }
    }

    fn visibility(&self) -> Visibility<'_> {
        Visibility { folder: ENTRY.name, bindings: &self.visibility, constants: &self.constants }
    }

    fn path(&self) -> &'static str {
        "list"
    }

    fn reason(&self) -> String {
        "the only path".into()
    }

    fn bytes_resident(&self) -> u64 {
        self.list.bytes() + self.opaque.image.bytes()
    }

    fn bytes_transient(&self) -> u64 {
        0
    }

    fn counters(&self) -> Result<BTreeMap<String, u64>> {
        Ok([("fragments", self.list.fragments()), ("overflowed", self.list.overflowed())]
            .map(|(k, v)| (k.to_owned(), v))
            .into())
    }
}
