//! Particles of a sequence of files, one file per frame: `smoke.####.ply`, in which `####` stands for the frame's
//! number.

use crate::Result;
use crate::scene::files::placement::Placement;
use crate::scene::{Motion, Particle, files::input, files::particle_file, files::ply};
use std::fmt;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::SystemTime;

/// Frames a second where a scene file says nothing: a film's.
pub(in crate::scene) const FRAMES_PER_SECOND: f64 = 24.0;

/// The particles of a scene of which some come from sequences, in the order of the scene file.
#[derive(Debug, PartialEq)]
pub struct Animation {
    parts: Vec<Part>,
}

/// One `[[particles]]` of a scene file.
#[derive(Debug, PartialEq)]
pub(in crate::scene) enum Part {
    /// Particles of one file, which stand still.
    Still(Vec<Particle>),
    /// Particles of a sequence.
    Moving(Sequence),
}

/// A sequence of files that is played again and again.
pub(in crate::scene) struct Sequence {
    frames: Arc<Vec<Frame>>,
    frames_per_second: f64,
    placement: Placement,
    kept: Mutex<Kept>,
}

/// A file, and what tells it from another of its name.
#[derive(Clone, Debug, PartialEq)]
struct Frame {
    path: PathBuf,
    particles: usize,
    bytes: u64,
    changed: Option<SystemTime>,
}

/// The frame that was asked for last, and the one behind it, which a thread reads in the meantime.
#[derive(Default)]
struct Kept {
    last: Option<(usize, Vec<Particle>)>,
    next: Option<(usize, JoinHandle<Result<Vec<Particle>>>)>,
}

impl Animation {
    /// An animation of these parts.
    pub(in crate::scene) fn new(parts: Vec<Part>) -> Self {
        Self { parts }
    }

    /// What a scene of it does.
    pub(in crate::scene) fn motion(self) -> Motion {
        let moves = self.parts.iter().any(|part| matches!(part, Part::Moving(_)));
        if moves { Motion::Animation(Arc::new(self)) } else { Motion::Still }
    }

    /// Particles that there are at once, at most.
    pub fn most_particles(&self) -> usize {
        let most = |part: &Part| match part {
            Part::Still(particles) => particles.len(),
            Part::Moving(sequence) => sequence.frames.iter().map(|frame| frame.particles).max().unwrap_or(0),
        };
        self.parts.iter().map(most).sum()
    }

    /// The particles `time_s` seconds after each sequence began.
    ///
    /// # Errors
    /// Whatever a frame's file is wrong with.
    pub(in crate::scene) fn at(&self, time_s: f64) -> Result<Vec<Particle>> {
        let mut all = Vec::new();
        for part in &self.parts {
            match part {
                Part::Still(particles) => all.extend_from_slice(particles),
                Part::Moving(sequence) => sequence.add(time_s, &mut all)?,
            }
        }
        Ok(all)
    }
}

impl Sequence {
    /// The files that `pattern` stands for. Their numbers go up by 1, from whichever is the first.
    ///
    /// # Errors
    /// [`crate::Error::Input`]: there is none, one is missing or there twice, or one is no file of particles.
    pub(in crate::scene) fn open(pattern: &Path, frames_per_second: f64, placement: Placement) -> Result<Self> {
        let wrong =
            |cause: String| input::error(pattern, cause, "number the files without a gap, as in smoke.0001.ply");
        let mut numbered = files(pattern)?;
        numbered.sort();
        if numbered.is_empty() {
            return Err(wrong("no file has such a name with a number in the place of #".into()));
        }
        for pair in numbered.windows(2) {
            let [(a, first), (b, second)] = pair else { continue };
            if a == b {
                return Err(wrong(format!("{} and {} are both frame {a}", name(first), name(second))));
            }
            if a + 1 != *b {
                return Err(wrong(format!(
                    "frame {} is missing: {} is followed by {}",
                    a + 1,
                    name(first),
                    name(second)
                )));
            }
        }
        let frames = numbered.into_iter().map(|(_, path)| Frame::open(path)).collect::<Result<Vec<_>>>()?;
        Ok(Self { frames: Arc::new(frames), frames_per_second, placement, kept: Mutex::default() })
    }

    /// The particles of a few frames, to see how far they go: the first, the one in the middle and the last.
    pub(in crate::scene) fn some(&self) -> Result<Vec<Particle>> {
        let last = self.frames.len() - 1;
        let mut all = Vec::new();
        for frame in [0, last / 2, last] {
            all.extend(load(&self.frames[frame], &self.placement)?);
        }
        Ok(all)
    }

