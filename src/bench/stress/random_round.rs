//! Everything that the seed of a soak determines: a scene, its motion, and the techniques to query.

use super::meshes::{block, plate, triangles};
use super::scene_builders::{sphere, step};
use crate::scene::{Camera, Light, LightKind, Mesh, Particle, Random, Scene, Strand};
use crate::shading::KEYS;
use crate::technique::{Key, Name, REGISTRY, Spec, Values};
use glam::DVec3;

/// The contents of a round, drawn at random from a seed.
#[derive(Clone, Debug)]
pub(super) struct RandomRound {
    /// The scene, with all casters that occur in any frame.
    pub most: Scene,
    /// The scene in each frame: casters move, grow, shrink, come and go.
    pub frames: Vec<Scene>,
    /// The techniques to query.
    pub specs: Vec<Spec>,
}

/// Number of frames per round.
const FRAMES: usize = 3;

/// Maximum number of texels per side of maps, and of casters of a kind: so few that a round takes a software device about a second.
const TEXELS: f64 = 40.0;
const CASTERS: f64 = 300.0;

/// Maximum value of numeric keys other than sizes. Lists of more entries could exceed the buffer size that every device must be able to
/// bind.
const NUMBER: f64 = 1e5;

/// Draws a round. The same seed gives the same round on every machine.
pub(super) fn drawn(seed: u64) -> RandomRound {
    let mut draw = Draw { random: Random::new([seed, 0x50a1]), unit: 1.0, at: DVec3::ZERO };
    let most = draw.scene(seed);
    let frames = (0..FRAMES).map(|_| draw.frame(&most)).collect();
    let specs = (0..1 + draw.below(3)).filter_map(|_| draw.spec(&most)).collect();
    RandomRound { most, frames, specs }
}

/// The random numbers, with the scene's size (`unit`) and position (`at`).
struct Draw {
    random: Random,
    unit: f64,
    at: DVec3,
}

impl Draw {
    /// Returns a number from 10^`low` to 10^`high`, evenly distributed over decades.
    fn decades(&mut self, low: f64, high: f64) -> f64 {
        10.0_f64.powf(self.random.between(low, high))
    }

    /// Returns an integer below `count`.
    fn below(&mut self, count: usize) -> usize {
        (self.random.between(0.0, count as f64) as usize).min(count.saturating_sub(1))
    }

    fn one_of<T: Copy>(&mut self, all: &[T]) -> Option<T> {
        all.get(self.below(all.len())).copied()
    }

    /// Returns a point in the scene.
    fn place(&mut self) -> DVec3 {
        self.at + self.unit * self.random.in_ball()
    }

    fn way(&mut self) -> DVec3 {
        const AXES: [DVec3; 3] = [DVec3::X, DVec3::NEG_Y, DVec3::NEG_Z];
        let axis = self.one_of(&AXES).filter(|_| self.random.chance(0.1));
        axis.unwrap_or_else(|| self.random.in_ball().normalize_or(DVec3::NEG_Z))
    }

    fn scene(&mut self, seed: u64) -> Scene {
        self.unit = self.decades(-3.0, 4.0);
        if self.random.chance(0.25) {
            self.at = self.unit * self.decades(0.0, 5.0) * self.random.in_ball();
        }
        let (particles, strands, meshes) = (self.particles(), self.strands(), self.meshes());
        let lights = self.lights(&particles);
        let camera = Camera {
            position: self.at + self.unit * DVec3::new(4.0, -5.0, 3.0),
            target: self.at,
            up: DVec3::Z,
            fov_y_degrees: 40.0,
        };
        Scene { name: format!("seed-{seed}"), particles, strands, meshes, lights, camera, ..Scene::default() }
    }

    /// Returns a random number of casters of a kind with probability `share`, otherwise 0.
    fn count(&mut self, share: f64) -> usize {
        let count = self.decades(0.0, CASTERS.log10());
        if self.random.chance(share) { count as usize } else { 0 }
    }

