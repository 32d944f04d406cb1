//! The truth of a scene at one time, shared by all rows. Each part is computed once, when first needed: during the measurement, or on a
//! separate thread if that does not disturb the timings.

use crate::bench::error::seen::SeenTruth;
use crate::reference::truth::{
    Casters, MapTruth, SurfacePoint, limit_mean_abs, limit_steps, picture, picture_tries, points_outside, sample_maps,
    surface_points,
};
use crate::scene::{Picture, Resolution, Scene, View};
use glam::DVec3;
use rayon::prelude::*;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

/// How much of the truth is wanted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Extent {
    /// No truth: only times.
    None,
    /// Seen points only, for a first look: no picture.
    Glance,
    /// Enough for a choice: seen points and a picture.
    Choice,
    /// All kinds of points; in maps, a fixed sample of covered texels.
    Sample,
    /// All kinds of points; in maps, all covered texels.
    Full,
}

impl Extent {
    /// Returns the name of this extent in a run's conditions.
    pub fn word(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Glance => "glance",
            Self::Choice => "choice",
            Self::Sample => "sample",
            Self::Full => "full",
        }
    }

    /// Whether errors in maps, in space and on surfaces are included; they explain the error of the picture.
    pub(in crate::bench) fn has_reasons(self) -> bool {
        matches!(self, Self::Sample | Self::Full)
    }
}

/// Number of covered texels in a sample, over all maps.
const SAMPLED_TEXELS: usize = 4096;

/// Maximum number of ray–caster tests for a picture, as [`picture_tries`] counts them: a few seconds on one core. If more
/// are needed, the picture is made smaller.
const PICTURE_TRIES: f64 = 1e9;

/// Width of the smallest picture that is still useful, in pixels.
const LEAST_WIDTH: u32 = 80;

/// Maximum number of steps for computing [`MapsTruth::limits`], as [`limit_steps`] counts them.
const LIMIT_STEPS: f64 = 2e9;

/// Node counts for which the error of the best curve is computed.
pub(in crate::bench) const LIMIT_NODES: [usize; 3] = [4, 8, 16];

/// The parts of the truth that are wanted at one time.
#[derive(Clone, Debug)]
pub(crate) struct Wanted {
    pub extent: Extent,
    /// Number of space points and of surface points, per light.
    pub points: usize,
    /// Number of seen points, and a seed that selects them: each frame has different ones.
    pub seen: (usize, u64),
    pub picture: [u32; 2],
    /// Corners of the box that contains the space points.
    pub bounds: Option<[DVec3; 2]>,
    /// Per light, the points at which a moving world is watched.
    pub watched: Arc<Vec<Vec<[f32; 3]>>>,
}

/// Points of one light, with the truth there.
pub(crate) struct Points {
    pub light: usize,
    pub positions: Vec<[f32; 3]>,
    pub visibility: Vec<f64>,
    /// True visibility in red, green and blue light; empty if casters absorb all colors alike.
    pub colors: Vec<[f64; 3]>,
    /// The points as surface points, if they lie on meshes.
    surface: Vec<SurfacePoint>,
    /// Unit normal per point, on the side where light is looked up; empty for points in space.
    pub normals: Vec<[f32; 3]>,
    /// Two distances per point along the ray to the light, as [`Casters::caster_distances`] returns them: from the light to its nearest
    /// mesh, and from the point to its nearest mesh. Empty unless the points lie on meshes.
    pub casters: Vec<[f64; 2]>,
    /// Whether each point is nearer to an opaque shadow's edge than the resolution, for each set of resolutions queried so far.
    boundaries: Cached<Vec<Resolution>, Vec<bool>>,
}

impl Points {
    /// Creates points in space.
    pub fn in_space(light: usize, positions: Vec<[f32; 3]>, visibility: Vec<f64>) -> Self {
        let (colors, surface, normals, casters) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        Self { light, positions, visibility, colors, surface, normals, casters, boundaries: Cached::new() }
    }
}

/// The truth in the maps of one set of views, and the errors of the best curves over all of these maps.
pub(crate) struct MapsTruth {
    /// Points of each map in which casters cover at least one texel.
    pub maps: Vec<Points>,
    pub covered: u64,
    pub segments: u64,
    /// Share of all texels that was sampled.
    pub share: f64,
    /// Errors of the best curve with each of [`LIMIT_NODES`]. `None` if they would take longer than everything else, if the scene has
    /// splats or volumes, whose curves have no vertices to choose nodes from, or if no texel is covered.
    pub limits: Option<Vec<f64>>,
}

/// A picture lit by the truth.
pub(crate) struct LitPicture {
    pub camera: View,
    pub picture: Picture,
}

/// A small cache that computes the value of each key once.
pub(crate) struct Cached<K, V>(Mutex<Vec<(K, Arc<V>)>>);

