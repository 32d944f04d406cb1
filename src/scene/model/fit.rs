//! Views of lights, fitted to the casters they see. The device does the same in f32 (glsl/maps/bounds.comp, fit.comp).

use crate::scene::model::view::{across, caster_spheres, lasting_spheres, mesh_points, some_up, vec};
use crate::scene::{FACES, Light, LightKind, Projection, Scene, View};
use glam::DVec3;

/// The casters to which a view is fitted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Casting {
    /// The translucent casters.
    Volume,
    /// The meshes alone, so that the view does not change while smoke moves. Points in front of the meshes or beside them are lit. Behind
    /// all meshes, a point is either lit or in the shadow of the nearest mesh on its ray.
    Opaque,
}

impl Casting {
    /// Returns the range of a view, relative to the range that the casters need. The opaque map has 10 % more, so that its bias does not
    /// push the farthest surface out of range.
    fn range(self) -> f32 {
        if self == Self::Opaque { 1.1 } else { 1.0 }
    }
}

/// Widens a range by 1 % of a texel of the largest map. Twin: MARGIN in glsl/maps/fit.comp.
const MARGIN: f64 = 1.00001;

/// Error bound of rounding to f32, as a fraction of the distance from the origin. Twin: ROUNDING.
const ROUNDING: f64 = 5e-7;

/// The smallest range of a parallel view, as a fraction of its width. Twin: THINNEST.
const THINNEST: f64 = 1e-3;

/// Returns how many texels a point light's face of `size` texels extends past its 90° on each side: 9, of which 8 are for the widest filter
/// and one is for rounding. Small maps have fewer, which only narrower filters fit into.
pub fn gutter_texels(size: u32) -> u32 {
    (size / 8).clamp(1, 9)
}

/// Returns the tangent of half the angle that a point light's face covers: at most 2, even if the gutter would take up more of a very small
/// map.
fn face_tangent(size: u32) -> f64 {
    let share = (f64::from(gutter_texels(size)) / f64::from(size)).min(0.25);
    1.0 / (1.0 - 2.0 * share)
}

/// The data needed to aim views before they are fitted.
#[derive(Clone, Copy, Debug)]
pub struct Aim<'a> {
    /// All lights.
    pub lights: &'a [Light],
    /// Origins of a directional light's views before fitting: the volume view's and the opaque view's.
    pub anchors: [DVec3; 2],
    /// Whether the scene contains opaque geometry.
    pub has_triangles: bool,
}

impl Scene {
    /// Returns the data needed to aim the scene's views. The volume views of directional lights start at the position of the first caster,
    /// and their opaque views at the first mesh vertex, if there are meshes. "First" means lowest x, then lowest y, then lowest z, so that
    /// the result does not depend on the order of the casters.
    pub fn aim(&self) -> Aim<'_> {
        let anchors = [anchor(self, Casting::Volume), anchor(self, Casting::Opaque)];
        Aim { lights: &self.lights, anchors, has_triangles: self.has_triangles() }
    }
}

fn anchor(scene: &Scene, casting: Casting) -> DVec3 {
    let first = |a: &DVec3, b: &DVec3| {
        let order = |axis: fn(&DVec3) -> f64| axis(a).total_cmp(&axis(b));
        order(|p| p.x).then_with(|| order(|p| p.y)).then_with(|| order(|p| p.z))
    };
    let casters = || lasting_spheres(scene).map(|(p, _)| p).min_by(first);
    let meshes = || mesh_points(&scene.meshes).map(|(p, _)| p).min_by(first);
    let place = match casting {
        Casting::Volume => casters().or_else(meshes),
        Casting::Opaque => meshes().or_else(casters),
    };
    place.unwrap_or(DVec3::ZERO)
}

