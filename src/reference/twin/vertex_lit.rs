//! Pictures under `lighting=vertex`: light is queried at the vertices of each caster's quad and interpolated between them.
//! Twin: glsl/shading/vertex_lit.tesc ([`quad`]) and vertex_lit.tese ([`asked`]).

use crate::reference::truth::{Casters, camera_rays, lift, light, lit_surface};
use crate::scene::{Caster, Picture, Scene, View, far_to_near};
use glam::{DVec2, DVec3};
use rayon::prelude::*;

/// Maximum number of parts into which a quad's side is divided. Twin: MAX_LEVEL.
const MAX_LEVEL: f64 = 64.0;

/// A caster's quad on the screen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quad {
    /// Two opposite corners, in NDC.
    pub corners: [DVec2; 2],
    /// Number of parts into which the quad is divided along x and y.
    pub parts: [usize; 2],
}

/// Returns the quad of a caster, with a vertex at least every `spacing` pixels but at most 64 parts per side; `None` if the caster is
/// behind the camera or outside the picture.
pub fn quad(camera: &View, caster: &Caster, spacing: f64) -> Option<Quad> {
    let size = DVec2::new(camera.width.into(), camera.height.into());
    let axis = |v: [f32; 3]| DVec3::from(v.map(f64::from));
    let radius = f64::from(caster.radius);
    let (mut low, mut high) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
    let mut farthest = f64::NEG_INFINITY;
    for end in [caster.start(), caster.end()] {
        let offset = end - axis(camera.origin);
        let z = offset.dot(axis(camera.forward));
        farthest = farthest.max(z);
        // The sphere around this end is seen between two angles, whose tangents give NDC. If it reaches behind the camera, the quad covers
        // everything.
        let ndc = |across: f64, scale: f32, sign: f64| {
            let (angle, half) = (across.atan2(z), (radius / across.hypot(z)).asin());
            let tangent = if z <= radius { sign * 1e9 } else { (angle + sign * half).tan() };
            tangent * f64::from(scale)
        };
        for sign in [-1.0, 1.0] {
            let x = ndc(offset.dot(axis(camera.right)), camera.scale_x, sign);
            let y = ndc(offset.dot(axis(camera.up)), camera.scale_y, sign);
            (low, high) = (low.min(DVec2::new(x, y)), high.max(DVec2::new(x, y)));
        }
    }
    let margin = 0.125 / size;
    (low, high) = (low - margin, high + margin);
    if farthest + radius <= camera.near.into() || low.max_element() >= 1.0 || high.min_element() <= -1.0 {
        return None;
    }
    let corners = [low, high].map(|c| c.clamp(DVec2::splat(-1.1), DVec2::splat(1.1)));
    let pixels = 0.5 * (corners[1] - corners[0]) * size;
    let parts = |pixels: f64| {
        let least = if pixels > 0.5 * spacing { 2.0 } else { 1.0 };
        (pixels / spacing).ceil().clamp(least, MAX_LEVEL) as usize
    };
    Some(Quad { corners, parts: [parts(pixels.x), parts(pixels.y)] })
}

/// Returns the position at which the vertex at `pixel` queries the caster's light. The mesh that this pixel shows is at z `farthest`.
/// Inside a sphere's silhouette, the position is the one that a pixel would query.
pub fn asked(camera: &View, caster: &Caster, pixel: DVec2, farthest: f64) -> DVec3 {
    let ray = camera.ray(pixel);
    let square = ray.direction.length_squared();
    if caster.is_strand() {
        let without_ray = |v: DVec3| v - v.dot(ray.direction) / square * ray.direction;
        let axis = caster.end() - caster.start();
        let (start, side) = (without_ray(caster.start() - ray.origin), without_ray(axis));
        let wide = side.length_squared() > 1e-10 * axis.length_squared();
        let along = if wide { (-start.dot(side) / side.length_squared()).clamp(0.0, 1.0) } else { 0.5 };
        return caster.start() + along * axis;
    }
    let radius = f64::from(caster.radius);
    let middle = (caster.start() - ray.origin).dot(ray.direction) / square;
    let across = ray.at(middle) - caster.start();
    let half_chord = ((radius * radius - across.length_squared()).max(0.0) / square).sqrt();
    let in_front = farthest < middle - radius / square.sqrt();
    let farthest = if in_front { camera.far.into() } else { farthest };
    let cut = |z: f64| z.min(farthest).max(camera.near.into());
    let z = 0.5 * (cut(middle - half_chord) + cut(middle + half_chord));
    caster.start() + across * (radius / across.length().max(radius)) + (z - middle) * ray.direction
}