    fn particles(&mut self) -> Vec<Particle> {
        let count = self.count(0.75);
        // Occasionally all particles are in one place, and some have an extreme extinction.
        let (crowded, largest) = (self.random.chance(0.1), self.random.between(-2.5, -0.3));
        let one = |_| {
            let at = if crowded { self.at } else { self.place() };
            let radius = self.unit * self.decades(largest - 1.0, largest);
            let extinction = match self.below(40) {
                0 => 0.0,
                1 => 1e38,
                2 => 1e-38,
                _ => self.decades(-3.0, 1.0) / radius,
            };
            sphere(at, radius, extinction)
        };
        (0..count).map(one).collect()
    }

    fn strands(&mut self) -> Vec<Strand> {
        let count = self.count(0.35);
        let one = |_| {
            let start = self.place();
            let end = start + self.unit * self.decades(-2.0, 0.0) * self.way();
            let radius = (self.unit * self.decades(-3.0, -1.0)) as f32;
            let opacity = match self.below(20) {
                0 => 0.0,
                1 => 1.0,
                _ => self.random.between(0.0, 1.0) as f32,
            };
            let [start, end] = [start, end].map(|p| p.as_vec3().into());
            Strand { start, radius, end, opacity }
        };
        // Far from the origin, rounding may make a strand's ends coincide, which no scene allows.
        (0..count).map(one).filter(|strand: &Strand| strand.start != strand.end).collect()
    }

    fn meshes(&mut self) -> Vec<Mesh> {
        let count = if self.random.chance(0.5) { 1 + self.below(3) } else { 0 };
        let one = |_| {
            let mut mesh = match self.below(3) {
                0 => plate(self.random.between(-1.0, 1.0), self.decades(-1.0, 1.0)),
                1 => {
                    let (a, b) = (self.random.in_ball(), self.random.in_ball());
                    block(a.min(b), a.max(b))
                }
                _ => {
                    let (count, size) = (1 + self.below(60), self.decades(-4.0, 0.0));
                    triangles(count, |_| {
                        let at = self.random.in_ball();
                        [at, at + size * self.random.in_ball(), at + size * self.random.in_ball()]
                    })
                }
            };
            let (at, unit) = (self.at, self.unit);
            for p in &mut mesh.positions {
                *p = (at + unit * DVec3::from(p.map(f64::from))).as_vec3().into();
            }
            mesh
        };
        (0..count).map(one).collect()
    }

    /// Returns lights of a single kind in some rounds, since some techniques support only one kind; otherwise of several kinds.
    fn lights(&mut self, particles: &[Particle]) -> Vec<Light> {
        let kinds = match self.below(6) {
            0 => 3..4,
            1 | 2 => 0..1,
            _ => 0..3,
        };
        let count = [1, 1, 2, 3][self.below(4)];
        let one = |_| {
            let in_smoke = particles.first().filter(|_| self.random.chance(0.1));
            let place = self.at + 1.5 * (self.place() - self.at);
            let position = in_smoke.map_or(place, |p| DVec3::from(p.position.map(f64::from)));
            let way = self.way();
            let kind = match kinds.start + self.below(kinds.len()) {
                0 => LightKind::Directional { direction: way },
                1 => LightKind::Spot { position, direction: way, cone_degrees: self.random.between(1.0, 170.0) },
                2 => LightKind::Point { position },
                _ => LightKind::Virtual { position, normal: way, nearest: 0.05 * self.unit },
            };
            Light { kind, radiance: [1.0; 3], radius: f64::INFINITY }
        };
        (0..count).map(one).collect()
    }

    /// Returns a frame: some of the casters of `most`, moved and resized.
    fn frame(&mut self, most: &Scene) -> Scene {
        let mut scene = most.clone();
        let mut part = |count: usize| match self.below(5) {
            0 => 0,
            1 | 2 => count,
            _ => self.below(count + 1),
        };
        scene.particles.truncate(part(most.particles.len()));
        scene.strands.truncate(part(most.strands.len()));
        step(&mut scene, 0.2 * self.unit * self.random.in_ball());
        let (grown, apart) = (self.decades(-1.0, 0.7), self.unit * self.decades(-4.0, -0.5));
        for p in &mut scene.particles {
            let position = DVec3::from(p.position.map(f64::from)) + apart * self.random.in_ball();
            (p.position, p.radius) = (position.as_vec3().into(), p.radius * grown as f32);
        }
        for light in &mut scene.lights {
            let (by, turned) = (0.2 * self.unit * self.random.in_ball(), 0.3 * self.random.in_ball());
            match &mut light.kind {
                LightKind::Directional { direction } => *direction = (*direction + turned).normalize(),
                LightKind::Point { position } => *position += by,
                LightKind::Spot { position, direction: way, .. } | LightKind::Virtual { position, normal: way, .. } => {
                    (*position, *way) = (*position + by, (*way + turned).normalize());
                }
            }
        }
        scene
    }

