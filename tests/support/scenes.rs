//! Small scenes with the cases in which shadow techniques fail.

use glam::DVec3;
use gobo::scene::{
    Alpha, AlphaMode, AlphaTexture, Camera, Light, LightKind, Mesh, Particle, Scene, Splat, Strand, Wrap,
};
use rand::Rng;
use rand_pcg::Pcg32;
use std::sync::Arc;

/// Returns a scene of these particles under a directional light.
pub fn directional(name: &str, direction: [f64; 3], particles: Vec<Particle>) -> Scene {
    Scene {
        name: name.into(),
        particles,
        lights: vec![Light {
            kind: LightKind::Directional { direction: DVec3::from(direction).normalize() },
            radiance: [1.0; 3],
            radius: f64::INFINITY,
        }],
        camera: Camera { position: DVec3::new(4.0, -5.0, 3.0), target: DVec3::ZERO, up: DVec3::Z, fov_y_degrees: 40.0 },
        ..Scene::default()
    }
}

/// Returns the scene under a spot light at `position` that points at the origin.
pub fn spot(position: [f64; 3], cone_degrees: f64, scene: Scene) -> Scene {
    let position = DVec3::from(position);
    let kind = LightKind::Spot { position, direction: -position.normalize(), cone_degrees };
    Scene { lights: vec![Light { kind, radiance: [1.0; 3], radius: f64::INFINITY }], ..scene }
}

/// Returns the scene under a point light.
pub fn point(position: [f64; 3], scene: Scene) -> Scene {
    let kind = LightKind::Point { position: DVec3::from(position) };
    Scene { lights: vec![Light { kind, radiance: [1.0; 3], radius: f64::INFINITY }], ..scene }
}

/// Random numbers that are the same on every machine.
pub struct Random(Pcg32);

impl Random {
    pub fn new(seed: u64) -> Self {
        Self(Pcg32::new(seed, 0x60b0))
    }

    pub fn bits(&mut self) -> u32 {
        self.0.next_u32()
    }

    /// Returns the underlying generator.
    pub fn generator(&mut self) -> &mut Pcg32 {
        &mut self.0
    }

    /// Draws a number in [low, high].
    pub fn between(&mut self, low: f32, high: f32) -> f32 {
        low + (high - low) * (self.bits() as f32 / u32::MAX as f32)
    }

    pub fn point(&mut self, low: f32, high: f32) -> [f32; 3] {
        [(); 3].map(|()| self.between(low, high))
    }
}

/// Direction of a light oblique to all axes, so that no coordinate drops out of the arithmetic.
const SLANTED: [f64; 3] = [0.5, 0.3, -0.81];

/// Spheres of many sizes, thin and dense, at random in a cube. One in eight has extinction 0.
pub fn random() -> Scene {
    let mut random = Random::new(1);
    let particles = (0..400)
        .map(|i| {
            let radius = random.between(0.05, 0.45);
            let depth = random.between(0.02, 0.8);
            let extinction = if i % 8 == 0 { 0.0 } else { depth / (2.0 * radius) };
            Particle { position: random.point(-1.0, 1.0), radius, extinction }
        })
        .collect();
    directional("random", SLANTED, particles)
}

/// Every sphere three times, twice with the same extinction: equal entry depths everywhere.
pub fn duplicates() -> Scene {
    let mut random = Random::new(2);
    let mut particles = Vec::new();
    for _ in 0..24 {
        let first = Particle { position: random.point(-1.0, 1.0), radius: random.between(0.2, 0.6), extinction: 0.5 };
        particles.extend([first, Particle { extinction: 1.5, ..first }, first]);
    }
    directional("duplicates", SLANTED, particles)
}