impl<K: PartialEq, V> Cached<K, V> {
    pub fn new() -> Self {
        Self(Mutex::new(Vec::new()))
    }

    pub fn get(&self, key: K, make: impl FnOnce(&K) -> V) -> Arc<V> {
        let mut all = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((_, value)) = all.iter().find(|(k, _)| *k == key) {
            return value.clone();
        }
        let value = Arc::new(make(&key));
        all.push((key, value.clone()));
        value
    }
}

/// The parts of the truth computed so far, at one time. They outlive the scene, which may be in memory only temporarily.
pub(crate) struct Known {
    wanted: Wanted,
    space: OnceLock<Vec<Points>>,
    watched: OnceLock<Vec<Points>>,
    surface: OnceLock<Vec<Points>>,
    seen: OnceLock<SeenTruth>,
    picture: OnceLock<Option<LitPicture>>,
    maps: Cached<Vec<View>, MapsTruth>,
}

/// See the module documentation.
pub(crate) struct Truth<'a> {
    scene: &'a Scene,
    casters: OnceLock<Casters<'a>>,
    known: Arc<Known>,
}

impl Known {
    /// Creates an empty record, before anything is computed.
    pub fn new(wanted: Wanted) -> Self {
        Self {
            wanted,
            space: OnceLock::new(),
            watched: OnceLock::new(),
            surface: OnceLock::new(),
            seen: OnceLock::new(),
            picture: OnceLock::new(),
            maps: Cached::new(),
        }
    }

    /// Whether errors in maps, in space and on surfaces are wanted.
    pub fn has_reasons(&self) -> bool {
        self.wanted.extent.has_reasons()
    }

    /// Whether a picture is wanted.
    pub fn has_picture(&self) -> bool {
        self.wanted.extent != Extent::Glance
    }

    /// Whether [`Truth::picture`] has been called.
    pub fn has_tried_picture(&self) -> bool {
        self.picture.get().is_some()
    }

    /// Returns the picture, if it has been rendered.
    pub fn picture(&self) -> Option<&LitPicture> {
        self.picture.get()?.as_ref()
    }
}

impl<'a> Truth<'a> {
    pub fn new(scene: &'a Scene, wanted: Wanted) -> Self {
        Self::of(scene, Arc::new(Known::new(wanted)))
    }

    /// Creates the truth of a scene, parts of which may already be known.
    pub fn of(scene: &'a Scene, known: Arc<Known>) -> Self {
        Self { scene, casters: OnceLock::new(), known }
    }

