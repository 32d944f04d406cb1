//! The lights of a world that the caller fills: from the host, or from a buffer of the caller's.

use super::source::{Count, LightAt, LightType, Source};
use super::staged::raise_lights;
use super::{LightData, World};
use crate::gpu::Commands;
use crate::scene::{Light, LightKind};
use crate::{Error, Result};
use glam::DVec3;

impl World {
    /// Replaces the lights by `lights`. Records their copy where any has changed, and raises the generations of those
    /// that have moved. A technique is opened for the most lights that the world has had until then. Where there are
    /// fewer now, the lights that are gone keep their places and are dark. Where there are more, techniques that store
    /// something per light refuse to be recorded, and must be opened anew.
    ///
    /// # Errors
    /// [`Error::Input`] where there are more lights than there is room for, a number is out of range, or a light has
    /// another number of maps than the light before it in its place: a point or a virtual light has six, any other has
    /// one.
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

    /// Replaces the lights by those in a buffer of the caller's, whose types are `types`, in the buffer's order.
    /// Records the pass that gathers them, and counts all of them as moved. The host knows only their types, which
    /// decide how many maps there are. Lights with a number that is not as [`LightAt`] says are dark, and are counted
    /// ([`World::gathered`]). Also dark are lights behind a count that is less than the number of types, and earlier
    /// lights that are gone.
    ///
    /// Views are then aimed on the device, in single floats. Axes of directional and of spot lights differ by up to
    /// 2.1e-6 from those of the same lights given by the host. The width of a spot light's view differs by more the
    /// narrower it is (0.08 % at 1°); point lights do not differ.
    ///
    /// # Errors
    /// [`Error::Input`] as [`World::update_lights`], where the host's count exceeds the number of types, or where the layout
    /// lies outside the buffer; [`Error::Gpu`] where memory runs out.
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

    /// `lights`, in the places of the present lights. Where there are more present lights, these are kept behind and
    /// dark.
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

    /// Sets the present lights to `all`. With `moved` all of them count as moved, else those whose place has changed.
    fn stand(&mut self, all: Vec<Light>, moved: bool, known: bool) {
        raise_lights(&mut self.generations, &all, &self.lit, moved);
        self.generations.lights.resize(all.len(), 0);
        (self.lit, self.knows_lights) = (all, known);
    }
}

/// Whether the light's numbers are in the ranges that [`Light`] says.
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