/// Concentric spheres: every segment lies within the previous one. Listed from the inside out, so that index order is the opposite of depth
/// order.
pub fn nested() -> Scene {
    let mut random = Random::new(3);
    let mut particles = Vec::new();
    for _ in 0..6 {
        let position = random.point(-0.8, 0.8);
        let extinction = random.between(0.05, 0.5);
        particles.extend((1..=14).map(|i| Particle { position, radius: 0.06 * i as f32, extinction }));
    }
    directional("nested", SLANTED, particles)
}

/// Thin spheres, some of them so dense that their optical depth is clamped at 80.
pub fn opaque() -> Scene {
    let mut random = Random::new(4);
    let particles = (0..90)
        .map(|i| Particle {
            position: random.point(-1.0, 1.0),
            radius: random.between(0.1, 0.35),
            extinction: if i % 9 == 0 { 1e6 } else { 0.4 },
        })
        .collect();
    directional("opaque", SLANTED, particles)
}

/// Draws spheres at random in a cube of half side `half`, with radius and extinction in the given ranges.
fn cloud(seed: u64, count: usize, half: f32, radius: [f32; 2], extinction: [f32; 2]) -> Vec<Particle> {
    let mut random = Random::new(seed);
    let particle = |_| Particle {
        position: random.point(-half, half),
        radius: random.between(radius[0], radius[1]),
        extinction: random.between(extinction[0], extinction[1]),
    };
    (0..count).map(particle).collect()
}

/// Hundreds of large, thin, overlapping spheres: many more segments per texel than the list starts with.
pub fn crowd() -> Scene {
    directional("crowd", SLANTED, cloud(5, 400, 0.7, [0.5, 0.9], [0.002, 0.02]))
}

/// Small spheres, so many that a tile has more than the 1,024 that its sort keeps in shared memory, but few per texel.
pub fn dense() -> Scene {
    directional("dense", SLANTED, cloud(11, 2500, 1.0, [0.1, 0.16], [0.2, 2.0]))
}

/// Moves a point along a direction.
fn moved(point: [f32; 3], direction: [f32; 3], by: f32) -> [f32; 3] {
    [0, 1, 2].map(|i| point[i] + by * direction[i])
}

/// Strands in all directions: some along the light, some across it, some of opacity 0, some of 1, some sharing both ends.
pub fn strands() -> Scene {
    let mut random = Random::new(6);
    let mut scene = directional("strands", SLANTED, Vec::new());
    let light = match scene.lights[0].kind {
        LightKind::Directional { direction } => direction.as_vec3().to_array(),
        _ => unreachable!("directional"),
    };
    for i in 0..260 {
        let start = random.point(-1.0, 1.0);
        let length = random.between(0.1, 0.9);
        let end = match i % 13 {
            // Edge-on: absorbs nothing, and must not give 0/0.
            0 => moved(start, light, length),
            1 => moved(start, light, -length),
            _ => moved(start, random.point(-1.0, 1.0), length),
        };
        let opacity = match i % 8 {
            0 => 0.0,
            1 => 1.0,
            _ => random.between(0.05, 0.6),
        };
        scene.strands.push(Strand { start, radius: random.between(0.03, 0.12), end, opacity });
        if i % 20 == 2 {
            scene.strands.push(Strand { start, radius: 0.1, end, opacity: 0.3 });
        }
    }
    scene
}

/// Bundles of strands of one width each, from thin to wide: stacked along the light, edge to edge, both, and crossing.
pub fn bundles() -> Scene {
    let mut random = Random::new(12);
    let mut scene = directional("bundles", SLANTED, Vec::new());
    let light = DVec3::from(SLANTED).normalize();
    for i in 0..32 {
        let start = DVec3::from(random.point(-0.8, 0.8).map(f64::from));
        let axis = DVec3::from(random.point(-0.7, 0.7).map(f64::from));
        let across = axis.cross(light).normalize_or(DVec3::X);
        let radius = [0.004, 0.03, 0.1][i % 3];
        let opacity = random.between(0.2, 0.9);
        for k in 0..5 {
            // No two strands at the same depth.
            let behind = light * (0.04 + 0.06 * f64::from(k));
            let beside = across * 2.0 * radius * f64::from(k);
            let (from, along) = match i % 4 {
                0 => (start + behind, axis),
                1 => (start + 0.3 * behind + beside, axis),
                2 => (start + behind + f64::from(k / 2) * beside, axis),
                _ => (start + behind, if k % 2 == 0 { axis } else { across * axis.length() }),
            };
            let [start, end] = [from, from + along].map(|at| at.as_vec3().to_array());
            scene.strands.push(Strand { start, radius: radius as f32, end, opacity });
        }
    }
    scene
}

