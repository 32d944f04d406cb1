//! Scenes lit by virtual lights alone.

use crate::gpu::Context;
use crate::lights::indirect::Vpls;
use crate::scene::{Reserve, Scene, View};
use crate::world::World;
use crate::{Error, Result};
use std::ops::RangeInclusive;

/// Allowed number of virtual lights.
pub const VPLS: RangeInclusive<u32> = 64..=4096;

/// Aspect ratio of the picture for [`VplsBy::View`], the default of pictures.
const WIDE: [u32; 2] = [16, 9];

/// Checks a number of virtual lights.
///
/// # Errors
/// [`Error::Usage`], stating the allowed range.
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
/// [`Error::Input`] if it has none.
pub fn check_meshes(scene: &Scene) -> Result<()> {
    check_has_meshes(scene.has_triangles(), &scene.name)
}

pub(super) fn check_has_meshes(has_meshes: bool, name: &str) -> Result<()> {
    if has_meshes {
        return Ok(());
    }
    Err(Error::input(name, "it has no mesh that sends light back", "use a scene with meshes"))
}

/// What determines where virtual lights are placed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "program", derive(clap::ValueEnum))]
pub enum VplsBy {
    /// Density proportional to the flux that leaves surfaces: the same for each camera.
    #[default]
    Flux,
    /// Density proportional to the part of this flux that reaches what the scene's camera sees.
    View,
}

/// Returns a copy of the scene in which `count` virtual lights, created on the device, replace the lights: it shows only light that meshes
/// reflect. The copy is static; to follow moving lights, create it again. Smoke and hair do not dim the light before it reaches the meshes,
/// and reflect none. The copy's name ends with the count, and with what determines the placement: `cornell-1024-vpls`,
/// `cornell-1024-vpls-by-view`.
///
/// # Errors
/// [`Error::Input`] if the count is out of range, the scene has no meshes or no light reaches them; otherwise as [`Vpls::new`].
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