    /// Returns a technique that casts from at least one kind of caster in the scene, with about half of its keys set to random values.
    fn spec(&mut self, scene: &Scene) -> Option<Spec> {
        let all: Vec<_> = REGISTRY.iter().filter(|entry| entry.casts.any_of(scene.kinds())).collect();
        let entry = self.one_of(&all)?;
        let mut spec = Spec::new(entry, KEYS);
        for key in entry.all_keys() {
            let is_size = Name::SIZES.contains(&Name::from(key));
            if is_size || self.random.chance(0.5) {
                spec.set(key, &self.value(key, is_size));
            }
        }
        Some(spec)
    }

    /// Returns a random value for a key; small for sizes.
    fn value(&mut self, key: &Key, is_size: bool) -> String {
        match key.values {
            Values::OneOf(words) => {
                let few = if is_size { words.len().min(2) } else { words.len() };
                self.one_of(&words[..few]).unwrap_or(key.default).into()
            }
            Values::Number(low, high) => {
                let most = f64::from(high).min(if is_size { TEXELS } else { NUMBER });
                let number = self.decades(f64::from(low.max(1)).log10(), most.log10()) as u32;
                number.clamp(low, high).to_string()
            }
            Values::Multiple(of, low, high) => {
                let most = (high - low) / of;
                (low + of * (self.below(1 + most.min(15) as usize) as u32)).to_string()
            }
            Values::Path(_) => key.default.into(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A seed must always give the same round, and the next seed a different one. Over 200 seeds, all techniques, kinds of lights and kinds
    /// of scenes must occur.
    #[test]
    fn a_seed_is_a_round() {
        let all: Vec<RandomRound> = (0..200).map(drawn).collect();
        let specs = |drawn: &RandomRound| drawn.specs.iter().map(Spec::to_string).collect::<Vec<_>>();
        for (seed, one) in (0..).zip(&all) {
            let again = drawn(seed);
            assert!(one.most == again.most && one.frames == again.frames && specs(one) == specs(&again), "{seed}");
            assert!(!one.specs.is_empty() && one.frames.len() == FRAMES, "{seed}");
            assert!(seed == 0 || one.most.lights != all[seed as usize - 1].most.lights, "{seed}");
            for scene in one.frames.iter().chain([&one.most]) {
                let finite = |p: &[f32; 3]| p.iter().all(|c| c.is_finite());
                assert!(scene.particles.iter().all(|p| finite(&p.position) && p.radius > 0.0 && p.extinction >= 0.0));
                assert!(scene.strands.iter().all(|s| finite(&s.start) && s.radius > 0.0 && s.opacity <= 1.0));
                assert!(scene.meshes.iter().flat_map(|mesh| &mesh.positions).all(finite), "{seed}");
                // No frame has more casters than the world is allocated for.
                assert!(scene.casters().len() <= one.most.casters().len(), "{seed}");
            }
        }
        for entry in REGISTRY {
            assert!(all.iter().flat_map(|one| &one.specs).any(|spec| spec.entry.name == entry.name), "{}", entry.name);
        }
        let some = |is: fn(&Scene) -> bool| all.iter().any(|one| is(&one.most));
        assert!(some(Scene::has_triangles) && some(|s| !s.strands.is_empty()) && some(|s| s.casters().len() > 200));
        assert!(some(|s| s.casters().is_empty() && s.meshes.is_empty()) && some(|s| s.lights.len() > 1));
        let kinds: std::collections::HashSet<_> =
            all.iter().flat_map(|one| &one.most.lights).map(|light| std::mem::discriminant(&light.kind)).collect();
        assert_eq!(kinds.len(), 4);
    }
}
