//! Points closer to the edge of an opaque shadow than a technique can resolve: errors there come from the resolution, not from the method.

use super::casters::Casters;
use super::shaft::Neighbourhood;
use super::tube::Tube;
use crate::scene::{LightKind, Moved, Projection, Resolution};
use glam::DVec3;

/// Half the side of the smallest square of test positions around a point, in texels. It is below one texel, so that features thinner than a
/// texel are found.
const NEAREST: f64 = 0.5;

/// Largest spacing of test positions along such a square, in texels.
const APART: f64 = 2.0625;

/// Cosine between surface normal and light rays below which the light grazes the surface. A texel then covers so much of the surface that
/// no map can be right there.
const GRAZING: f64 = 0.02;

impl Casters<'_> {
    /// Returns whether a point lies in the boundary of an opaque shadow of light `light`: whether some other point, closer than the
    /// technique resolves across or along the light's rays, is blocked while this one is not, or the reverse. A point inside a closed mesh
    /// also counts if the technique may return anything there.
    pub fn in_boundary(&self, light: usize, resolution: &Resolution, position: DVec3) -> bool {
        if resolution.voxel > 0.0 {
            return self.ray_in_boundary(light, resolution, position, None);
        }
        let blocked = !self.unblocked(light, position);
        if resolution.snap_texels > 0.0 {
            return self.is_misjudged(resolution, position, blocked, None);
        }
        // For points in space, a paraboloid map compares distances without a bias, so the full depth counts.
        self.differs_about(resolution, position, depth(resolution), blocked)
    }

    /// Like [`Casters::in_boundary`], for a point on a surface with normal `normal`. If look-ups move the point off the surface, the moved
    /// point is tested.
    pub fn in_surface_boundary(&self, light: usize, resolution: &Resolution, position: DVec3, normal: DVec3) -> bool {
        if resolution.voxel > 0.0 {
            return self.ray_in_boundary(light, resolution, position, Some(normal));
        }
        let view = resolution.view_about(position);
        let ([right, up], along) = (view.texel_at(position), view.ray_through(position).direction);
        let facing = normal.dot(along) / along.length();
        let is_behind = view.projection() == Projection::Perspective && view.axes(position).z <= 0.0;
        if is_behind || facing.abs() < GRAZING {
            return true;
        }
        let blocked = !self.unblocked(light, position);
        let at = resolution.looked_up(position, normal);
        if resolution.snap_texels > 0.0 {
            // A surface that faces away from the light blocks its own light.
            return facing < 0.0 && self.is_misjudged(resolution, at, blocked, Some(normal));
        }
        if resolution.moved != Moved::default() {
            return resolution.free_inside && self.inside(light, at)
                || self.differs_about(resolution, at, resolution.moved.felt * range(resolution), blocked);
        }
        let within = |v: DVec3| v - along * (normal.dot(v) / normal.dot(along));
        let near = self::depth(resolution) + resolution.nearer_texels * right.length();
        let (right, up) = (within(right), within(up));
        let depth = near * along;
        let differs = |offset: DVec3| self.unblocked(light, position + offset) == blocked;
        offsets(resolution.reach_texels).any(|[x, y]| differs(x * right + y * up))
            || [-depth, depth].into_iter().any(|depth| !self.meshes.free(position, depth, 1.0))
            || self.is_missed(resolution, position, near, blocked)
    }

    /// Returns whether a texel may show a `blocked` point as lit, or a lit point as blocked, because its depth is compared with the plane
    /// of the point's surface.
    fn is_missed(&self, resolution: &Resolution, position: DVec3, depth: f64, blocked: bool) -> bool {
        let (view, reach) = (resolution.view_about(position), resolution.pushed_texels);
        let texel = Neighbourhood { view: &view, position, reach, depth };
        reach > 0.0 && texel.differs_pushed(&self.meshes, blocked, reach)
    }

    /// Returns whether a texel of a depth map may be wrong at a position: lit although the position is `blocked`, or blocked although it is
    /// lit. If a surface's `normal` is given, only meshes above the plane of that surface count.
    fn is_misjudged(&self, resolution: &Resolution, at: DVec3, blocked: bool, normal: Option<DVec3>) -> bool {
        let view = &resolution.view;
        let near = Neighbourhood { view, position: at, reach: resolution.reach_texels, depth: depth(resolution) };
        near.is_behind() || near.differs_stored(&self.meshes, blocked, normal, resolution.snap_texels)
    }

    /// Returns whether the light's state differs from `blocked` anywhere in a box around a point, which extends by the technique's reach
    /// across the rays and by `depth` along them. Also true if part of the box may be inside a closed mesh.
    fn differs_about(&self, resolution: &Resolution, position: DVec3, depth: f64, blocked: bool) -> bool {
        let view = resolution.view_about(position);
        let near = Neighbourhood { view: &view, position, reach: resolution.reach_texels, depth };
        near.is_behind()
            || resolution.free_inside && near.meets_closed(&self.meshes)
            || near.differs(&self.meshes, blocked)
    }

    /// Returns whether a ray through a grid may give a wrong result at a point, on a surface with `normal` or in space. A lit point may
    /// look dark if a surface meets a voxel that the ray may pass through. A dark point may look lit if its moved ray hits no mesh. Where
    /// rounding shifts rays, this applies to any ray within the rounding error. Points whose surface faces away from the light are not
    /// moved, except for rays against triangles.
    fn ray_in_boundary(&self, light: usize, resolution: &Resolution, position: DVec3, normal: Option<DVec3>) -> bool {
        // A virtual light sits on a surface, so the end of the ray is moved off that surface, just as a receiver is.
        let end = match self.scene.lights[light].kind {
            LightKind::Virtual { position, normal, .. } => Some(resolution.looked_up(position, normal)),
            _ => None,
        };
        let to_light = |p: DVec3| end.map_or_else(|| self.to_light(light, p), |end| (end - p, 1.0));
        let normal = normal.filter(|normal| resolution.rounded || normal.dot(to_light(position).0) > 0.0);
        let at = normal.map_or(position, |normal| resolution.looked_up(position, normal));
        let (direction, distance) = to_light(at);
        let along = resolution.bias * resolution.voxel / direction.length().max(1e-30);
        let [later, earlier] = [normal.is_some(), end.is_some()].map(|is_on| if is_on { along } else { 0.0 });
        let at = at + direction * later.min(distance);
        let distance = (distance - later - earlier).max(0.0);
        if !self.unblocked(light, position) {
            if !resolution.rounded {
                return self.meshes.free(at, direction, distance);
            }
            // A ray against triangles starts at the point itself.
            let (direction, distance) = to_light(position);
            let free = |offset: DVec3| self.meshes.free(position + resolution.voxel * offset, direction, distance);
            let corner = |i: u32| DVec3::from([0, 1, 2].map(|axis| if i >> axis & 1 == 1 { 1.0 } else { -1.0 }));
            return free(DVec3::ZERO) || (0..8).map(corner).any(free);
        }
        // For a light at infinity: a length that reaches beyond every mesh.
        let way = if distance.is_finite() {
            direction * distance
        } else {
            direction * (4.0 * self.meshes.extent + at.length())
        };
        Tube::new(at, way, resolution.voxel).is_met(&self.meshes)
    }
}

