//! The f64 reference in the window: while nothing moves, a worker computes it from coarse to fine. A later request replaces an earlier one,
//! so the window never waits for a slow reference, and only one is computed at a time.

use crate::gpu::slow_truth;
use crate::reference::truth::{Casters, picture_rows, shown_rows, tonemapped};
use crate::scene::{Picture, Scene, Show, View};
use std::ops::Range;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// Factor by which the first, coarse picture is smaller per side.
const COARSE: u32 = 8;

/// Approximate time between two updates of the shown picture.
const SHARE: Duration = Duration::from_millis(100);

/// Version number of the casters and lights, the camera, and how to show the picture.
type TruthKey = (u64, View, Option<Show>);

/// A picture to compute.
struct Job {
    of: TruthKey,
    scene: Arc<Scene>,
}

/// Messages between the window and the worker.
#[derive(Default)]
struct Post {
    /// Latest request, until the worker takes it.
    next: Option<Job>,
    /// Picture that the worker is computing, or computed last.
    at: Option<TruthKey>,
    is_busy: bool,
    picture: Option<Picture>,
    rows: u32,
    /// Whether there are new rows since the window last looked.
    is_new: bool,
    /// Whether all rows of `at` are done.
    is_over: bool,
    /// Whether the window is closing.
    is_closed: bool,
}

#[derive(Default)]
struct Shared {
    post: Mutex<Post>,
    wakes: Condvar,
    /// Set when the picture that the worker is computing is no longer wanted.
    stop: AtomicBool,
    counts: [AtomicU64; 3],
}

/// Number of pictures that the worker began, finished, and dropped unfinished.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    pub begun: u64,
    pub finished: u64,
    pub dropped: u64,
}

/// The reference of the last view.
#[derive(Default)]
pub struct Truth {
    shared: Arc<Shared>,
    has_worker: bool,
    wanted: Option<TruthKey>,
    /// Whether the wanted picture was handed to the worker.
    is_asked: bool,
}

impl Drop for Truth {
    fn drop(&mut self) {
        self.rest();
        self.shared.lock().is_closed = true;
        // The worker exits by itself after its current rows. Nothing waits for it.
        self.shared.wakes.notify_all();
    }
}

impl Truth {
    /// Requests the picture of a scene, unless it is being computed or is done. With `show` the picture is tone-mapped for viewing,
    /// otherwise it is as measured. `cast` is the version number of the casters and lights. `scene` returns the scene and is called only
    /// once the worker has nothing else to do, so call this function again in each frame.
    pub fn see(&mut self, cast: u64, camera: &View, show: Option<Show>, scene: impl FnOnce() -> Option<Arc<Scene>>) {
        let of = (cast, *camera, show);
        if self.wanted != Some(of) {
            self.rest();
            self.wanted = Some(of);
        }
        if self.is_asked {
            return;
        }
        let mut post = self.shared.lock();
        if post.at == self.wanted && post.is_over {
            (self.is_asked, post.is_new) = (true, true);
            return;
        }
        if post.is_busy {
            return;
        }
        drop(post);
        let Some(scene) = scene() else { return };
        let mut post = self.shared.lock();
        self.shared.stop.store(false, Ordering::Relaxed);
        (post.next, post.is_busy, post.is_over, post.rows) = (Some(Job { of, scene }), true, false, 0);
        drop(post);
        self.is_asked = true;
        self.shared.wakes.notify_all();
        if !self.has_worker {
            let theirs = self.shared.clone();
            self.has_worker = std::thread::Builder::new().name("truth".into()).spawn(move || theirs.work()).is_ok();
        }
    }

    /// Drops the last request.
    pub fn rest(&mut self) {
        (self.wanted, self.is_asked) = (None, false);
        let mut post = self.shared.lock();
        post.is_new = false;
        self.shared.stop.store(true, Ordering::Relaxed);
        if post.next.take().is_some() {
            post.is_busy = false;
        }
    }

    /// Whether the picture is complete and the window has it.
    pub fn is_whole(&self) -> bool {
        let post = self.shared.lock();
        self.is_asked && post.at == self.wanted && post.is_over && !post.is_new
    }

