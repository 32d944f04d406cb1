//! Voxelized shadows that were baked earlier, loaded from their file.

use super::cube::{Cubes, resolution};
use super::file::{Baked, scene_hash};
use super::settings::{Plan, Settings};
use super::{COUNTS, OF, TreeData, counters};
use crate::gpu::{Bindings, Buffer, Commands, Constants, Context, Mapped, Memory};
use crate::scene::Resolution;
use crate::shaders::folder;
use crate::shaders::set;
use crate::technique::settings::Keyed;
use crate::technique::{Answer, Facts, Inspect, Key, Technique};
use crate::world::{Parts, World};
use crate::{Error, Result, WayOut};
use std::path::Path;

/// Path name of a technique that is loaded, not built.
const PATH: &str = "file";

/// A bake from a file, opened for the world that was baked.
pub struct Loaded {
    file: String,
    bytes_on_disk: u64,
    plan: Plan,
    /// Hash of the scene that was baked.
    scene: u64,
    counts: [u64; COUNTS.len()],
    cubes: Cubes,
    bytes_resident: u64,
    look_up: Bindings,
    constants: Constants,
}

impl Loaded {
    /// Opens the file named in `settings` and copies its nodes to the device. The file states the settings of its bake, which must agree
    /// with `settings` for all keys for which `held` is true.
    ///
    /// # Errors
    /// [`Error::Input`], naming the file, if it cannot be read, is not a bake, is damaged, or was baked from another scene or with settings
    /// other than the given ones; [`Error::Gpu`] if memory runs out.
    pub fn new(context: &Context, world: &World, settings: &Settings, held: impl Fn(&Key) -> bool) -> Result<Self> {
        settings.check()?;
        let Some(file) = settings.file.clone() else {
            return Err(Error::input("voxelized", "file= names none", WayOut::Bake("name one, or write it".into())));
        };
        let mapped = Mapped::open(Path::new(&file))
            .map_err(|cause| Error::input(&file, cause, WayOut::Bake("check the name, or write it".into())))?;
        let baked = Baked::read(&file, &mapped)?;
        for (key, found) in baked.plan.baked() {
            let said = Settings::KEYS.iter().zip(settings.texts()).find(|(known, _)| known.name == key && held(known));
            if let Some((_, (_, said))) = said.filter(|(_, (_, said))| *said != found) {
                let cause = format!("baked with {key}={found}, and the spec says {key}={said}");
                return Err(Error::input(&file, cause, WayOut::Bake(format!("leave {key}= out, or bake it again"))));
            }
        }
        check_scene(&file, baked.scene, world)?;
        let cubes = Cubes::new(world, baked.plan.size)?;
        let of_lights = |tree: &TreeData| (tree.first, tree.faces, tree.perspective);
        if !baked.trees.iter().map(of_lights).eq(TreeData::all(&cubes).iter().map(of_lights)) {
            let cause = "damaged: its trees are not those of the lights";
            return Err(Error::input(&file, cause, WayOut::Bake("bake it again".into())));
        }
        let plan = Plan { filter: settings.filter, bias: settings.bias, ..baked.plan };
        let trees_bytes = size_of_val(&baked.trees[..]) as u64;
        let trees =
            Buffer::new(context, "voxelized.trees", trees_bytes.max(size_of::<TreeData>() as u64), Memory::Device)?;
        trees.write(&baked.trees)?;
        // One extra word, since a look-up may read the second half of a pointer past the last word.
        let nodes = Buffer::new(context, "voxelized.data", baked.words.len() as u64 + 4, Memory::Device)?;
        nodes.write(baked.words)?;
        let bytes_resident = baked.words.len() as u64 + trees.bytes();
        Ok(Self {
            bytes_on_disk: mapped.len() as u64,
            plan,
            scene: baked.scene,
            counts: baked.counts,
            cubes,
            bytes_resident,
            look_up: set::VoxelizedLookUp { trees: &trees, nodes: &nodes }.bind(context, "voxelized.look_up")?,
            constants: plan.constants(Constants::new()),
            file,
        })
    }
}

/// Returns an error if the file was baked from another scene.
fn check_scene(file: &str, baked: u64, world: &World) -> Result<()> {
    if world.meshes().is_some_and(|meshes| scene_hash(meshes, world.all_lights()) == baked) {
        return Ok(());
    }
    let cause = format!("baked from a scene whose meshes or lights differ from those of {} now", world.name());
    Err(Error::input(file, cause, WayOut::Bake("use that scene, or bake this one".into())))
}

impl Technique for Loaded {
    fn made_of(&self) -> Parts {
        OF
    }

    /// Records no passes, since all data is already on the device; only checks that the file was baked from this world's scene.
    fn record(&mut self, _commands: &mut Commands, world: &World) -> Result<()> {
        check_scene(&self.file, self.scene, world)
    }

    fn answer(&self) -> Answer<'_> {
        Answer::new(folder::VOXELIZED, &self.look_up, &self.constants)
    }

    fn inspect(&self) -> &dyn Inspect {
        self
    }
}

impl Inspect for Loaded {
    fn resolution(&self) -> Vec<Resolution> {
        resolution(&self.cubes, &self.plan)
    }

    fn facts(&self) -> Result<Facts> {
        Ok(Facts {
            path: PATH,
            reason: "file= names one".into(),
            bytes_resident: self.bytes_resident,
            bytes_on_disk: Some(self.bytes_on_disk),
            found: self.plan.baked().map(|(key, value)| (key.to_owned(), value)).collect(),
            counters: counters(self.counts),
            ..Facts::default()
        })
    }
}