/// Returns the depth that a technique resolves along a ray, in multiples of the ray's direction.
fn depth(resolution: &Resolution) -> f64 {
    resolution.depth * range(resolution)
}

/// Returns the length of a view's depth range.
fn range(resolution: &Resolution) -> f64 {
    f64::from(resolution.view.far - resolution.view.near)
}

/// Returns the offsets to test around a point, in texels. They lie on concentric squares: one of half side `reach`, one of [`NEAREST`], and
/// one per whole texel in between.
fn offsets(reach: f64) -> impl Iterator<Item = [f64; 2]> {
    let between = (1..).map(f64::from).take_while(move |texels| texels + 1.0 <= reach);
    [reach, NEAREST.min(reach)].into_iter().chain(between).flat_map(square)
}

/// Returns positions along the sides of a square of half side `reach`.
fn square(reach: f64) -> impl Iterator<Item = [f64; 2]> {
    let parts = (2.0 * reach / APART).ceil().max(2.0) as u32;
    let place = move |i: u32| reach * (2.0 * f64::from(i) / f64::from(parts) - 1.0);
    let all = (0..=parts).flat_map(move |x| (0..=parts).map(move |y| [x, y]));
    all.filter(move |at| at.iter().any(|i| *i == 0 || *i == parts)).map(move |at| at.map(place))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::tests::on_the_axis;
    use crate::scene::{Mesh, Moved, Scene, View};
    use glam::DVec2;

    /// Builds a square from −1 to 1 at z = 0, under a light shining straight down.
    fn plate() -> Scene {
        let mut scene = on_the_axis(&[(0.0, 2.0, 0.1)]);
        scene.meshes.push(Mesh {
            name: "plate".into(),
            positions: vec![[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]],
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            albedo: [0.5; 3],
            solid: false,
            alpha: None,
        });
        scene
    }

    /// Returns the resolution of the scene's light for a map 64 texels wide, and the side of a texel in world units.
    fn resolution(scene: &Scene, reach_texels: f64, depth: f64) -> (Resolution, f64) {
        let view = View::opaques(scene, 64)[0];
        (Resolution { view, reach_texels, depth, ..Resolution::exact(view) }, 2.0 / (f64::from(view.scale_x) * 64.0))
    }

    /// The boundary extends two texels to either side of the edge of the plate's shadow. The centre of the shadow, the light beside it and
    /// the space above the plate are outside it.
    #[test]
    fn two_texels_about_the_edge() {
        let scene = plate();
        let casters = Casters::new(&scene);
        let (resolution, texel) = resolution(&scene, 2.0625, 1e-5);
        let near = |x: f64, z: f64| casters.in_boundary(0, &resolution, DVec3::new(x, 0.1, z));
        for share in [-1.9, -0.9, -0.4, 0.4, 0.9, 1.9] {
            assert!(near(1.0 + share * texel, -1.0), "{share} texels from the edge");
            assert!(!near(1.0 + share * texel, 0.5), "above the plate");
        }
        for x in [0.0, 0.5, 1.0 - 2.2 * texel, 1.0 + 2.2 * texel, 1.5] {
            assert!(!near(x, -1.0), "at {x}");
        }
        // Just behind the plate, a stored depth may round to either side.
        let range = f64::from(resolution.view.far - resolution.view.near);
        let rounded = Resolution { depth: 1e-5 / range, ..resolution };
        let near = |z: f64| casters.in_boundary(0, &rounded, DVec3::new(0.2, 0.1, z));
        assert!(near(-1e-6) && !near(-1e-3));
    }

    /// The boundary extends to either side of the shadow's edge as far as rounding may shift a ray. The plate's own surface is outside it.
    #[test]
    fn rays_that_are_rounded() {
        let scene = plate();
        let casters = Casters::new(&scene);
        let resolution = Resolution::of_triangles(View::opaques(&scene, 1)[0], 1e-3);
        let near = |x: f64, z: f64| casters.in_boundary(0, &resolution, DVec3::new(x, 0.1, z));
        for (offset, is_near) in [(-1.1e-3, false), (-0.9e-3, true), (0.9e-3, true), (1.1e-3, false)] {
            assert_eq!(near(1.0 + offset, -1.0), is_near, "{offset}");
            assert!(!near(1.0 + offset, 0.5), "above the plate");
            assert!(!casters.in_surface_boundary(0, &resolution, DVec3::new(1.0 - offset.abs(), 0.1, 0.0), DVec3::Z));
        }
    }

    /// Returns the resolution of a depth map.
    fn of_depths(scene: &Scene, reach_texels: f64, depth: f64) -> Resolution {
        let moved = Moved { across: 0.25, least_world: 1e-6, ..Moved::default() };
        Resolution { snap_texels: 0.0625, moved, ..resolution(scene, reach_texels, depth).0 }
    }

    /// A plate's own surface is outside the boundary, except where the light grazes it.
    #[test]
    fn a_surface_is_no_boundary_of_itself() {
        let scene = plate();
        let casters = Casters::new(&scene);
        let resolution = of_depths(&scene, 2.0625, 1e-5);
        let near = |x: f64| casters.in_surface_boundary(0, &resolution, DVec3::new(x, 0.1, 0.0), DVec3::Z);
        assert!(!near(0.0) && !near(0.8));
        assert!(casters.in_surface_boundary(0, &resolution, DVec3::ZERO, DVec3::X), "along the rays");
    }

    /// With a wide reach, a caster two texels wide is found anywhere within the reach, but not beyond it.
    #[test]
    fn a_wide_reach_has_no_gaps() {
        let mut scene = plate();
        let (resolution, texel) = resolution(&scene, 6.0, 1e-5);
        for (x, y) in [(5.9, 0.0), (3.0, 5.9), (-1.0, 2.0), (0.0, 0.4), (-5.9, 5.9)] {
            let ([x, y], half) = ([x, y].map(|c: f64| (c * texel) as f32), (1.1 * texel) as f32);
            let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
            scene.meshes[0].positions = corners.map(|[i, j]| [x + i * half, y + j * half, 0.0]).into();
            let casters = Casters::new(&scene);
            let near = |x: f64| casters.in_boundary(0, &resolution, DVec3::new(x * texel, 0.0, -1.0));
            assert!(near(0.0), "{x} {y}");
            assert!(!near(20.0), "{x} {y}");
        }
    }

    /// A surface is in the boundary if and only if another surface lies in front of it by less than the resolved depth.
    #[test]
    fn surfaces_that_touch_along_the_rays() {
        let mut scene = plate();
        let mut below = scene.meshes[0].clone();
        below.positions.iter_mut().for_each(|p| p[2] = -0.1);
        scene.meshes.push(below);
        let casters = Casters::new(&scene);
        let fine = of_depths(&scene, 2.0625, 1e-5);
        let range = f64::from(fine.view.far - fine.view.near);
        let near = |z: f64, depth: f64| {
            let resolution = Resolution { depth: depth / range, ..fine };
            casters.in_surface_boundary(0, &resolution, DVec3::new(0.1, 0.2, z), DVec3::Z)
        };
        let below = f64::from(-0.1f32);
        assert!(!near(below, 0.09) && near(below, 0.11));
        assert!(!near(0.0, 0.09) && !near(0.0, 0.11));
    }

    /// A needle and a slit are found however thin they are; a plate made of many triangles counts as having no slits.
    #[test]
    fn nothing_is_too_thin() {
        let mut scene = plate();
        let (resolution, texel) = resolution(&scene, 2.0625, 1e-5);
        let near = |scene: &Scene, x: f64, y: f64| {
            Casters::new(scene).in_boundary(0, &resolution, DVec3::new(x * texel, y * texel, -1.0))
        };
        let bar = |from: f64, to: f64| [[from, -1.0], [to, -1.0], [to, 1.0], [from, 1.0]];
        let placed = |scene: &mut Scene, bars: &[[[f64; 2]; 4]]| {
            let mesh = &mut scene.meshes[0];
            mesh.positions = bars.iter().flatten().map(|[x, y]| [*x as f32, *y as f32, 0.0]).collect();
            let quad = |i: u32| [[4 * i, 4 * i + 1, 4 * i + 2], [4 * i, 4 * i + 2, 4 * i + 3]];
            mesh.triangles = (0..bars.len() as u32).flat_map(quad).collect();
        };
        let thin = 1e-4 * texel;
        placed(&mut scene, &[bar(0.3 * texel, 0.3 * texel + thin)]);
        assert!(
            near(&scene, 2.3, 0.0) && near(&scene, -1.7, 0.0) && !near(&scene, 2.4, 0.0) && !near(&scene, -1.8, 0.0)
        );
        placed(&mut scene, &[bar(-1.0, 0.3 * texel), bar(0.3 * texel + thin, 1.0)]);
        assert!(
            near(&scene, 2.3, 0.0) && near(&scene, -1.7, 0.0) && !near(&scene, 2.4, 0.0) && !near(&scene, -1.8, 0.0)
        );
        let edges: Vec<f64> = (0..=40).map(|i| (f64::from(i) * 0.7).sin() * 0.02 + f64::from(i) / 20.0 - 1.0).collect();
        placed(&mut scene, &edges.windows(2).map(|e| bar(e[0], e[1])).collect::<Vec<_>>());
        for i in 0..400 {
            let at = |k: f64| 0.85 / texel * (f64::from(i) * k).sin();
            assert!(!near(&scene, at(1.3), at(2.9)), "{} {}", at(1.3), at(2.9));
        }
    }

    /// Under a lamp the boundary is the same as under the sun: two texels to either side of the shadow's edge, at any depth.
    #[test]
    fn rays_that_spread() {
        let mut scene = plate();
        let position = DVec3::new(0.0, 0.0, 2.0);
        scene.lights[0].kind = crate::scene::LightKind::Point { position };
        let casters = Casters::new(&scene);
        let views = View::opaques(&scene, 64);
        let down = views.into_iter().find(|v| v.forward[2] < -0.9).expect("a face looks down");
        let resolution = Resolution { reach_texels: 2.0, depth: 1e-5, ..Resolution::exact(down) };
        // Measured in texels, the shadow's edge is at the same place at any depth.
        let at = |texel: DVec2, z: f64| down.ray(texel).at(z);
        let (rim, _) = down.project(DVec3::new(1.0, 0.1, 0.0));
        for z in [2.5, 4.0] {
            for (share, is_near) in [(-2.1, false), (-1.9, true), (1.9, true), (2.1, false)] {
                let texel = DVec2::new(rim.x + share, rim.y);
                assert_eq!(casters.in_boundary(0, &resolution, at(texel, z)), is_near, "{share} texels, z {z}");
            }
            assert!(!casters.in_boundary(0, &resolution, at(rim, 1.0)), "above the plate");
        }
    }

    /// Under a virtual light the map is a paraboloid. A point behind the plate is in the boundary if and only if the plate's rim, in the
    /// map, is closer to it than the reach. Positions in the map follow the formula of glsl/technique/ism/visibility.glsl.
    #[test]
    fn in_texels_of_a_paraboloid() {
        let mut scene = plate();
        let (light, size) = (DVec3::new(0.3, -0.2, 1.5), 64.0);
        for normal in [DVec3::NEG_Z, DVec3::new(0.6, 0.2, -0.8), DVec3::new(-1.0, 0.4, -0.3)].map(DVec3::normalize) {
            scene.lights[0].kind = LightKind::Virtual { position: light, normal, nearest: 0.1 };
            let casters = Casters::new(&scene);
            let view = View::paraboloid(light, normal, 64);
            let resolution = Resolution::of_paraboloid(view);
            let axes = [view.right, view.up, view.forward].map(|axis| DVec3::from(axis.map(f64::from)));
            let texel = |p: DVec3| {
                let [x, y, z] = axes.map(|axis| axis.dot(p - light));
                DVec2::new(x, y) * (0.5 * size / ((p - light).length() + z))
            };
            let side = |i: i32| (i % 2000) as f64 / 1000.0 - 1.0;
            let rim: Vec<DVec2> = (0..8000)
                .map(|i| match i / 2000 {
                    0 => DVec3::new(side(i), -1.0, 0.0),
                    1 => DVec3::new(side(i), 1.0, 0.0),
                    2 => DVec3::new(-1.0, side(i), 0.0),
                    _ => DVec3::new(1.0, side(i), 0.0),
                })
                .filter(|p| (*p - light).dot(normal) > -0.5)
                .map(texel)
                .collect();
            let (mut counted, mut on_surfaces) = ([0; 2], 0);
            for i in 0..4000 {
                let at = |k: f64| (f64::from(i) * k).sin();
                let point = DVec3::new(3.0 * at(1.3), 3.0 * at(2.9), -1.0 + 0.5 * at(0.7));
                if (point - light).dot(normal) < 0.05 {
                    continue;
                }
                let away = |p: DVec3| rim.iter().map(|r| (*r - texel(p)).abs().max_element()).fold(f64::MAX, f64::min);
                let check = |is_near: bool, at: DVec3| {
                    // The paraboloid bends straight edges a little.
                    let away = away(at);
                    assert!(
                        (away - 1.5).abs() < 0.1 || is_near == (away < 1.5),
                        "{point}, normal {normal}: {away} texels"
                    );
                    is_near
                };
                counted[usize::from(check(casters.in_boundary(0, &resolution, point), point))] += 1;
                // On an upward-facing surface the boundary is a little wider, since the point sees texels at a slant.
                let (away, steep) = (away(point), (point - light).normalize().z < -0.5);
                if steep && !(0.4..=2.0).contains(&away) {
                    let near = casters.in_surface_boundary(0, &resolution, point, DVec3::Z);
                    assert_eq!(near, away < 0.4, "{point} on a surface, normal {normal}: {away} texels");
                    on_surfaces += 1;
                }
            }
            assert!(counted[0] > 500 && counted[1] > 100 && on_surfaces > 100, "{counted:?}, {on_surfaces}");
        }
    }

    /// Returns what a texel centred at `texel` reports for a position on a surface: lit if nothing lies in front of the position and above
    /// its plane.
    fn texel_is_lit(scene: &Scene, view: &View, texel: DVec2, place: DVec3, normal: DVec3) -> bool {
        let corners = |mesh: &Mesh| {
            let corner = |i: u32| DVec3::from(mesh.positions[i as usize].map(f64::from));
            mesh.triangles.iter().map(|t| t.map(corner)).collect::<Vec<_>>()
        };
        let (ray, z) = (view.ray(texel), view.project(place).1);
        scene.meshes.iter().flat_map(corners).all(|[a, b, c]| {
            let across = (b - a).cross(c - a);
            let p = ray.at((a - ray.origin).dot(across) / ray.direction.dot(across));
            let is_inside = [(a, b), (b, c), (c, a)].iter().all(|(a, b)| (b - a).cross(p - a).dot(across) >= 0.0);
            // A view's axes are f32.
            !is_inside || view.project(p).1 >= z - 1e-6 || normal.dot(p - place) <= 1e-6
        })
    }

    /// For points outside the boundary, no texel centred within reach is wrong. For some points inside, one is, so the boundary is needed.
    /// The scene has a box over a ground and two plates close together, lit at a slant by the sun or a lamp.
    #[test]
    fn outside_no_texel_is_wrong() {
        let square = |z: f32, half: f32| {
            let corners = [[-half, -half, z], [half, -half, z], [half, half, z], [-half, half, z]];
            crate::scene::tests::mesh(corners.into(), vec![[0, 1, 2], [0, 2, 3]])
        };
        let block = crate::scene::tests::cube([-0.5, -0.3, 0.25], 0.4);
        let mut scene = plate();
        scene.meshes = vec![square(0.0, 1.0), block, square(0.9, 0.3), square(0.902, 0.3)];
        let direction = DVec3::new(0.55, -0.35, -0.6).normalize();
        let lamp = LightKind::Spot { position: -2.5 * direction, direction, cone_degrees: 60.0 };
        for kind in [LightKind::Directional { direction }, lamp] {
            scene.lights[0].kind = kind;
            let casters = Casters::new(&scene);
            let view = View::opaques(&scene, 32)[0];
            let resolution = Resolution { view, ..of_depths(&scene, 0.5625, 1e-5) };
            let (mut outside, mut missed) = (0, [0; 2]);
            for point in super::super::surface_points(&casters, &scene, 0, &view, 600) {
                let normal = point.facing(scene.lights[0].towards(point.position));
                if normal.dot(scene.lights[0].towards(point.position)) <= 0.0 {
                    continue;
                }
                let place = resolution.looked_up(point.position, normal);
                let texel = view.project(place).0;
                let lit = casters.unblocked(0, point.position);
                let is_near = casters.in_surface_boundary(0, &resolution, point.position, normal);
                outside += usize::from(!is_near);
                for i in 0..24u32 * 24 {
                    let offset = DVec2::new((i % 24).into(), (i / 24).into()) / 23.0 - 0.5;
                    if texel_is_lit(&scene, &view, texel + offset, place, normal) != lit {
                        missed[usize::from(lit)] += 1;
                        assert!(is_near, "{point:?}, {lit}, texel {offset} off");
                    }
                }
            }
            assert!(outside > 200 && missed[0] > 20 && missed[1] > 20, "{outside} outside, {missed:?} missed");
        }
    }
}
