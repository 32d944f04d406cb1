//! The lights of a world that the caller fills: from the host, or from one of the caller's buffers.

use super::source::{Count, LightAt, LightType, Source};
use super::staged::raise_lights;
use super::{LightData, World};
use crate::gpu::Commands;
use crate::scene::{Light, LightKind};
use crate::{Error, Result};
use glam::DVec3;

impl World {
    /// Replaces the lights with `lights`. Records their copy if any has changed, and increments the generations of lights that have moved.
    /// A technique is created for the largest number of lights that the world has had so far. If there are fewer lights now, the removed
    /// ones keep their places and are dark. If there are more, techniques with per-light data refuse to be recorded, and must be created
    /// again.
    ///
    /// # Errors
    /// [`Error::Input`] if there are more lights than the capacity, a number is out of range, or a light has a different number of maps
    /// from the light previously in its place: a point or a virtual light has six, any other has one.
    pub fn update_lights(&mut self, commands: &mut Commands, lights: &[Light]) -> Result<()> {
        let all = self.places(lights)?;
        if let Some(i) = lights.iter().position(|light| !is_light(light)) {
            return Err(self.no_lights(format!("light {i} has a number that is not finite or out of range")));
        }
        if self.knows_lights && self.lit == all {
            return Ok(());
        }
        let data = LightData::of(&all, self.triangle_capacity > 0);
        commands.pass("world.lights", |pass| pass.update(&self.lights, &data));
        let unknown = !self.knows_lights;
        self.stand(all, unknown, true);
        Ok(())
    }

    /// Replaces the lights with those in one of the caller's buffers; `types` are their types, in the buffer's order. Records the pass that
    /// gathers them, and marks all of them as moved. The host knows only their types, which determine the number of maps. Lights with a
    /// number that violates [`LightAt`] are dark, and are counted as refused ([`World::gathered`]). Lights past a count below the number of
    /// types are dark too, as are earlier lights that have been removed.
    ///
    /// Views are then aimed on the device, in single precision. Axes of directional and of spot lights differ by up to 2.1e-6 from those of
    /// the same lights given by the host. The width of a spot light's view differs more for narrower cones (0.08 % at 1°); point lights do
    /// not differ.
    ///
    /// # Errors
    /// [`Error::Input`] as for [`World::update_lights`], and if the host's count exceeds the number of types, or the layout extends past
    /// the buffer; [`Error::Gpu`] if memory runs out.
    pub fn update_lights_from_buffer(
        &mut self,
        commands: &mut Commands,
        source: &Source,
        at: LightAt,
        types: &[LightType],
    ) -> Result<()> {
        let stand_ins: Vec<_> = types.iter().map(|of| of.stand_in()).collect();
        let all = self.places(&stand_ins)?;
        if let Count::Host(count) = source.count
            && count as usize > types.len()
        {
            return Err(self.no_lights(format!("{count} lights, and types of {}", types.len())));
        }
        let (context, lights) = (self.context.clone(), self.lights.clone());
        let (slots, told) = (all.len() as u32, types.len() as u32);
        let data = (self.knows_lights || self.lit != all).then(|| LightData::of(&all, self.triangle_capacity > 0));
        let gather = &mut self.theirs()?.gather;
        gather.lights(&context, commands, (&lights, slots, told), data.as_deref(), (source, at))?;
        self.stand(all, true, false);
        Ok(())
    }

    /// Returns `lights`, in the places of the current lights. If there are more current lights, the rest keep their places at the end and
    /// are dark.
    fn places(&mut self, lights: &[Light]) -> Result<Vec<Light>> {
        let room = self.theirs()?.capacity.lights as usize;
        let other_maps = |(is, was): (&Light, &Light)| is.map_count() != was.map_count();
        if lights.len() > room {
            return Err(self.no_lights(format!("{} lights, and the world has room for {room}", lights.len())));
        }
        if let Some(i) = lights.iter().zip(&self.lit).position(other_maps) {
            return Err(self.no_lights(format!("light {i} has another number of maps than the one before it")));
        }
        let gone = self.lit.iter().skip(lights.len()).map(|light| Light { radiance: [0.0; 3], ..*light });
        Ok(lights.iter().copied().chain(gone).collect())
    }

    fn no_lights(&self, cause: String) -> Error {
        Error::input(self.name.clone(), cause, "make a new world, and open its techniques anew")
    }

    /// Sets the current lights to `all`. If `moved`, all of them are marked as moved, otherwise only those whose placement has changed.
    fn stand(&mut self, all: Vec<Light>, moved: bool, known: bool) {
        raise_lights(&mut self.generations, &all, &self.lit, moved);
        self.generations.lights.resize(all.len(), 0);
        (self.lit, self.knows_lights) = (all, known);
    }
}

/// Returns whether the light's numbers are in the ranges documented for [`Light`].
fn is_light(light: &Light) -> bool {
    let is_unit = |v: DVec3| (v.length() - 1.0).abs() < 1e-3;
    let stands = light.position().is_none_or(DVec3::is_finite);
    let kind = match light.kind {
        LightKind::Directional { direction } => is_unit(direction),
        LightKind::Spot { direction, cone_degrees, .. } => {
            is_unit(direction) && cone_degrees > 0.0 && cone_degrees <= 170.0
        }
        LightKind::Point { .. } => true,
        LightKind::Virtual { normal, nearest, .. } => is_unit(normal) && nearest > 0.0 && nearest.is_finite(),
    };
    stands && kind && light.radius > 0.0 && light.radiance.iter().all(|c| c.is_finite() && *c >= 0.0)
}
