//! The particles of a fountain. Bit-identical twin of glsl/animate/simulate/: neither twin divides, fuses or reorders operations, and
//! random numbers are integers.

use super::fountain_law::{Fountain, Jet, Law};
use crate::scene::model::voxels::Bits;
use crate::scene::{Body, Mesh, Particle, Place};
use rayon::prelude::*;
use std::array::from_fn;

/// Data shared by all steps.
pub struct Rules {
    law: Law,
    jets: [Jet; 8],
    place: Place,
    solid: Bits,
}

impl Rules {
    /// Returns the rules of a fountain among these meshes.
    pub fn of(fountain: &Fountain, meshes: &[Mesh]) -> Self {
        let place = fountain.place();
        let corners = |m: &Mesh| -> Vec<_> {
            let corner = |i: u32| place.voxels(m.positions.get(i as usize).copied().unwrap_or_default());
            m.triangles.iter().map(|t| t.map(corner)).collect()
        };
        let solid = Bits::voxelize(meshes.iter().flat_map(corners), place.size);
        Self { law: fountain.law(), jets: fountain.jets(), place, solid }
    }

    /// Returns the voxels that particles bounce off.
    pub fn solid(&self) -> &Bits {
        &self.solid
    }

    /// Returns whether a position is in an occupied voxel.
    pub fn is_solid(&self, position: [f32; 3]) -> bool {
        self.has(voxel_of(&self.place, position))
    }

    fn has(&self, voxel: [i32; 3]) -> bool {
        let inside = voxel.iter().all(|v| (0..self.place.size as i32).contains(v));
        inside && self.solid.has(0, voxel.map(|v| v as u32))
    }

    /// Returns the number of steps since the particle's last birth, and the number of its earlier births.
    pub fn age(&self, particle: u32, step: u32) -> (u32, u32) {
        let at = step + pcg(particle) % self.law.life;
        (at % self.law.life, at / self.law.life)
    }

    /// Advances one particle by one step. Twin: glsl/animate/simulate/step.comp.
    pub fn step(&self, particle: u32, step: u32, attractor: [f32; 3], body: &mut Body) {
        let (age, births) = self.age(particle, step);
        if age == 0 {
            *body = self.birth(particle, births);
        } else {
            self.go(attractor, body);
        }
    }

    /// Twin: birth.
    fn birth(&self, particle: u32, births: u32) -> Body {
        let mut word = pcg(particle ^ pcg(births));
        let mut next = || {
            word = pcg(word);
            word
        };
        let jet = self.jets[(next() & 7) as usize];
        let words: [u32; 6] = from_fn(|_| next());
        let [x, y, z] = from_fn(|i| jet.position[i] + jet.width * (half(words[i] >> 16) - 0.5));
        let spread = |i: usize| jet.spread * ((half(words[i] & 0xFFFF) + half(words[i] >> 16)) - 1.0);
        let [u, v, w] = from_fn(|i| jet.speed[i] + spread(3 + i));
        let share = 0.625 + 0.375 * half(words[0] & 0xFFFF);
        Body { place: [x, y, z, self.law.radius * share], speed: [u, v, w, self.law.extinction] }
    }

    /// Twin: go.
    fn go(&self, attractor: [f32; 3], body: &mut Body) {
        let law = &self.law;
        let [x, y, z, _] = body.place;
        let [u, v, w, _] = body.speed;
        let way: [f32; 3] = [attractor[0] - x, attractor[1] - y, attractor[2] - z];
        let square = way[0] * way[0] + way[1] * way[1] + way[2] * way[2];
        let near = 1.0 - square * law.reach;
        let pull = if near > 0.0 { law.pull * near } else { 0.0 };
        let fall = [0.0, 0.0, law.gravity];
        let mut position = [x, y, z];
        let mut speed = [u, v, w];
        for i in 0..3 {
            speed[i] = ((speed[i] + pull * way[i]) - fall[i]) * law.drag;
            speed[i] = speed[i].clamp(-law.fastest, law.fastest);
            speed[i] = if speed[i].abs() < law.rest { 0.0 } else { speed[i] };
        }
        for axis in 0..3 {
            let to = position[axis] + speed[axis];
            if to < law.low[axis] || to > law.high[axis] || self.is_met(position, axis, to) {
                for (i, speed) in speed.iter_mut().enumerate() {
                    *speed *= if i == axis { -law.bounce } else { law.slide };
                }
            } else {
                position[axis] = to;
            }
        }
        body.place[..3].copy_from_slice(&position);
        body.speed[..3].copy_from_slice(&speed);
    }

    /// Returns whether a move along an axis enters an occupied voxel. Twin: is_met.
    fn is_met(&self, from: [f32; 3], axis: usize, to: f32) -> bool {
        let mut voxel = voxel_of(&self.place, from);
        let mut end = from;
        end[axis] = to;
        let last = voxel_of(&self.place, end)[axis];
        while voxel[axis] != last {
            voxel[axis] += (last - voxel[axis]).signum();
            if self.has(voxel) {
                return true;
            }
        }
        false
    }

    /// Returns the particle as a caster, which fades in after birth and out before its end. Twin: the end of main in
    /// glsl/animate/simulate/step.comp.
    fn particle(&self, age: u32, body: &Body) -> Particle {
        let [x, y, z, radius] = body.place;
        let appear = (age + 1) as f32 * self.law.appear;
        let vanish = (self.law.life - age) as f32 * self.law.vanish;
        let extinction = body.speed[3] * appear.min(vanish).min(1.0);
        Particle { position: [x, y, z], radius, extinction }
    }
}

/// Returns all particles at a step. Each is simulated only from its last birth, so that later steps cost no more.
pub fn bodies(fountain: &Fountain, rules: &Rules, step: u32) -> Vec<Body> {
    let first = (step + 1).saturating_sub(rules.law.life);
    let attractors: Vec<_> = (first..=step).map(|s| fountain.attractor(s)).collect();
    let followed = (0..fountain.particles).into_par_iter().map(|particle| {
        let mut body = Body::default();
        let born = step - rules.age(particle, step).0.min(step);
        for s in born..=step {
            rules.step(particle, s, attractors[(s - first) as usize], &mut body);
        }
        body
    });
    followed.collect()
}

/// Returns all particles at a step, as casters.
pub fn particles(fountain: &Fountain, meshes: &[Mesh], step: u32) -> Vec<Particle> {
    let rules = Rules::of(fountain, meshes);
    let bodies = bodies(fountain, &rules, step);
    let seen = |(i, body): (u32, &Body)| rules.particle(rules.age(i, step).0, body);
    (0..).zip(&bodies).map(seen).collect()
}

/// Hashes a number to a pseudo-random number. Source: Jarzynski and Olano 2020, Hash functions for GPU rendering, pcg. Twin: pcg.
pub fn pcg(value: u32) -> u32 {
    let state = value.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
    let word = ((state >> ((state >> 28) + 4)) ^ state).wrapping_mul(277_803_737);
    (word >> 22) ^ word
}

/// Converts sixteen bits to a number from 0 to 1, exactly. Twin: share_of.
fn half(bits: u32) -> f32 {
    bits as f32 * (1.0 / 65536.0)
}

fn voxel_of(place: &Place, position: [f32; 3]) -> [i32; 3] {
    place.voxels(position).map(|v| v.floor() as i32)
}
