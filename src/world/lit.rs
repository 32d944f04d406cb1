//! The lights of a world of the caller's: from the host, or from a buffer of the caller's.

use super::source::{Count, LightAt, LightType, Source};
use super::staged::raise_lights;
use super::{LightData, World};
use crate::gpu::Commands;
use crate::scene::{Light, LightKind};
use crate::{Error, Result};
use glam::DVec3;

impl World {
    /// Its lights are now those: records their copy where any is another, and says which of them stand otherwise. Techniques are
    /// opened for as many as there have been. Where there are fewer now, those that went stay where they stood and are dark; where
    /// there are more than ever, techniques that keep something of each light refuse to be recorded and are opened anew.
    ///
    /// # Errors
    /// [`Error::Input`] where there are more than there is room for, a number of one is out of range, or one has not as many maps as
    /// the one before it in its place: six of a point light, one of any other.
    pub fn lights(&mut self, commands: &mut Commands, lights: &[Light]) -> Result<()> {
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

    /// Its lights are now those of that buffer, of such types in its order: records the pass that gathers them, and says that all of
    /// them have moved. The host learns nothing of them but their types, which decide how many maps there are. Lights with a number that
    /// is not as [`LightAt`] says are dark, and are counted ([`World::gathered`]); so are those behind a count that is less than the
    /// types, and those that there were before and there are no more.
    ///
    /// Views are aimed on the device then, in single floats: axes of directional and of spot lights differ by up to 2.1e-6 from those of
    /// the same lights of the host's, the width of a spot's by more the narrower it is (0.08 % at 1°), and point lights by nothing.
    ///
    /// # Errors
    /// [`Error::Input`] as [`World::lights`], where the host knows that there are more than it told types of, or the layout lies outside
    /// the buffer; [`Error::Gpu`] where memory runs out.
    pub fn lights_of_buffer(
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

    /// Lights in the places of those that there are; where these are more, the others are dark.
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

    /// From now on there are these, all of which have `moved`, or those that stand otherwise.
    fn stand(&mut self, all: Vec<Light>, moved: bool, known: bool) {
        raise_lights(&mut self.generations, &all, &self.lit, moved);
        self.generations.lights.resize(all.len(), 0);
        (self.lit, self.knows_lights) = (all, known);
    }
}

/// Whether its numbers are as [`Light`] says.
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
