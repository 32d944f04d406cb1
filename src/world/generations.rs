//! Counters that show which parts of a world have changed since something was built from it.

use super::World;

/// A set of parts of a world, on which a build may depend.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Parts(u8);

impl Parts {
    /// Opaque triangles.
    pub const MESHES: Self = Self(1);
    /// Spheres of smoke.
    pub const PARTICLES: Self = Self(2);
    /// Hair.
    pub const STRANDS: Self = Self(4);
    /// Smoke and hair.
    pub const CASTERS: Self = Self::PARTICLES.and(Self::STRANDS);
    /// The lights, except for their colors, which are read by look-ups and from which nothing is built.
    pub const LIGHTS: Self = Self(8);
    /// The scene's camera.
    pub const CAMERA: Self = Self(16);
    /// The box around all casters.
    pub const BOX: Self = Self(32);
    /// No parts.
    pub const NONE: Self = Self(0);
    /// All parts.
    pub const ALL: Self = Self(63);

    /// Returns the union of both sets.
    pub const fn and(self, those: Self) -> Self {
        Self(self.0 | those.0)
    }

    /// Returns these parts without those.
    const fn without(self, those: Self) -> Self {
        Self(self.0 & !those.0)
    }

    const fn has(self, one: Self) -> bool {
        self.0 & one.0 != 0
    }
}

/// Number of changes to each part of a world.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Generations {
    /// Changes to opaque triangles.
    pub meshes: u64,
    /// Changes to smoke spheres.
    pub particles: u64,
    /// Changes to hair.
    pub strands: u64,
    /// Changes to each light, except for its color.
    pub lights: Vec<u64>,
    /// Changes to the scene's camera.
    pub camera: u64,
    /// Changes to the box around all casters.
    pub bounds: u64,
}

impl Generations {
    /// Returns whether these counts and `those` agree on all of `parts`.
    pub fn agree(&self, those: &Self, parts: Parts) -> bool {
        let same = [
            (Parts::MESHES, self.meshes == those.meshes),
            (Parts::PARTICLES, self.particles == those.particles),
            (Parts::STRANDS, self.strands == those.strands),
            (Parts::LIGHTS, self.lights == those.lights),
            (Parts::CAMERA, self.camera == those.camera),
            (Parts::BOX, self.bounds == those.bounds),
        ];
        same.into_iter().all(|(part, same)| same || !parts.has(part))
    }
}

/// The parts of a world that something is built from, and the state of the world at its last build.
#[derive(Clone, Debug)]
pub struct BuildStamp {
    of: Parts,
    at: Option<Generations>,
}

impl BuildStamp {
    /// Creates a stamp for something that has not been built yet.
    pub fn of(parts: Parts) -> Self {
        Self { of: parts, at: None }
    }

    /// Returns whether the last build is up to date with the world.
    pub fn is_current(&self, world: &World) -> bool {
        self.at.as_ref().is_some_and(|at| at.agree(world.generations(), self.of))
    }

    /// Returns whether a rebuild from the current world is needed. If so, records it as done: the caller must rebuild.
    pub fn make(&mut self, world: &World) -> bool {
        let make = !self.is_current(world);
        if make {
            self.at = Some(world.generations().clone());
        }
        make
    }

    /// Like [`BuildStamp::make`], but for something with one part per light: returns, for each light, whether its part must be rebuilt. If
    /// anything besides lights has changed, all parts must be.
    pub fn make_lights(&mut self, world: &World) -> Vec<bool> {
        let now = world.generations();
        let make = self.lights_to_make(now);
        self.at = Some(now.clone());
        make
    }

    fn lights_to_make(&self, now: &Generations) -> Vec<bool> {
        let rest = self.of.without(Parts::LIGHTS);
        let kept = |at: &&Generations| at.agree(now, rest) && at.lights.len() == now.lights.len();
        match self.at.as_ref().filter(kept) {
            Some(at) => at.lights.iter().zip(&now.lights).map(|(was, is)| was != is).collect(),
            None => vec![true; now.lights.len()],
        }
    }

    /// Makes the next call of [`BuildStamp::make`] return true, even if nothing has changed.
    pub fn forget(&mut self) {
        self.at = None;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Changes one part at a time. The counts must then differ on that part and on all parts together, and agree on every other part.
    #[test]
    fn only_what_it_is_made_of_counts() {
        let before = Generations { lights: vec![0; 3], ..Generations::default() };
        let mut lit = before.clone();
        lit.lights[1] += 1;
        let changed = [
            (Parts::MESHES, Generations { meshes: 1, ..before.clone() }),
            (Parts::PARTICLES, Generations { particles: 1, ..before.clone() }),
            (Parts::STRANDS, Generations { strands: 1, ..before.clone() }),
            (Parts::LIGHTS, lit),
            (Parts::CAMERA, Generations { camera: 1, ..before.clone() }),
            (Parts::BOX, Generations { bounds: 1, ..before.clone() }),
        ];
        for (i, (part, after)) in changed.iter().enumerate() {
            assert!(!before.agree(after, Parts::ALL));
            for (other, (that, _)) in changed.iter().enumerate() {
                assert_eq!(before.agree(after, *that), i != other, "{part:?} and {that:?}");
            }
        }
        assert!(!before.agree(&changed[2].1, Parts::CASTERS) && before.agree(&changed[0].1, Parts::CASTERS));
    }

    /// For something built from meshes and lights, with one part per light: if a light moves, only its part is rebuilt. If meshes or the
    /// number of lights change, all parts are rebuilt.
    #[test]
    fn a_light_that_moved_is_made_alone() {
        let before = Generations { lights: vec![4, 0, 7], ..Generations::default() };
        let mut made = BuildStamp::of(Parts::MESHES.and(Parts::LIGHTS));
        assert_eq!(made.lights_to_make(&before), [true; 3]);
        made.at = Some(before.clone());
        let with = |change: &dyn Fn(&mut Generations)| {
            let mut now = before.clone();
            change(&mut now);
            made.lights_to_make(&now)
        };
        assert_eq!(with(&|_| ()), [false; 3]);
        assert_eq!(with(&|now| now.particles += 1), [false; 3]);
        assert_eq!(with(&|now| now.lights[1] += 1), [false, true, false]);
        assert_eq!(with(&|now| (now.lights[2], now.particles) = (9, 3)), [false, false, true]);
        assert_eq!(with(&|now| (now.lights[0], now.meshes) = (5, 1)), [true; 3]);
        assert_eq!(with(&|now| now.lights.push(0)), [true; 4]);
    }
}
