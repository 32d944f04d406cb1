//! Voxelized shadows that were baked before, from their file.

use super::cube::{cubes, resolution};
use super::file::{Baked, scene_hash};
use super::settings::{FILE, Settings};
use super::{COUNTS, OF, TreeData, counters};
use crate::gpu::{Bindings, Buffer, Commands, Constants, Context, Mapped, Memory, Resource};
use crate::maps::Map;
use crate::scene::{Resolution, Scene, View};
use crate::shaders::folder;
use crate::technique::keys::PCF;
use crate::technique::{Answer, Facts, Spec, Technique};
use crate::world::{Parts, World};
use crate::{Error, Result, WayOut};
use std::path::Path;

/// The path of what is not built.
const PATH: &str = "file";

/// A bake from a file, opened for the world that it was made of.
pub struct Loaded {
    file: String,
    bytes_on_disk: u64,
    settings: Settings,
    /// Hash of what was baked.
    scene: u64,
    counts: [u64; COUNTS.len()],
    cubes: Vec<View>,
    bytes_resident: u64,
    look_up: Bindings,
    constants: Constants,
}

impl Loaded {
    /// Opens the file that `spec` names, and takes it to the device.
    ///
    /// # Errors
    /// [`Error::Input`] that names the file where it cannot be read, is none of a bake, damaged, of another scene, or baked
    /// with other settings than the spec gives; [`Error::Gpu`] where memory runs out.
    pub fn open(context: &Context, world: &World, spec: &Spec) -> Result<Self> {
        let file = spec.value(FILE.name).to_owned();
        let mapped = Mapped::open(Path::new(&file))
            .map_err(|cause| Error::input(&file, cause, WayOut::Bake("check the name, or write it".into())))?;
        let baked = Baked::read(&file, &mapped)?;
        for (key, found) in baked.settings.baked() {
            let said = spec.value(key);
            if !said.is_empty() && said != found {
                let cause = format!("baked with {key}={found}, and the spec says {key}={said}");
                return Err(Error::input(&file, cause, WayOut::Bake(format!("leave {key}= out, or bake it again"))));
            }
        }
        check_scene(&file, baked.scene, world.scene())?;
        let settings = Settings { filter: spec.number(PCF.name), ..baked.settings };
        let trees_bytes = size_of_val(&baked.trees[..]) as u64;
        let trees =
            Buffer::new(context, "voxelized.trees", trees_bytes.max(size_of::<TreeData>() as u64), Memory::Device)?;
        trees.write(&baked.trees)?;
        // A word more, which a pointer's second half may be sought in.
        let nodes = Buffer::new(context, "voxelized.data", baked.words.len() as u64 + 4, Memory::Device)?;
        nodes.write(baked.words)?;
        let bytes_resident = baked.words.len() as u64 + trees.bytes();
        let resources = [trees, nodes].map(Resource::Buffer);
        Ok(Self {
            bytes_on_disk: mapped.len() as u64,
            settings,
            scene: baked.scene,
            counts: baked.counts,
            cubes: cubes(world.scene(), settings.size)?,
            bytes_resident,
            look_up: Bindings::new(context, "voxelized.look_up", &resources)?,
            constants: settings.constants(Constants::new()),
            file,
        })
    }
}

/// An error where the file is of another scene.
fn check_scene(file: &str, baked: u64, scene: &Scene) -> Result<()> {
    if scene_hash(scene) == baked {
        return Ok(());
    }
    let cause = format!("baked of a scene with other meshes or lights than {} has now", scene.name);
    Err(Error::input(file, cause, WayOut::Bake("use that scene, or bake this one".into())))
}

impl Technique for Loaded {
    fn made_of(&self) -> Parts {
        OF
    }

    /// No pass: all of it is on the device, as long as the file is of the world.
    fn record(&mut self, _commands: &mut Commands, world: &World) -> Result<()> {
        check_scene(&self.file, self.scene, world.scene())
    }

    fn answer(&self) -> Answer<'_> {
        Answer { folder: folder::VOXELIZED, bindings: &self.look_up, constants: &self.constants }
    }

    fn maps(&self) -> &[Map] {
        &[]
    }

    fn resolution(&self) -> Vec<Resolution> {
        resolution(&self.cubes, &self.settings)
    }

    fn facts(&self) -> Result<Facts> {
        Ok(Facts {
            path: PATH,
            reason: "file= names one".into(),
            bytes_resident: self.bytes_resident,
            bytes_on_disk: Some(self.bytes_on_disk),
            found: self.settings.baked().into_iter().map(|(key, value)| (key.to_owned(), value)).collect(),
            counters: counters(self.counts),
            ..Facts::default()
        })
    }
}
