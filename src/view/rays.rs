//! The curve under the pointer: the truth along light 0's ray through the visible surface or smoke, and the transmittance that A and B
//! give. The plot equals that of `gobo curve`. A thread with its own device computes it, so that the window never waits. The thread also
//! computes the seen error of A and B.

use super::state::{Side, State};
use crate::bench::{BuiltTechniques, LightRay, SeenError, SeenTruth};
use crate::gpu::{Context, Options};
use crate::reference::truth::Casters;
use crate::report;
use crate::scene::{Camera, FACES, Scene, View};
use crate::technique::{Name, Opened, Spec};
use crate::{Error, Result};
use glam::{DVec2, DVec3};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;

/// Data shared by several rays: a state of a scene, and the techniques built for it.
#[derive(Clone, Debug, PartialEq)]
struct RayKey {
    version: u64,
    specs: Vec<String>,
}

/// A ray: the pixel where it is seen, and the data that it shares with others.
#[derive(Clone, Debug, PartialEq)]
struct Key {
    of: RayKey,
    camera: View,
    pixel: [u32; 2],
}

struct RayRequest {
    key: Key,
    /// Scene. Its own camera is not used; `camera` is used instead.
    scene: Arc<Scene>,
    camera: Camera,
    specs: Vec<Spec>,
}

/// The ray under a pixel, and its curves.
#[derive(Clone, Debug)]
pub struct PickedRay {
    /// Texel of the ray in the light's map.
    pub texel: [u32; 2],
    /// Face of a point light's cube that contains the ray.
    pub face: Option<&'static str>,
    /// Depth of the visible point, in the light's range.
    pub depth: f64,
    pub ray: LightRay,
    /// Whether the scene has light 0 once per color, since its casters absorb colors differently: the ray is then of red light.
    pub is_red: bool,
    /// Name of each of the ray's lines: a technique or the reference.
    pub names: Vec<String>,
    scene: String,
}

impl PickedRay {
    /// Returns the SVG of `gobo curve`.
    ///
    /// # Errors
    /// See [`report::curve`].
    pub fn svg(&self) -> Result<String> {
        report::curve(&self.ray.title(&self.scene, self.texel), &self.ray, &self.names)
    }

    /// Returns the truth at the visible point, and the transmittance that each technique gives there.
    pub fn there(&self) -> (f64, Vec<f64>) {
        let at = self.ray.truth.partition_point(|(depth, _)| *depth < self.depth).min(self.ray.truth.len() - 1);
        (self.ray.truth[at].1, self.ray.lines.iter().map(|line| line.points[at].1).collect())
    }
}

/// Number of seen points per state.
const SEEN: usize = 2048;

/// Seen error of each technique, by name, for a state and a camera. Techniques without a result, or whose result is not a number, are left
/// out.
pub type Seen = Vec<(String, SeenError)>;

/// Messages between the window and the thread.
#[derive(Default)]
struct Post {
    asked: Option<RayRequest>,
    answer: Option<(Key, std::result::Result<Arc<PickedRay>, String>)>,
    seen: Option<((RayKey, View), Arc<Seen>)>,
    /// Whether the thread is working on a ray.
    is_busy: bool,
    is_over: bool,
}

#[derive(Default)]
struct Shared {
    post: Mutex<Post>,
    wakes: Condvar,
}

/// The last request, and its result.
pub struct Rays {
    shared: Arc<Shared>,
    thread: Option<JoinHandle<()>>,
    options: Options,
    asked: Option<Key>,
    /// Whether the last request was handed to the thread.
    is_posted: bool,
}

