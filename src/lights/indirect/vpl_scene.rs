//! Scenes that are lit by virtual lights alone.

use crate::gpu::Context;
use crate::lights::indirect::Vpls;
use crate::scene::{Reserve, Scene, View};
use crate::world::World;
use crate::{Error, Result};
use std::ops::RangeInclusive;

/// How many virtual lights there may be.
pub const VPLS: RangeInclusive<u32> = 64..=4096;

/// The shape of the picture that [`VplsBy::View`] looks at: that of pictures where nothing else is said.
const WIDE: [u32; 2] = [16, 9];

/// Checks a number of virtual lights.
///
/// # Errors
/// [`Error::Usage`], with the range that is allowed.
pub fn check_count(count: u32) -> Result<()> {
    if VPLS.contains(&count) {
        return Ok(());
    }
    let cause = format!("there are {} to {}", VPLS.start(), VPLS.end());
    Err(Error::usage(format!("{count} virtual lights"), cause, "choose another number"))
}

/// Checks that the scene has a mesh, which can reflect light.
///
/// # Errors
/// [`Error::Input`] where it has none.
pub fn check_meshes(scene: &Scene) -> Result<()> {
    check_has_meshes(scene.has_triangles(), &scene.name)
}

pub(super) fn check_has_meshes(has_meshes: bool, name: &str) -> Result<()> {
    if has_meshes {
        return Ok(());
    }
    Err(Error::input(name, "it has no mesh that sends light back", "use a scene with meshes"))
}

/// What decides where virtual lights are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "program", derive(clap::ValueEnum))]
pub enum VplsBy {
    /// They are as dense as the flux that leaves surfaces: the same for each camera.
    #[default]
    Flux,
    /// They are as dense as what of it comes to what the scene's camera sees.
    View,
}

/// A copy of the scene in which `count` virtual lights, made on the device, replace the lights: it shows only light that meshes reflect.
/// The copy stands still; to follow moving lights, make it again. Smoke and hair do not dim the light on its way to the meshes, and reflect
/// none. The copy's name ends in the count, and in what decides: `cornell-1024-vpls`, `cornell-1024-vpls-by-view`.
///
/// # Errors
/// [`Error::Input`] where the count is out of range, the scene has no meshes or no light reaches them; else as [`Vpls::new`].
pub fn lit_by_vpls(context: &Context, scene: &Scene, count: u32, by: VplsBy) -> Result<Scene> {
    let world = World::new(context, scene)?;
    world.one_color("virtual lights have")?;
    let mut vpls = match by {
        VplsBy::Flux => Vpls::new(context, &world, count)?,
        VplsBy::View => Vpls::by_view(context, &world, count, &View::camera(&scene.camera, scene, WIDE))?,
    };
    vpls.make(&world)?;
    let lights = vpls.read()?;
    if lights.iter().all(|light| light.radiance == [0.0; 3]) {
        let cause = "none of its lights reaches a mesh that reflects any of it";
        return Err(Error::input(scene.name.clone(), cause, "use another scene"));
    }
    let name = format!("{}-{count}-vpls{}", scene.name, if by == VplsBy::View { "-by-view" } else { "" });
    Ok(Scene { name, lights, reserve: Reserve::default(), ..scene.clone() })
}