/// The light at the vertices of a quad, in rows of parts + 1.
struct Lit {
    quad: Quad,
    light: Vec<DVec3>,
}

impl Lit {
    fn new(casters: &Casters, scene: &Scene, camera: &View, caster: &Caster, spacing: f64) -> Option<Self> {
        let quad = quad(camera, caster, spacing)?;
        let size = DVec2::new(camera.width.into(), camera.height.into());
        let vertex = |i: usize| {
            let row = quad.parts[0] + 1;
            let at = DVec2::new((i % row) as f64, (i / row) as f64) / DVec2::from(quad.parts.map(|n| n as f64));
            let pixel = (0.5 * (quad.corners[0] + at * (quad.corners[1] - quad.corners[0])) + 0.5) * size;
            // The depth of the mesh is known only at the centre of the vertex's pixel.
            let behind = camera.ray(pixel.clamp(DVec2::ZERO, size - 1.0).floor() + 0.5);
            let mesh = casters.meshes.hit(behind.origin, behind.direction).map_or(f64::INFINITY, |hit| hit.distance);
            let position = asked(camera, caster, pixel, mesh.min(camera.far.into()));
            light(casters, scene, position, |towards| lift(caster, towards), |_| 1.0)
        };
        let light = (0..(quad.parts[0] + 1) * (quad.parts[1] + 1)).into_par_iter().map(vertex).collect();
        Some(Self { quad, light })
    }

    /// Returns the minimum and the maximum light at a point in NDC: the device may split a part into triangles along either diagonal.
    fn at(&self, ndc: DVec2) -> [DVec3; 2] {
        let Quad { corners: [low, high], parts } = self.quad;
        let at = (ndc - low) / (high - low) * DVec2::from(parts.map(|n| n as f64));
        let part = at.floor().clamp(DVec2::ZERO, DVec2::from(parts.map(|n| (n - 1) as f64)));
        let DVec2 { x, y } = at - part;
        let first = part.y as usize * (parts[0] + 1) + part.x as usize;
        let [a, b, c, d] = [0, 1, parts[0] + 1, parts[0] + 2].map(|i| self.light[first + i]);
        let falling = if x >= y { a + x * (b - a) + y * (d - b) } else { a + y * (c - a) + x * (d - c) };
        let rising =
            if x + y <= 1.0 { a + x * (b - a) + y * (c - a) } else { d + (1.0 - x) * (c - d) + (1.0 - y) * (b - d) };
        [falling.min(rising), falling.max(rising)]
    }
}

/// Renders the darkest and the brightest picture that a device may draw of `scene` under `lighting=vertex`.
pub fn picture(casters: &Casters, scene: &Scene, camera: &View, spacing: f64) -> [Picture; 2] {
    let lit: Vec<_> = casters.all.iter().map(|c| Lit::new(casters, scene, camera, c, spacing)).collect();
    let order = far_to_near(scene, camera);
    let size = DVec2::new(camera.width.into(), camera.height.into());
    [0, 1].map(|bound| {
        let caster = |pixel, index: Option<u32>, position| {
            // A volume has no vertices: its light is queried at the position itself.
            let Some(index) = index else { return light(casters, scene, position, |_| 0.0, |_| 1.0) };
            let ndc = pixel / size * 2.0 - 1.0;
            // A caster without a quad meets no ray, rounding aside.
            lit[index as usize].as_ref().map_or(DVec3::ZERO, |l| l.at(ndc)[bound])
        };
        let surface = |position, hit: &_| lit_surface(casters, scene, position, hit);
        camera_rays(casters, scene, camera, &order, caster, surface)
    })
}