impl Drop for Rays {
    fn drop(&mut self) {
        self.shared.lock().is_over = true;
        self.shared.wakes.notify_all();
        // Waits for the thread, so that its device is closed before the program ends.
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

/// Returns the specs whose lines share one plot: those of A and B, if their maps have the same size.
pub fn specs(state: &State) -> Vec<&Spec> {
    let all = state.sides.iter().filter_map(|side| if let Side::Technique(spec) = side { Some(spec) } else { None });
    let mut all: Vec<&Spec> = all.collect();
    all.dedup_by_key(|spec| spec.to_string());
    let size = all.first().map(|spec| spec.text(Name::SIZE).to_owned());
    all.retain(|spec| Some(spec.text(Name::SIZE)) == size.as_deref());
    all
}

impl Rays {
    /// Creates an instance without requests. `options` are for the thread's device.
    pub fn new(options: Options) -> Self {
        Self { shared: Arc::default(), thread: None, options, asked: None, is_posted: false }
    }

    /// Requests the ray under the pointer from the thread, if it differs from the last one requested. `version` identifies the state of the
    /// scene that `scene` returns. `scene` is called only once the thread has nothing else to do, so call this function again in each
    /// frame.
    pub fn ask(
        &mut self,
        state: &State,
        (version, camera): (u64, View),
        scene: impl FnOnce() -> Option<(Camera, Arc<Scene>)>,
    ) {
        let specs = specs(state);
        let of = RayKey { version, specs: specs.iter().map(ToString::to_string).collect() };
        let size = [camera.width, camera.height];
        let pixel = state.pointer.unwrap_or(size.map(|side| side / 2));
        let pixel = [0, 1].map(|i| pixel[i].min(size[i] - 1));
        let key = Key { of, camera, pixel };
        if self.asked.as_ref() != Some(&key) {
            (self.asked, self.is_posted) = (Some(key.clone()), false);
        }
        if self.is_posted || self.shared.lock().is_busy {
            return;
        }
        let Some((own, scene)) = scene() else { return };
        let asked = RayRequest { key, scene, camera: own, specs: specs.into_iter().cloned().collect() };
        let mut post = self.shared.lock();
        (post.asked, post.is_busy, self.is_posted) = (Some(asked), true, true);
        drop(post);
        self.shared.wakes.notify_all();
        if self.thread.is_none() {
            let (shared, options) = (self.shared.clone(), self.options.clone());
            self.thread = std::thread::Builder::new().name("rays".into()).spawn(move || shared.serve(&options)).ok();
        }
    }

    /// Drops the last request.
    pub fn rest(&mut self) {
        (self.asked, self.is_posted) = (None, false);
        let mut post = self.shared.lock();
        if post.asked.take().is_some() {
            post.is_busy = false;
        }
        (post.answer, post.seen) = (None, None);
    }

    /// Whether the result of the last request, or the seen error, is still to come.
    pub fn is_waiting(&self) -> bool {
        let is_seen = |key: &Key| {
            self.shared.lock().seen.as_ref().is_some_and(|((of, camera), _)| (of, camera) == (&key.of, &key.camera))
        };
        let is_failed = matches!(self.answer(), Some(Err(_)));
        self.asked.as_ref().is_some_and(|key| self.answer().is_none() || !is_failed && !is_seen(key))
    }

    /// Returns the latest seen errors, while the next are being computed.
    pub fn seen(&self) -> Arc<Seen> {
        self.shared.lock().seen.as_ref().map(|(_, seen)| seen.clone()).unwrap_or_default()
    }

    /// Returns the result of the last request, or why there is none.
    pub fn answer(&self) -> Option<std::result::Result<Arc<PickedRay>, String>> {
        let post = self.shared.lock();
        post.answer.as_ref().filter(|(key, _)| Some(key) == self.asked.as_ref()).map(|(_, answer)| answer.clone())
    }

    /// Returns the latest result, while the next is being computed.
    pub fn last(&self) -> Option<std::result::Result<Arc<PickedRay>, String>> {
        self.shared.lock().answer.as_ref().map(|(_, answer)| answer.clone())
    }
}

impl Shared {
    fn lock(&self) -> MutexGuard<'_, Post> {
        self.post.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Waits for the next request. Returns `None` if the window closes, or if the next request concerns a state other than `within`.
    fn next(&self, within: Option<&RayKey>) -> Option<RayRequest> {
        let mut post = self.lock();
        loop {
            if post.is_over {
                return None;
            }
            match &post.asked {
                Some(asked) if within.is_some_and(|of| *of != asked.key.of) => return None,
                Some(_) => return post.asked.take(),
                None => {
                    post.is_busy = false;
                    post = self.wakes.wait(post).unwrap_or_else(PoisonError::into_inner);
                }
            }
        }
    }

    /// Serves requests until the window closes.
    fn serve(&self, options: &Options) {
        let mut context = None;
        while let Some(first) = self.next(None) {
            if context.is_none() {
                context = Context::new(options).map_err(|error| self.tell(&first.key, Err(error))).ok();
            }
            if let Some(context) = &context {
                self.serve_state(context, first);
            }
        }
    }

    /// Serves all requests for one state.
    fn serve_state(&self, context: &Context, first: RayRequest) {
        let of = first.key.of.clone();
        let scene = Scene { camera: first.camera, ..Scene::clone(&first.scene) };
        let standing = match first.specs.is_empty() {
            true => Err(Error::input("the curve", "nobody but the reference is shown", "name a technique")),
            false => BuiltTechniques::new(context, &scene, &first.specs),
        };
        let standing = match standing {
            Ok(standing) => standing,
            Err(error) => return self.tell(&first.key, Err(error)),
        };
        let casters = Casters::new(&scene);
        let mut next = Some(first);
        let mut last = None;
        while let Some(asked) = next {
            self.tell(&asked.key, found(context, &casters, &standing, &asked.key));
            let camera = asked.key.camera;
            if last != Some(camera) {
                let errors = seen(context, &casters, &standing, &camera);
                self.lock().seen = Some(((of.clone(), camera), Arc::new(errors)));
                last = Some(camera);
            }
            next = self.next(Some(&of));
        }
    }

    fn tell(&self, key: &Key, answer: Result<PickedRay>) {
        let answer = answer.map(Arc::new).map_err(|error| error.to_string());
        self.lock().answer = Some((key.clone(), answer));
    }
}

/// Returns each technique's seen error in the picture that the camera sees.
fn seen(context: &Context, casters: &Casters, standing: &BuiltTechniques, camera: &View) -> Seen {
    let truth = SeenTruth::new(casters, casters.scene(), camera, SEEN, 0);
    let of = |(opened, name): (&Opened, &String)| {
        let answers = truth.ask(context, &standing.world, opened.technique.as_ref()).ok()?;
        Some((name.clone(), truth.error(&answers).ok()??))
    };
    standing.opened.iter().zip(&standing.names).filter_map(of).collect()
}

/// Returns the light ray through the point visible at the pixel's centre.
fn found(context: &Context, casters: &Casters, standing: &BuiltTechniques, key: &Key) -> Result<PickedRay> {
    let scene = casters.scene();
    let place = casters.seen(&key.camera, DVec2::from(key.pixel.map(f64::from)) + 0.5);
    let [x, y] = key.pixel;
    let place: DVec3 =
        place.ok_or_else(|| Error::input(format!("pixel {x},{y}"), "nothing is seen there", "point at something"))?;
    let map = scene.lights[0].map_at(place.as_vec3().into());
    let view = standing.opened[0].technique.inspect().maps().get(map).map(|map| map.caster_view);
    let (at, z) = view.map_or_else(Default::default, |view| view.project(place));
    // A point outside the map gets a texel outside the map, which is refused with a message.
    let texel = at.to_array().map(|at| if at >= 0.0 { at as u32 } else { u32::MAX });
    let ray = LightRay::new(context, casters, &standing.opened, map, texel)?;
    let face = (scene.lights[0].map_count() > 1).then(|| FACES[map].0);
    let (depth, names) = (ray.view.depth(z), standing.names.clone());
    let is_red = scene.colors() > 1;
    Ok(PickedRay { texel, face, depth, ray, is_red, names, scene: scene.name.clone() })
}