/// Splats of all shapes, up to 8 times as long as wide, some across each other, amid smoke; a light looks along one of them.
pub fn splats() -> Scene {
    let mut random = Random::new(31);
    let mut scene = directional("splats", SLANTED, vec![]);
    scene.particles.push(Particle { position: [0.2, -0.1, 0.3], radius: 0.4, extinction: 0.8 });
    for i in 0..60 {
        let place = if i % 10 == 0 { 0.0 } else { 0.8 };
        let position = [0, 1, 2].map(|_| random.between(-place, place));
        let long = random.between(0.08, 0.3);
        let deviations = [long, long * random.between(0.125, 1.0), long * random.between(0.125, 1.0)];
        let turn = [0, 1, 2, 3].map(|_| random.between(-1.0, 1.0));
        let length = turn.iter().map(|x| x * x).sum::<f32>().sqrt().max(0.1);
        let rotation = turn.map(|x| x / length);
        let opacity = if i % 7 == 0 { 1.0 } else { random.between(0.05, 0.9) };
        scene.splats.push(Splat { position, deviations, rotation, opacity, color: [0.6, 0.5, 0.4] });
    }
    scene
}

/// Locks of polylines amid smoke: joints, strands inside spheres, and in most texels more steps than a curve has nodes.
pub fn locks() -> Scene {
    let mut scene = directional("locks", SLANTED, random().particles);
    scene.particles.truncate(40);
    let mut random = Random::new(7);
    for _ in 0..100 {
        let mut start = random.point(-0.8, 0.8);
        let (radius, opacity) = (random.between(0.04, 0.1), random.between(0.02, 0.4));
        let direction = random.point(-0.2, 0.2);
        for _ in 0..10 {
            let end = moved(moved(start, direction, 1.0), random.point(-1.0, 1.0), 0.1);
            scene.strands.push(Strand { start, radius, end, opacity });
            start = end;
        }
    }
    scene
}

/// A point light amid smoke: spheres surround it, cross the edges of its faces and extend partly behind them.
pub fn inside() -> Scene {
    let mut scene = point([0.2, -0.1, 0.3], random());
    scene.particles.truncate(120);
    scene.name = "inside".into();
    scene
}

/// A point light beside smoke: some of its faces see nothing.
pub fn beside() -> Scene {
    let mut scene = point([2.5, 0.3, 0.2], random());
    scene.particles.truncate(120);
    scene.name = "beside".into();
    scene
}

/// Two point lights, a spot and a directional light on the same smoke.
pub fn four_lights() -> Scene {
    let mut scene = random();
    let lights = [inside(), spot([2.0, 1.0, 3.0], 60.0, random()), random(), beside()];
    scene.lights = lights.into_iter().flat_map(|s| s.lights).collect();
    scene.name = "four-lights".into();
    scene
}

/// A flat quad, two triangles, facing any way.
pub fn quad(corners: [[f32; 3]; 4], albedo: f32) -> Mesh {
    Mesh {
        name: "quad".into(),
        positions: corners.to_vec(),
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        albedo: [albedo; 3],
        solid: false,
        alpha: None,
    }
}