    /// Returns the number of finished rows, and the number of all rows.
    pub fn rows(&self) -> [u32; 2] {
        let post = self.shared.lock();
        let rows = if self.is_asked && post.at == self.wanted { post.rows } else { 0 };
        [rows, self.wanted.map_or(0, |(_, camera, _)| camera.height)]
    }

    /// Returns the present picture if it has changed since the last call, or always if `any`.
    pub fn news(&self, any: bool) -> Option<Picture> {
        let mut post = self.shared.lock();
        if !self.is_asked || post.at != self.wanted {
            return None;
        }
        let is_new = std::mem::take(&mut post.is_new);
        post.picture.clone().filter(|_| is_new || any)
    }

    /// Returns the number of pictures that the worker has begun, finished and dropped.
    pub fn counts(&self) -> Counts {
        let [begun, finished, dropped] = [0, 1, 2].map(|i: usize| self.shared.counts[i].load(Ordering::Relaxed));
        Counts { begun, finished, dropped }
    }
}

impl Shared {
    fn lock(&self) -> MutexGuard<'_, Post> {
        self.post.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Waits for the next request; `None` if the window closes.
    fn next(&self) -> Option<Job> {
        let mut post = self.lock();
        loop {
            if post.is_closed {
                return None;
            }
            match post.next.take() {
                Some(job) => {
                    (post.at, post.picture, post.is_new) = (Some(job.of), None, false);
                    self.counts[0].fetch_add(1, Ordering::Relaxed);
                    return Some(job);
                }
                None => post.is_busy = false,
            }
            post = self.wakes.wait(post).unwrap_or_else(PoisonError::into_inner);
        }
    }

    /// Works until the window closes. Casters stay sorted as long as they are unchanged.
    fn work(&self) {
        // Leaves one core for the window.
        let cores = std::thread::available_parallelism().map_or(1, usize::from);
        let threads = (cores - 1).max(1);
        let named = rayon::ThreadPoolBuilder::new().num_threads(threads).thread_name(|i| format!("truth {i}"));
        let Ok(pool) = named.build() else { return };
        let mut next = self.next();
        while let Some(first) = next {
            let scene = first.scene.clone();
            let casters = pool.install(|| Casters::new(&scene));
            let mut job = first;
            next = loop {
                let is_made = pool.install(|| self.make(&casters, &scene, &job.of));
                self.counts[if is_made { 1 } else { 2 }].fetch_add(1, Ordering::Relaxed);
                match self.next() {
                    Some(same) if Arc::ptr_eq(&same.scene, &scene) => job = same,
                    other => break other,
                }
            };
        }
    }

    /// Computes a picture. Returns whether it was finished.
    fn make(&self, casters: &Casters, scene: &Scene, of: &TruthKey) -> bool {
        let (_, camera, show) = of;
        let coarse = View { width: camera.width.div_ceil(COARSE), height: camera.height.div_ceil(COARSE), ..*camera };
        let look = show.map(|show| Show { grid: [1; 2], stops: show.stops });
        let mut first = Vec::new();
        let is_whole = self.rows(coarse.height, |rows| {
            first.extend(rows_of(casters, scene, &coarse, look, rows));
        });
        if !is_whole {
            return false;
        }
        let first = enlarged(&Picture { width: coarse.width, height: coarse.height, pixels: first }, camera);
        self.tell(|post| post.picture = Some(first));
        self.rows(camera.height, |rows| {
            let (at, end) = ((rows.start * camera.width) as usize, rows.end);
            let pixels = rows_of(casters, scene, camera, *show, rows);
            self.tell(|post| {
                if let Some(picture) = &mut post.picture {
                    picture.pixels[at..at + pixels.len()].copy_from_slice(&pixels);
                }
                (post.rows, post.is_over) = (end, end == camera.height);
            });
        })
    }

    /// Calls `make` for all rows, a few at a time. Returns `false` if it was stopped before the end.
    fn rows(&self, height: u32, mut make: impl FnMut(Range<u32>)) -> bool {
        let (mut row, mut rows) = (0, 1);
        while row < height {
            let end = (row + rows).min(height);
            let start = Instant::now();
            if self.stop.load(Ordering::Relaxed) {
                return false;
            }
            slow_truth(end - row);
            make(row..end);
            let fits = SHARE.as_secs_f64() / start.elapsed().as_secs_f64().max(1e-6) * f64::from(end - row);
            (row, rows) = (end, (fits as u32).clamp(1, 2 * rows));
        }
        true
    }

