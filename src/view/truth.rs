//! The f64 reference beside the window: it fills in from coarse to fine on threads of its own while nothing moves.

use crate::reference::truth::{Casters, developed, picture, picture_rows, shown_picture, shown_rows};
use crate::scene::{Picture, Scene, Show, View};
use std::ops::Range;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// By how much the first, coarse picture is smaller per side.
const COARSE: u32 = 8;

/// How long some rows take, about.
const SHARE: Duration = Duration::from_millis(200);

/// A picture that is being made.
struct Job {
    /// Which state of which scene, by which camera, and how it is shown.
    of: (u64, View, Option<Show>),
    shared: Arc<Shared>,
    thread: Option<JoinHandle<()>>,
}

#[derive(Default)]
struct Shared {
    stop: AtomicBool,
    progress: Mutex<Progress>,
}

#[derive(Default)]
struct Progress {
    picture: Option<Picture>,
    rows: u32,
    /// Since the window last looked.
    is_new: bool,
    is_over: bool,
}

impl Drop for Job {
    fn drop(&mut self) {
        self.shared.stop.store(true, Ordering::Relaxed);
        // The thread ends by itself, after its present rows; it is not waited for.
        drop(self.thread.take());
    }
}

/// The reference of the last view.
pub struct Truth {
    job: Option<Job>,
}

impl Truth {
    /// A reference that has begun no picture.
    pub fn new() -> Self {
        Self { job: None }
    }

    /// Begins the picture of `scene`, of which `version` says which state it is, where it is not under way or done: as
    /// it is shown, or measured.
    pub fn see(&mut self, version: u64, scene: &Scene, camera: &View, show: Option<Show>) {
        if self.job.as_ref().is_some_and(|job| job.of == (version, *camera, show)) {
            return;
        }
        let shared = Arc::new(Shared::default());
        let (scene, camera, theirs) = (scene.clone(), *camera, shared.clone());
        let thread = std::thread::Builder::new().name("truth".into()).spawn(move || theirs.make(&scene, &camera, show));
        self.job = Some(Job { of: (version, camera, show), shared, thread: thread.ok() });
    }

    /// The result is not wanted.
    pub fn rest(&mut self) {
        self.job = None;
    }

    fn progress<T>(&self, look: impl FnOnce(&mut Progress) -> T) -> Option<T> {
        let job = self.job.as_ref()?;
        Some(look(&mut job.shared.progress.lock().unwrap_or_else(PoisonError::into_inner)))
    }

    /// Whether it is complete.
    pub fn is_whole(&self) -> bool {
        self.progress(|progress| progress.is_over && !progress.is_new).unwrap_or(false)
    }

    /// Rows that are there, and all of them.
    pub fn rows(&self) -> [u32; 2] {
        let rows = self.progress(|progress| progress.rows).unwrap_or(0);
        [rows, self.job.as_ref().map_or(0, |job| job.of.1.height)]
    }

    /// The picture as it is now, where it has changed since the last call, or in `any` case.
    pub fn news(&self, any: bool) -> Option<Picture> {
        let news = self.progress(|progress| {
            let is_new = std::mem::take(&mut progress.is_new);
            progress.picture.clone().filter(|_| is_new || any)
        });
        news.flatten()
    }
}

impl Shared {
    /// On a thread of its own.
    fn make(&self, scene: &Scene, camera: &View, show: Option<Show>) {
        // One core is the window's.
        let cores = std::thread::available_parallelism().map_or(1, usize::from);
        let Ok(pool) = rayon::ThreadPoolBuilder::new().num_threads((cores - 1).max(1)).build() else { return };
        pool.install(|| {
            let casters = Casters::new(scene);
            let coarse =
                View { width: camera.width.div_ceil(COARSE), height: camera.height.div_ceil(COARSE), ..*camera };
            if self.is_stopped() {
                return;
            }
            let first = match show {
                None => picture(&casters, scene, &coarse),
                Some(show) => {
                    developed(&shown_picture(&casters, scene, &coarse), &Show { grid: [1; 2], stops: show.stops })
                }
            };
            self.tell(|progress| progress.picture = Some(enlarged(&first, camera)));
            let (mut row, mut rows) = (0, 1);
            while row < camera.height && !self.is_stopped() {
                let end = (row + rows).min(camera.height);
                let start = Instant::now();
                let pixels = rows_of(&casters, scene, camera, show, row..end);
                let at = (row * camera.width) as usize;
                self.tell(|progress| {
                    if let Some(picture) = &mut progress.picture {
                        picture.pixels[at..at + pixels.len()].copy_from_slice(&pixels);
                    }
                    (progress.rows, progress.is_over) = (end, end == camera.height);
                });
                let fits = SHARE.as_secs_f64() / start.elapsed().as_secs_f64().max(1e-6) * f64::from(end - row);
                (row, rows) = (end, (fits as u32).clamp(1, 2 * rows));
            }
        });
    }

    fn is_stopped(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }

    fn tell(&self, what: impl FnOnce(&mut Progress)) {
        let mut progress = self.progress.lock().unwrap_or_else(PoisonError::into_inner);
        what(&mut progress);
        progress.is_new = true;
    }
}

/// Rows of the picture as it is shown, or measured.
fn rows_of(casters: &Casters, scene: &Scene, camera: &View, show: Option<Show>, rows: Range<u32>) -> Vec<[f32; 3]> {
    let Some(show) = show else { return picture_rows(casters, scene, camera, rows) };
    let [width, height] = show.sampled([camera.width, camera.height]);
    let sampled = View { width, height, ..*camera };
    let rows = rows.start * show.grid[1]..rows.end * show.grid[1];
    let pixels = shown_rows(casters, scene, &sampled, rows.clone());
    developed(&Picture { width, height: rows.end - rows.start, pixels }, &show).pixels
}

/// A coarse picture as large as the camera's.
fn enlarged(coarse: &Picture, camera: &View) -> Picture {
    let at = |i: u32| {
        let (x, y) = (i % camera.width * coarse.width / camera.width, i / camera.width * coarse.height / camera.height);
        coarse.pixels[(y * coarse.width + x) as usize]
    };
    Picture { width: camera.width, height: camera.height, pixels: (0..camera.width * camera.height).map(at).collect() }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// In the end it is the whole reference, and before it a picture of as many pixels.
    #[test]
    fn it_fills_in() {
        let scene = Scene::load("plume_8k", 0.0).expect("built in");
        let camera = View::camera(&scene.camera, &scene, [48, 20]);
        let mut truth = Truth::new();
        truth.see(0, &scene, &camera, None);
        let mut last = None;
        while !truth.is_whole() {
            if let Some(news) = truth.news(false) {
                assert_eq!((news.width, news.height, news.pixels.len()), (48, 20, 960));
                last = Some(news);
            }
            std::thread::sleep(Duration::from_millis(5));
        }
        assert_eq!(truth.rows(), [20, 20]);
        assert_eq!(last.expect("some"), picture(&Casters::new(&scene), &scene, &camera));
        truth.see(0, &scene, &camera, None);
        assert!(truth.is_whole(), "the same is not made again");
        truth.see(1, &scene, &camera, None);
        assert!(!truth.is_whole(), "another state is");
    }
}