/// A square at `height` with half side `half`, centred at (x, y).
pub fn level(height: f32, half: f32, [x, y]: [f32; 2]) -> Mesh {
    let corner = |dx: f32, dy: f32| [x + dx * half, y + dy * half, height];
    quad([corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)], 0.6)
}

/// A closed box from `low` to `high`, with counter-clockwise outer faces.
pub fn cuboid(low: [f32; 3], high: [f32; 3]) -> Mesh {
    let corner = |i: usize| [0, 1, 2].map(|axis| if i >> axis & 1 == 1 { high[axis] } else { low[axis] });
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    Mesh {
        name: "box".into(),
        positions: (0..8).map(corner).collect(),
        triangles: quads.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]).collect(),
        albedo: [0.5; 3],
        solid: false,
        alpha: None,
    }
}

/// Texture of an oval leaf, `side` texels wide and high, with a soft edge and a hole in the middle.
pub fn leaf(side: u32, wrap: Wrap) -> AlphaTexture {
    let alpha = |i: u32| {
        let at = |i: u32| (i as f32 + 0.5) / side as f32 * 2.0 - 1.0;
        let (x, y) = (at(i % side), at(i / side));
        let away = (x * x + 1.8 * y * y).sqrt();
        let edge = |by: f32| (by * side as f32 * 0.5 + 0.5).clamp(0.0, 1.0);
        (255.0 * edge(0.9 - away).min(edge(away - 0.25))) as u8
    };
    AlphaTexture { size: [side; 2], wrap: [wrap; 2], texels: (0..side * side).map(alpha).collect() }
}

/// Returns a card with holes: a quad whose corners have the texture's corners.
pub fn card(corners: [[f32; 3]; 4], cutoff: f32, texture: AlphaTexture) -> Mesh {
    let alpha = Alpha {
        uvs: vec![[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]],
        texture: Some(Arc::new(texture)),
        ..Alpha::constant(AlphaMode::Cut(cutoff), 1.0, 4)
    };
    Mesh { alpha: Some(alpha), ..quad(corners, 0.6) }
}

/// Cards with holes over a ground: big and small ones, facing any way, cut from textures of 1 to 64 texels wide that continue in every
/// way, by places far outside the texture, by factors that fall across the card, and one that light passes through altogether.
pub fn cards(seed: u64) -> Scene {
    let mut random = Random::new(seed);
    let mut scene = directional("cards", [0.4, 0.35, -0.8], Vec::new());
    scene.meshes.push(level(-1.0, 1.6, [0.0, 0.0]));
    for i in 0..36_usize {
        let (at, right, up) = (random.point(-0.8, 0.8), random.point(-1.0, 1.0), random.point(-1.0, 1.0));
        let half = [0.6, 0.25, 0.1][i % 3];
        let corner = |x: f32, y: f32| [0, 1, 2].map(|c| at[c] + half * (x * right[c] + y * up[c]));
        let corners = [corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
        let wrap = [Wrap::Repeat, Wrap::Mirror, Wrap::Clamp][i / 3 % 3];
        let mut mesh = card(corners, [0.5, 0.1, 0.9, 1.0][i % 4], leaf([16, 1, 64, 5, 33][i % 5], wrap));
        let alpha = mesh.alpha.as_mut().expect("a card has alpha");
        if i % 4 == 1 {
            let turn = random.between(-2.0, 2.0);
            alpha.uvs.iter_mut().for_each(|uv| *uv = [3.0 * uv[0] + turn, 2.0 * uv[1] - turn * uv[0]]);
        }
        if i % 5 == 3 {
            alpha.factors = vec![1.0, 0.2, 0.6, 0.0];
        }
        if i % 7 == 6 {
            alpha.texture = None;
            alpha.uvs.clear();
            alpha.factors = vec![1.0, 0.0, 0.3, 0.8];
        }
        if i == 20 {
            alpha.mode = AlphaMode::SeeThrough;
        }
        scene.meshes.push(mesh);
    }
    scene
}