    fn frame(&self, time_s: f64) -> usize {
        (time_s * self.frames_per_second).floor().max(0.0) as usize % self.frames.len()
    }

    /// Adds the frame of a time to `all`, and has the one behind it read.
    fn add(&self, time_s: f64, all: &mut Vec<Particle>) -> Result<()> {
        let frame = self.frame(time_s);
        let mut kept = self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        if kept.last.as_ref().is_none_or(|(last, _)| *last != frame) {
            let ahead = kept.next.take().filter(|(next, _)| *next == frame);
            // A thread that panicked has read nothing: then it is read here.
            let read = ahead.and_then(|(_, thread)| thread.join().ok());
            let particles = read.unwrap_or_else(|| load(&self.frames[frame], &self.placement))?;
            kept.last = Some((frame, particles));
        }
        let next = (frame + 1) % self.frames.len();
        if next != frame && kept.next.as_ref().is_none_or(|(waits, _)| *waits != next) {
            let (frames, placement) = (self.frames.clone(), self.placement);
            kept.next = Some((next, std::thread::spawn(move || load(&frames[next], &placement))));
        }
        all.extend(kept.last.iter().flat_map(|(_, particles)| particles));
        Ok(())
    }
}

impl Frame {
    fn open(path: PathBuf) -> Result<Self> {
        let particles = ply::open(&path)?.element("vertex")?.count;
        let metadata = std::fs::metadata(&path);
        let metadata = metadata.map_err(|cause| input::error(&path, cause, "check the path and its permissions"))?;
        Ok(Self { path, particles, bytes: metadata.len(), changed: metadata.modified().ok() })
    }
}

/// What is the same while files do not change: a scene's fingerprint is made of it, and what has been read so far is no part of it.
impl fmt::Debug for Sequence {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let Self { frames, frames_per_second, placement, .. } = self;
        write!(f, "{frames:?} {frames_per_second} {placement:?}")
    }
}

impl PartialEq for Sequence {
    fn eq(&self, other: &Self) -> bool {
        self.frames == other.frames
            && self.frames_per_second == other.frames_per_second
            && self.placement == other.placement
    }
}

/// Whether a path stands for a sequence: its name has a `#`, and no file has that name.
pub(in crate::scene) fn is_sequence(path: &Path) -> bool {
    around(path).is_some() && !path.exists()
}

/// A scene's name where a sequence is the scene: what stands before the number.
pub(in crate::scene) fn stem(pattern: &Path) -> String {
    let (before, _, after) = around(pattern).unwrap_or_default();
    let before = before.trim_end_matches(['.', '-', '_', ' ']);
    if before.is_empty() {
        input::stem(Path::new(after.trim_start_matches('.')))
    } else {
        input::stem(Path::new(&format!("{before}.ply")))
    }
}

/// What stands before the `#`s of a name, how many there are, and what stands behind them.
fn around(path: &Path) -> Option<(String, usize, String)> {
    let name = path.file_name()?.to_str()?;
    let first = name.find('#')?;
    let (before, rest) = name.split_at(first);
    let after = rest.trim_start_matches('#');
    Some((before.into(), rest.len() - after.len(), after.into()))
}

/// All files of a sequence with their numbers, which have at least as many digits as the pattern has `#`.
fn files(pattern: &Path) -> Result<Vec<(u64, PathBuf)>> {
    let Some((before, digits, after)) = around(pattern) else { return Ok(Vec::new()) };
    let folder = pattern.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let unreadable = |cause: std::io::Error| input::error(folder, cause, "check the path and its permissions");
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(unreadable)? {
        let path = entry.map_err(unreadable)?.path();
        let name = path.file_name().and_then(|name| name.to_str());
        let number = name.and_then(|name| name.strip_prefix(&*before)?.strip_suffix(&*after));
        let number = number.filter(|text| text.len() >= digits && text.bytes().all(|byte| byte.is_ascii_digit()));
        if let Some(number) = number.and_then(|text| text.parse().ok()) {
            found.push((number, path));
        }
    }
    Ok(found)
}

fn name(path: &Path) -> String {
    path.file_name().unwrap_or_default().to_string_lossy().into_owned()
}

