//! The whole list, searched at each look-up: exact at texel centres, the yardstick that the seed's demonstration
//! compares with.

use super::light::{LightData, SceneData};
use super::list::List;
use super::opaque::OpaqueMap;
use super::{Entry, Key, Path, Spec, Technique, Values, Visibility};
use crate::Result;
use crate::gpu::{Bindings, Buffer, Context, PassTime, Requirement, Resource};
use crate::scene::Scene;
use std::collections::BTreeMap;

/// For the registry.
pub const ENTRY: Entry = Entry {
    name: "uncompressed",
    about: "per-texel lists of all segments, exact at texel centres (the yardstick of seed 000's demonstration)",
    keys: &[Key {
        name: "size",
        values: Values::Number(1, 16384),
        default: "256",
        about: "texels a side of the light's map",
    }],
    paths: &[Path { name: "list", requires: &[Requirement::FragmentStores] }],
    open: |context, scene, data, spec| Ok(Box::new(Uncompressed::new(context, scene, data, spec)?)),
};

/// The technique, opened for one scene.
struct Uncompressed {
    context: Context,
    lights: Buffer,
    opaque: OpaqueMap,
    list: List,
    visibility: Bindings,
}

impl Uncompressed {
    fn new(context: &Context, scene: &Scene, data: &SceneData, spec: &Spec) -> Result<Self> {
        super::require(context, ENTRY.paths[0].requires)?;
        let light = LightData::new(scene, spec.number("size"));
        let lights = Buffer::with_data(context, "lights", &[light])?;
        let opaque = OpaqueMap::new(context, data, &light, &lights)?;
        let list = List::new(context, data, &light, &lights, None)?;
        let visibility = visibility(context, &lights, &list, &opaque)?;
        Ok(Self { context: context.clone(), lights, opaque, list, visibility })
    }
}

fn visibility(context: &Context, lights: &Buffer, list: &List, opaque: &OpaqueMap) -> Result<Bindings> {
    let resources = [
        Resource::Buffer(lights.clone()),
        Resource::StorageImage(list.heads.clone()),
        Resource::Buffer(list.segments.clone()),
        Resource::Texture(opaque.image.clone()),
    ];
    Bindings::new(context, "uncompressed.visibility", &resources)
}

impl Technique for Uncompressed {
    fn build(&mut self) -> Result<Vec<PassTime>> {
        loop {
            let passes = self.context.submit(|commands| {
                self.opaque.depth(commands);
                self.list.clear(commands);
                self.list.capture(commands);
            })?;
            if !self.list.grow()? {
                return Ok(passes);
            }
            self.visibility = visibility(&self.context, &self.lights, &self.list, &self.opaque)?;
        }
    }

    fn visibility(&self) -> Visibility<'_> {
        Visibility { folder: ENTRY.name, bindings: &self.visibility, constants: &[] }
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
            .map(|(k, v)| (k.to_owned(), v.into()))
            .into())
    }
}