/// See [`View::aimed`].
pub(in crate::scene) fn aimed(aim: &Aim, size: u32, casting: Casting) -> Vec<View> {
    let anchor = match casting {
        Casting::Volume => aim.anchors[0],
        Casting::Opaque => aim.anchors[1],
    };
    let view = |origin: DVec3, forward: DVec3, projection: Projection, tangent: f64, nearest: f32| {
        let (right, up) = across(forward, some_up(forward));
        let scale = (1.0 / tangent) as f32;
        View {
            origin: origin.as_vec3().into(),
            projection: projection as u32,
            right: right.as_vec3().into(),
            scale_x: scale,
            up: up.as_vec3().into(),
            scale_y: scale,
            forward: forward.as_vec3().into(),
            near: nearest,
            far: casting.range(),
            width: size,
            height: size,
        }
    };
    let maps = |light: &Light| match light.kind {
        LightKind::Directional { direction } => vec![view(anchor, direction, Projection::Parallel, 1.0, 0.0)],
        LightKind::Spot { position, direction, cone_degrees } => {
            let tangent = (cone_degrees.to_radians() * 0.5).tan();
            // Casters around the light itself are clipped nearer than a thousandth of the range.
            vec![view(position, direction, Projection::Perspective, tangent, 1e-3)]
        }
        LightKind::Point { position } | LightKind::Virtual { position, .. } => {
            // Particle code never divides by z, so particles around the light count in full.
            let nearest = if casting == Casting::Opaque { 1e-3 } else { 0.0 };
            let face = |(_, forward)| view(position, forward, Projection::Perspective, face_tangent(size), nearest);
            FACES.map(face).to_vec()
        }
    };
    aim.lights.iter().flat_map(maps).collect()
}

/// Returns the fitted views of all maps of all lights, computed in f64 and rounded once.
pub(in crate::scene) fn fit_all(scene: &Scene, size: u32, casting: Casting) -> Vec<View> {
    let with_meshes = casting == Casting::Opaque || scene.has_only_meshes();
    let meshes: Vec<_> = if with_meshes { mesh_points(&scene.meshes).collect() } else { Vec::new() };
    let casters: Vec<_> = match casting {
        Casting::Volume => {
            let Scene { particles, strands, splats, volumes, meshes, .. } = scene;
            caster_spheres(particles, strands, splats, volumes, meshes).collect()
        }
        Casting::Opaque => Vec::new(),
    };
    // A strand may cross a view that contains neither of its ends, so strands cannot be culled by their ends.
    let see_all = !scene.strands.is_empty();
    let fitted = |view: View| {
        let seen = casters.iter().filter(|sphere| see_all || sees(&view, sphere));
        fit(view, seen.chain(&meshes).copied())
    };
    aimed(&scene.aim(), size, casting).into_iter().map(fitted).collect()
}

/// Returns whether the view may see a sphere. A perspective view does not if the sphere is outside one of the frustum's four side planes,
/// or behind the view.
fn sees(view: &View, &(centre, radius): &(DVec3, f64)) -> bool {
    if view.projection() == Projection::Parallel {
        return true;
    }
    let [x, y, z] = view.axes(centre).to_array();
    let tangent = 1.0 / f64::from(view.scale_x);
    let outside = (x.abs().max(y.abs()) - tangent * z) / (1.0 + tangent * tangent).sqrt();
    outside < radius && z + radius > 0.0
}

/// Fits a view to the spheres: a parallel view in all three directions, a perspective view in depth.
fn fit(mut view: View, spheres: impl Iterator<Item = (DVec3, f64)>) -> View {
    let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for (centre, radius) in spheres {
        let centre = view.axes(centre);
        low = low.min(centre - radius);
        high = high.max(centre + radius);
    }
    let range = f64::from(view.far);
    if view.projection() == Projection::Perspective {
        let farthest = high.z.max(1e-3);
        let near = (low.z - ROUNDING * farthest).clamp(farthest * f64::from(view.near), farthest * 0.999);
        let far = near + ((farthest - near) * MARGIN + ROUNDING * farthest) * range;
        (view.near, view.far) = (near as f32, far as f32);
        return view;
    }
    if low.x > high.x {
        (low, high) = (DVec3::ZERO, DVec3::ONE);
    }
    let origin = vec(view.origin);
    let middle = (low + high) * 0.5;
    let rounding = ROUNDING * origin.abs().max_element();
    let mut half = ((high - low) * 0.5 * MARGIN + rounding).max(DVec3::splat(1e-6));
    half.z = half.z.max(THINNEST * half.x.max(half.y));
    let across = vec(view.right) * middle.x + vec(view.up) * middle.y;
    view.origin = (origin + across + vec(view.forward) * (middle.z - half.z)).as_vec3().into();
    (view.scale_x, view.scale_y) = ((1.0 / half.x) as f32, (1.0 / half.y) as f32);
    (view.near, view.far) = (0.0, (2.0 * half.z * range) as f32);
    view
}