fn load(frame: &Frame, placement: &Placement) -> Result<Vec<Particle>> {
    let path = &frame.path;
    let particles = particle_file::load(path)?;
    if particles.len() > frame.particles {
        return Err(input::error(path, "it has more particles than when it was opened", "run again"));
    }
    let place = |(number, particle)| {
        let wrong = |cause| format!("placed particle {number} (the first is 0): {cause}");
        placement.particle(particle).map_err(|cause| input::error(path, wrong(cause), "correct scale and translate"))
    };
    particles.iter().enumerate().map(place).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn write(folder: &Path, name: &str, particles: usize) {
        let header = "ply\nformat ascii 1.0\nelement vertex COUNT\nproperty float x\nproperty float y\nproperty float z\n\
                      property float radius\nproperty float extinction\nend_header\n";
        let rows: String = (0..particles).map(|i| format!("{i} 0 {particles} 1 0.5\n")).collect();
        std::fs::write(folder.join(name), header.replace("COUNT", &particles.to_string()) + &rows).expect("write");
    }

    fn open(folder: &Path, pattern: &str) -> Result<Sequence> {
        Sequence::open(&folder.join(pattern), 10.0, Placement::AS_IT_STANDS)
    }

    /// As many particles as the frame's number says, whatever the order in which times are asked for.
    #[test]
    fn every_time_has_its_frame() {
        let folder = tempfile::tempdir().expect("a folder");
        for number in [9, 10, 11, 12] {
            write(folder.path(), &format!("s.{number:03}.ply"), number);
        }
        // Neither is of the sequence: too few digits, another word.
        write(folder.path(), "s.13.ply", 1);
        write(folder.path(), "s.0xa.ply", 1);
        let sequence = open(folder.path(), "s.###.ply").expect("four frames");
        let animation = Animation::new(vec![Part::Still(vec![]), Part::Moving(sequence)]);
        assert_eq!(animation.most_particles(), 12);
        for (time_s, particles) in
            [(0.0, 9), (0.05, 9), (0.1, 10), (0.25, 11), (0.3, 12), (0.4, 9), (0.1, 10), (39.31, 10), (0.0, 9)]
        {
            let at = animation.at(time_s).expect("files");
            assert_eq!((at.len(), at[0].position[2]), (particles, particles as f32), "{time_s} s");
        }
    }

    #[test]
    fn a_gap_is_named() {
        let folder = tempfile::tempdir().expect("a folder");
        let said = |pattern: &str| open(folder.path(), pattern).map(|_| ()).expect_err("no sequence").to_string();
        assert!(said("s.##.ply").contains("no file has such a name"), "{}", said("s.##.ply"));
        write(folder.path(), "s.01.ply", 1);
        write(folder.path(), "s.03.ply", 1);
        assert!(said("s.##.ply").contains("frame 2 is missing: s.01.ply is followed by s.03.ply"));
        write(folder.path(), "s.003.ply", 1);
        write(folder.path(), "s.02.ply", 1);
        assert!(said("s.##.ply").contains("are both frame 3"), "{}", said("s.##.ply"));
    }

    /// A file that is longer than it was, one that ends too early, and one that is gone: a line each, with its name.
    #[test]
    fn a_bad_frame_is_named() {
        let folder = tempfile::tempdir().expect("a folder");
        (0..3).for_each(|number| write(folder.path(), &format!("{number}.ply"), 2));
        let sequence = open(folder.path(), "#.ply").expect("three frames");
        write(folder.path(), "1.ply", 3);
        std::fs::remove_file(folder.path().join("2.ply")).expect("there");
        let mut all = Vec::new();
        for (time_s, cause) in [(0.1, "1.ply: it has more particles"), (0.2, "2.ply")] {
            let error = sequence.add(time_s, &mut all).expect_err("bad").to_string();
            assert!(error.contains(cause) && !error.contains('\n'), "{error}");
        }
        let text = std::fs::read_to_string(folder.path().join("0.ply")).expect("text");
        std::fs::write(folder.path().join("0.ply"), &text[..text.len() - 9]).expect("write");
        assert!(open(folder.path(), "#.ply").is_err());
    }

    #[test]
    fn a_scene_is_called_what_its_files_are() {
        for (pattern, called) in
            [("a/smoke.####.ply", "smoke"), ("smoke-#.ply", "smoke"), ("####.ply", "ply"), ("#-fire.ply", "-fire")]
        {
            assert_eq!(stem(Path::new(pattern)), called);
        }
        assert!(is_sequence(Path::new("x/a.##.ply")) && !is_sequence(Path::new("a.ply")));
    }
}