    /// Updates the messages to the window, unless the picture is no longer wanted.
    fn tell(&self, what: impl FnOnce(&mut Post)) {
        let mut post = self.lock();
        if !self.stop.load(Ordering::Relaxed) {
            what(&mut post);
            post.is_new = true;
        }
    }
}

/// Computes rows of the picture: for viewing if `show` is given, otherwise as measured.
fn rows_of(casters: &Casters, scene: &Scene, camera: &View, show: Option<Show>, rows: Range<u32>) -> Vec<[f32; 3]> {
    let Some(show) = show else { return picture_rows(casters, scene, camera, rows) };
    let [width, height] = show.sampled([camera.width, camera.height]);
    let sampled = View { width, height, ..*camera };
    let rows = rows.start * show.grid[1]..rows.end * show.grid[1];
    let pixels = shown_rows(casters, scene, &sampled, rows.clone());
    tonemapped(&Picture { width, height: rows.end - rows.start, pixels }, &show).pixels
}

/// Enlarges a coarse picture to the camera's size.
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
    use crate::reference::truth::picture;

    fn plume() -> (Arc<Scene>, View) {
        let scene = Scene::load("plume_8k", 0.0).expect("built in");
        let camera = View::camera(&scene.camera, &scene, [48, 20]);
        (Arc::new(scene), camera)
    }

    /// At the end the picture must equal the whole reference; before, it must have the same number of pixels.
    #[test]
    fn it_fills_in() {
        let (scene, camera) = plume();
        let mut truth = Truth::default();
        let mut last = None;
        while !truth.is_whole() {
            truth.see(0, &camera, None, || Some(scene.clone()));
            if let Some(news) = truth.news(false) {
                assert_eq!((news.width, news.height, news.pixels.len()), (48, 20, 960));
                last = Some(news);
            }
            std::thread::sleep(Duration::from_millis(5));
        }
        assert_eq!(truth.rows(), [20, 20]);
        assert_eq!(last.expect("some"), picture(&Casters::new(&scene), &scene, &camera));
        truth.see(0, &camera, None, || unreachable!("the same is not made again"));
        assert!(truth.is_whole());
        truth.rest();
        truth.see(0, &camera, None, || unreachable!("nor where nobody looked meanwhile"));
        assert!(truth.news(false).is_some() && truth.is_whole());
        truth.see(1, &camera, None, || None);
        assert!(!truth.is_whole(), "another state is");
    }

    /// Requests come faster than pictures are computed. Some pictures must be finished and some dropped, and the last one must be finished.
    /// No picture may begin without a call for its scene.
    #[test]
    fn the_newest_takes_the_place_of_what_was_asked_before() {
        let (scene, camera) = plume();
        let (mut truth, mut asked) = (Truth::default(), 0);
        let seen = |i: u64| View { far: camera.far + i as f32 * 1e-3, ..camera };
        let mut all = 0;
        // On a busy machine, none of the first few hundred requests may be computed.
        while all < 300 || truth.counts().dropped == 0 && all < 20_000 {
            let scene = || {
                asked += 1;
                Some(scene.clone())
            };
            truth.see(all, &seen(all), None, scene);
            all += 1;
            std::thread::sleep(Duration::from_micros(100));
        }
        while !truth.is_whole() {
            truth.see(all - 1, &seen(all - 1), None, || {
                asked += 1;
                Some(scene.clone())
            });
            let _ = truth.news(false);
            std::thread::sleep(Duration::from_millis(1));
        }
        // The last picture is counted just after it is handed over.
        let at_rest = |of: Counts| of.begun == of.finished + of.dropped;
        (0..1000).take_while(|_| !at_rest(truth.counts())).for_each(|_| std::thread::sleep(Duration::from_millis(1)));
        let Counts { begun, finished, dropped } = truth.counts();
        assert!(finished >= 1 && dropped >= 1 && begun < all, "{begun} {finished} {dropped}");
        assert!(begun == finished + dropped && begun <= asked, "{begun} {finished} {dropped} {asked}");
        assert_eq!(truth.news(true).expect("whole"), picture(&Casters::new(&scene), &scene, &seen(all - 1)));
    }
}
