//! A scene whose lights are virtual ones.

use crate::gpu::Context;
use crate::lights::indirect::Vpls;
use crate::scene::{Motion, Scene};
use crate::world::World;
use crate::{Error, Result};
use std::ops::RangeInclusive;

/// How many virtual lights there may be.
pub const VPLS: RangeInclusive<u32> = 64..=4096;

/// Whether there may be so many.
///
/// # Errors
/// [`Error::Input`] says how many there may be.
pub fn check_count(count: u32) -> Result<()> {
    if VPLS.contains(&count) {
        return Ok(());
    }
    let cause = format!("there are {} to {}", VPLS.start(), VPLS.end());
    Err(Error::input(format!("{count} virtual lights"), cause, "choose another number"))
}

/// Whether the scene has anything that sends light back.
///
/// # Errors
/// [`Error::Input`] names the scene.
pub fn check_meshes(scene: &Scene) -> Result<()> {
    check_has_meshes(scene.has_triangles(), &scene.name)
}

pub(super) fn check_has_meshes(has_meshes: bool, name: &str) -> Result<()> {
    if has_meshes {
        return Ok(());
    }
    Err(Error::input(name, "it has no mesh that sends light back", "use a scene with meshes"))
}

/// The scene lit by the light that its meshes reflect, and by nothing else: `count` virtual lights in the place of its lights, made on the
/// device. They move with the scene's lights only if they are made anew: of itself nothing moves in it. Smoke and hair neither take light
/// on its way to the meshes nor send it back. Its name says so: `cornell-1024-vpls`.
///
/// # Errors
/// [`Error::Input`] where the count is out of range, the scene has no meshes or no light reaches them; else as [`Vpls::new`].
pub fn lit_by_vpls(context: &Context, scene: &Scene, count: u32) -> Result<Scene> {
    let world = World::new(context, scene)?;
    let mut vpls = Vpls::new(context, &world, count)?;
    vpls.make(&world)?;
    let lights = vpls.read()?;
    if lights.iter().all(|light| light.radiance == [0.0; 3]) {
        let cause = "none of its lights reaches a mesh that reflects any of it";
        return Err(Error::input(scene.name.clone(), cause, "use another scene"));
    }
    let name = format!("{}-{count}-vpls", scene.name);
    Ok(Scene { name, lights, motion: Motion::Still, ..scene.clone() })
}
