//! Counters that say which part of a world has changed since something was built from it.

use super::World;

/// Parts of a world that something is built from.
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
    /// Where the lights stand. Their colours are looked up and make nothing.
    pub const LIGHTS: Self = Self(8);
    /// The scene's camera.
    pub const CAMERA: Self = Self(16);
    /// The box about all that casts.
    pub const BOX: Self = Self(32);
    /// Nothing of it.
    pub const NONE: Self = Self(0);
    /// All of them.
    pub const ALL: Self = Self(63);

    /// These and those.
    pub const fn and(self, those: Self) -> Self {
        Self(self.0 | those.0)
    }

    /// These but for those.
    const fn without(self, those: Self) -> Self {
        Self(self.0 & !those.0)
    }

    const fn has(self, one: Self) -> bool {
        self.0 & one.0 != 0
    }
}

/// How often each part of a world has changed.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Generations {
    /// Opaque triangles.
    pub meshes: u64,
    /// Spheres of smoke.
    pub particles: u64,
    /// Hair.
    pub strands: u64,
    /// Where each light stands.
    pub lights: Vec<u64>,
    /// The scene's camera.
    pub camera: u64,
    /// The box about all that casts.
    pub bounds: u64,
}

impl Generations {
    /// Whether none of `parts` has changed from these to those.
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

/// Something that is made of parts of a world, and of which state of it.
#[derive(Clone, Debug)]
pub struct Made {
    of: Parts,
    at: Option<Generations>,
}

impl Made {
    /// Not made yet.
    pub fn of(parts: Parts) -> Self {
        Self { of: parts, at: None }
    }

    /// Whether it is made of the world as it is now.
    pub fn stands(&self, world: &World) -> bool {
        self.at.as_ref().is_some_and(|at| at.agree(world.generations(), self.of))
    }

    /// Whether it has to be made of the world as it is now; the caller does so.
    pub fn make(&mut self, world: &World) -> bool {
        let make = !self.stands(world);
        if make {
            self.at = Some(world.generations().clone());
        }
        make
    }

    /// The same of something of which each light has its own: per light, whether that has to be made. Where more has changed than
    /// lights, all of it.
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

    /// Whatever it was made of, it is made again.
    pub fn forget(&mut self) {
        self.at = None;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A part that something is not made of may change.
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

    /// Where one light moved it is that one's, where something else has changed or there are others it is all of them.
    #[test]
    fn a_light_that_moved_is_made_alone() {
        let before = Generations { lights: vec![4, 0, 7], ..Generations::default() };
        let mut made = Made::of(Parts::MESHES.and(Parts::LIGHTS));
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