    pub fn scene(&self) -> &'a Scene {
        self.scene
    }

    pub fn known(&self) -> &Known {
        &self.known
    }

    pub fn casters(&self) -> &Casters<'a> {
        self.casters.get_or_init(|| Casters::new(self.scene))
    }

    fn camera(&self, size: [u32; 2]) -> View {
        View::camera(&self.scene.camera, self.scene, size)
    }

    /// Returns the points in space, per light.
    pub fn space(&self) -> &[Points] {
        self.known.space.get_or_init(|| {
            let of = |light| {
                let within = |bounds| points_outside(self.casters(), bounds, light, self.known.wanted.points);
                self.at(light, self.known.wanted.bounds.map_or_else(Vec::new, within))
            };
            (0..self.scene.lights.len()).map(of).collect()
        })
    }

    /// Returns the points at which a moving world is watched, per light: the same positions in every frame.
    pub fn watched(&self) -> &[Points] {
        let of = |(light, positions): (usize, &Vec<[f32; 3]>)| self.at(light, positions.clone());
        self.known.watched.get_or_init(|| self.known.wanted.watched.iter().enumerate().map(of).collect())
    }

    /// Returns the visibility of each color at these points; empty if casters absorb all colors alike.
    fn colors<P: Sync>(&self, light: usize, points: &[P], at: impl Fn(&P) -> DVec3 + Sync) -> Vec<[f64; 3]> {
        let casters = self.casters();
        let wanted = if self.scene.extinction_ratio == Scene::GREY { &[] } else { points };
        wanted.par_iter().map(|p| casters.colors(light, at(p)).to_array()).collect()
    }

    fn at(&self, light: usize, positions: Vec<[f32; 3]>) -> Points {
        // Builds the casters before the parallel loop. The build runs on the same threads as the loop, and a thread that took a point from
        // the loop during the build would wait for itself.
        let casters = self.casters();
        let visibility = |p: &[f32; 3]| casters.visibility(light, DVec3::from(p.map(f64::from)));
        let visibility = positions.par_iter().map(visibility).collect();
        let colors = self.colors(light, &positions, |p| DVec3::from(p.map(f64::from)));
        Points { colors, ..Points::in_space(light, positions, visibility) }
    }

    /// Returns the points on surfaces, per light; empty without meshes.
    pub fn surface(&self) -> &[Points] {
        self.known.surface.get_or_init(|| {
            let camera = self.camera(self.known.wanted.picture);
            let of = |light: usize| {
                let casters = self.casters();
                let surface = surface_points(casters, self.scene, light, &camera, self.known.wanted.points);
                let positions = surface.iter().map(|p| p.position.as_vec3().into()).collect();
                let visibility = |p: &SurfacePoint| casters.visibility(light, p.position);
                let visibility = surface.par_iter().map(visibility).collect();
                let colors = self.colors(light, &surface, |p: &SurfacePoint| p.position);
                let normals = surface.iter().map(|p| p.asked(&self.scene.lights[light])).collect();
                let distances = surface.par_iter().map(|p| casters.caster_distances(light, p.position)).collect();
                let boundaries = Cached::new();
                Points { light, positions, visibility, colors, surface, normals, casters: distances, boundaries }
            };
            if self.scene.has_triangles() { (0..self.scene.lights.len()).map(of).collect() } else { Vec::new() }
        })
    }

    /// Returns the points that the camera sees, with the truth there.
    pub fn seen(&self) -> &SeenTruth {
        self.known.seen.get_or_init(|| {
            let (count, seed) = self.known.wanted.seen;
            SeenTruth::new(self.casters(), self.scene, &self.camera(self.known.wanted.picture), count, seed)
        })
    }

    /// Returns the picture. If the full truth is wanted, it has the requested size. Otherwise its size is halved as often as needed to keep
    /// it fast; `None` if even the smallest size would take too long.
    pub fn picture(&self) -> Option<&LitPicture> {
        let made = self.known.picture.get_or_init(|| {
            let mut size = self.known.wanted.picture;
            let mut tries = picture_tries(self.casters(), self.scene, &self.camera(size));
            let most = if self.known.wanted.extent == Extent::Full { f64::INFINITY } else { PICTURE_TRIES };
            while tries > most && size[0] / 2 >= LEAST_WIDTH {
                (size, tries) = (size.map(|side| side / 2), tries / 4.0);
            }
            let camera = self.camera(size);
            (tries <= 4.0 * most).then(|| LitPicture { picture: picture(self.casters(), self.scene, &camera), camera })
        });
        made.as_ref()
    }

    /// Returns the truth in maps with these views, which many variants share.
    pub fn maps(&self, views: Vec<View>) -> Arc<MapsTruth> {
        self.known.maps.get(views, |views| {
            let most = if self.known.wanted.extent == Extent::Full { usize::MAX } else { SAMPLED_TEXELS };
            let (truths, share) = sample_maps(self.casters(), self.scene, views, most);
            let count = |of: fn(&MapTruth) -> u64| truths.iter().map(of).sum::<u64>();
            let (covered, segments) = (count(|t| t.texels.len() as u64), count(|t| t.segments));
            let steps = LIMIT_STEPS / crate::reference::truth::LIMIT_TEXELS as f64;
            // Splats and volumes give curves without vertices, so there are no nodes to choose from.
            let bends = self.scene.splats.is_empty() && self.scene.volumes.is_empty();
            let affordable = bends && covered > 0 && limit_steps(segments / covered) <= steps;
            let limits = affordable.then(|| limit_mean_abs(self.casters(), views, &truths, &LIMIT_NODES));
            let points = |t: MapTruth| Points::in_space(t.light, t.points, t.visibility);
            let maps = truths.into_iter().filter(|t| !t.texels.is_empty()).map(points).collect();
            MapsTruth { maps, covered, segments, share, limits }
        })
    }

    /// Returns which of `points` are nearer to an opaque shadow's edge than the technique resolves. `resolution` has one entry per map of
    /// all lights, or none if the technique is exact, in which case no point is that near. The result is empty if the scene has no meshes.
    pub fn boundary(&self, points: &Points, resolution: &[Resolution]) -> Arc<Vec<bool>> {
        if !self.scene.has_triangles() {
            return Arc::default();
        }
        if resolution.is_empty() {
            return Arc::new(vec![false; points.positions.len()]);
        }
        let light = &self.scene.lights[points.light];
        let first = self.scene.first_map(points.light);
        points.boundaries.get(resolution[first..first + light.map_count()].to_vec(), |resolution| {
            let of = |p: &[f32; 3]| &resolution[light.map_at(*p)];
            let casters = self.casters();
            if points.surface.is_empty() {
                let at = |p: &[f32; 3]| casters.in_boundary(points.light, of(p), DVec3::from(p.map(f64::from)));
                return points.positions.par_iter().map(at).collect();
            }
            let at = |(p, s): (&[f32; 3], &SurfacePoint)| {
                let normal = s.facing(light.towards(s.position));
                !s.looks_away(light) && casters.in_surface_boundary(points.light, of(p), s.position, normal)
            };
            points.positions.par_iter().zip(&points.surface).map(at).collect()
        })
    }
}
