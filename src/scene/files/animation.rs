//! Animated content: sequences with one file per frame, `smoke.####.ply` for particles and `smoke.####.vdb` for a volume, where `####` is
//! the frame number; and meshes that move by an animation of their file.

use crate::Result;
use crate::scene::files::gltf_motion::Motion;
use crate::scene::files::placement::Placement;
use crate::scene::files::volume_file::{self, Placing};
use crate::scene::{Mesh, Particle, Reserve, Volume, files::input, files::particle_file, files::ply};
use std::fmt;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
#[cfg(feature = "program")]
use std::time::Duration;
use std::time::SystemTime;

/// Default frame rate if a scene file gives none: 24 per second, as in films.
pub(in crate::scene) const FRAMES_PER_SECOND: f64 = 24.0;

/// The particles and volumes of a scene, in the order of the scene file, some of which may come from sequences; and what moves its meshes.
#[derive(PartialEq)]
pub struct Animation {
    parts: Vec<Part>,
    motions: Vec<Motion>,
}

/// One `[[particles]]` or `[[volumes]]` of a scene file.
#[derive(PartialEq)]
pub(in crate::scene) enum Part {
    /// Content of a single file, which is static.
    Still(Content),
    /// Content of a sequence.
    Moving(Box<Sequence>),
}

/// A file's content, after placement.
#[derive(Clone, PartialEq)]
pub(in crate::scene) enum Content {
    Particles(Vec<Particle>),
    Volumes(Vec<Volume>),
}

/// The type of a sequence's files, and how they are placed.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::scene) enum Kind {
    Particles(Placement),
    Volume(Placing),
}

/// The amount of data in a file.
#[derive(Clone, Debug, Default, PartialEq)]
struct Size {
    particles: usize,
    cells: usize,
    /// Number of non-empty blocks of each volume's field.
    blocks: Vec<usize>,
}

/// A sequence of files, played in a loop.
pub(in crate::scene) struct Sequence {
    frames: Arc<Vec<Frame>>,
    frames_per_second: f64,
    kind: Kind,
    kept: Mutex<Kept>,
}

/// A file, with its size and modification time, to detect its replacement.
#[derive(Clone, Debug, PartialEq)]
struct Frame {
    path: PathBuf,
    size: Size,
    bytes: u64,
    changed: Option<SystemTime>,
}

/// The frame shown last, and the next one, which a thread reads ahead.
#[derive(Default)]
struct Kept {
    last: Option<(usize, Content)>,
    next: Option<(usize, JoinHandle<Result<Content>>)>,
}

impl Animation {
    /// Creates an animation with these parts and motions of meshes.
    pub(in crate::scene) fn new(parts: Vec<Part>, motions: Vec<Motion>) -> Self {
        Self { parts, motions }
    }

    /// Returns whether anything moves.
    pub(in crate::scene) fn moves(&self) -> bool {
        self.has_sequences() || self.moves_meshes()
    }

    /// Returns whether any part is a sequence.
    pub(crate) fn has_sequences(&self) -> bool {
        self.parts.iter().any(|part| matches!(part, Part::Moving(_)))
    }

    /// Returns whether any mesh moves.
    pub(crate) fn moves_meshes(&self) -> bool {
        !self.motions.is_empty()
    }

    /// Moves the scene's meshes to where they are `time_s` seconds after the start of their animations.
    ///
    /// # Errors
    /// [`crate::Error::Input`] if a position is not finite.
    pub(crate) fn show_meshes(&self, meshes: &mut [Mesh], time_s: f64) -> Result<()> {
        self.motions.iter().try_for_each(|motion| motion.show(meshes, time_s))
    }

    /// Returns the upper bounds of a scene with these parts.
    pub(in crate::scene) fn reserve(&self) -> Reserve {
        Reserve {
            particles: self.parts.iter().map(|part| part.most().particles).sum(),
            cells: self.parts.iter().map(|part| part.most().cells).sum(),
            blocks: self.parts.iter().flat_map(|part| part.most().blocks).collect(),
            stay_in: None,
        }
    }

    /// Returns the content to which a camera is fitted: the static parts, and [`Sequence::some`] of each sequence.
    ///
    /// # Errors
    /// Errors from reading a frame's file.
    pub(in crate::scene) fn some(&self) -> Result<(Vec<Particle>, Vec<Volume>)> {
        let (mut particles, mut volumes) = (Vec::new(), Vec::new());
        for part in &self.parts {
            match part {
                Part::Still(Content::Particles(more)) => particles.extend_from_slice(more),
                Part::Still(Content::Volumes(more)) => volumes.extend_from_slice(more),
                Part::Moving(sequence) => {
                    let (more, fields) = sequence.some()?;
                    particles.extend(more);
                    volumes.extend(fields);
                }
            }
        }
        Ok((particles, volumes))
    }

    /// Returns the particles and the volumes `time_s` seconds after the start of each sequence.
    ///
    /// # Errors
    /// Errors from reading a frame's file.
    pub(crate) fn at(&self, time_s: f64) -> Result<(Vec<Particle>, Vec<Volume>)> {
        let (mut particles, mut volumes) = (Vec::new(), Vec::new());
        for part in &self.parts {
            let mut add = |content: &Content| match content {
                Content::Particles(more) => particles.extend_from_slice(more),
                Content::Volumes(more) => volumes.extend_from_slice(more),
            };
            match part {
                Part::Still(content) => add(content),
                Part::Moving(sequence) => sequence.show(time_s, add)?,
            }
        }
        Ok((particles, volumes))
    }
}

#[cfg(feature = "program")]
impl Animation {
    /// Waits until the frames that follow the shown ones have been read.
    pub(crate) fn read_ahead(&self) {
        for part in &self.parts {
            if let Part::Moving(sequence) = part {
                sequence.read_ahead();
            }
        }
    }
}

impl Part {
    fn most(&self) -> Size {
        match self {
            Self::Still(content) => content.size(),
            Self::Moving(sequence) => sequence.most(),
        }
    }
}

impl Content {
    fn size(&self) -> Size {
        match self {
            Self::Particles(particles) => Size { particles: particles.len(), ..Size::default() },
            Self::Volumes(volumes) => Size {
                cells: volumes.iter().map(|volume| volume.cells().len()).sum(),
                blocks: volumes.iter().map(|volume| volume.field().blocks().len()).collect(),
                ..Size::default()
            },
        }
    }
}

impl Size {
    /// Returns the field-by-field maximum of the two sizes.
    fn max(mut self, other: &Self) -> Self {
        self.particles = self.particles.max(other.particles);
        self.cells = self.cells.max(other.cells);
        self.blocks.resize(self.blocks.len().max(other.blocks.len()), 0);
        self.blocks.iter_mut().zip(&other.blocks).for_each(|(most, blocks)| *most = (*most).max(*blocks));
        self
    }

    fn is_nothing(&self) -> bool {
        self.particles == 0 && self.cells == 0
    }
}

impl Kind {
    /// Returns the size of a file's content. For particles it is in the file's header; a volume has to be read.
    fn size(&self, path: &Path, notes: &mut Vec<String>) -> Result<Size> {
        match self {
            Self::Particles(_) => Ok(Size { particles: ply::open(path)?.element("vertex")?.count, ..Size::default() }),
            Self::Volume(_) => Ok(self.read(path, notes)?.size()),
        }
    }

    fn read(&self, path: &Path, notes: &mut Vec<String>) -> Result<Content> {
        match self {
            Self::Particles(placement) => particle_file::load(path, placement).map(Content::Particles),
            Self::Volume(placing) => volume_file::frame(path, placing, notes).map(Content::Volumes),
        }
    }
}

impl Sequence {
    /// Opens the files that match `pattern`. Their numbers must be consecutive, but may start anywhere. `notes` gets what the first frame that
    /// is not read whole has, and the number of such frames.
    ///
    /// # Errors
    /// [`crate::Error::Input`] if there is no file, a number is missing or duplicated, a file is of another kind, or all are empty.
    pub(in crate::scene) fn open(
        pattern: &Path,
        frames_per_second: f64,
        kind: Kind,
        notes: &mut Vec<String>,
    ) -> Result<Self> {
        let wrong = |cause: String| input::error(pattern, cause, "number the files without a gap: 0001, 0002, …");
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
        let mut told: Vec<(String, String, usize)> = Vec::new();
        let mut frames = Vec::new();
        for (_, path) in numbered {
            let mut of_frame = Vec::new();
            frames.push(Frame::open(path, &kind, &mut of_frame)?);
            for note in of_frame {
                // One line for each kind, whatever the numbers in it are.
                let text = note.split_once(": ").map_or(&*note, |(_, text)| text);
                let sort: String = text.chars().filter(|c| !c.is_ascii_digit()).collect();
                match told.iter_mut().find(|(known, ..)| *known == sort) {
                    Some((.., count)) => *count += 1,
                    None => told.push((sort, note, 0)),
                }
            }
        }
        notes.extend(told.into_iter().map(|(_, first, more)| match more {
            0 => first,
            1 => format!("{first}; the like in 1 more frame"),
            more => format!("{first}; the like in {more} more frames"),
        }));
        if frames.iter().all(|frame| frame.size.is_nothing()) {
            let cause = "nothing casts a shadow: all of its frames are empty";
            return Err(input::error(pattern, cause, "give other files"));
        }
        Ok(Self { frames: Arc::new(frames), frames_per_second, kind, kept: Mutex::default() })
    }

    /// Returns the content of the first, middle and last frames together, to estimate the extent of the sequence.
    pub(in crate::scene) fn some(&self) -> Result<(Vec<Particle>, Vec<Volume>)> {
        let last = self.frames.len() - 1;
        let part = |frame: usize| load(&self.frames, frame, &self.kind).map(Part::Still);
        let parts = [0, last / 2, last].into_iter().map(part).collect::<Result<Vec<_>>>()?;
        Animation::new(parts, Vec::new()).at(0.0)
    }

    fn most(&self) -> Size {
        self.frames.iter().fold(Size::default(), |most, frame| most.max(&frame.size))
    }

    fn frame(&self, time_s: f64) -> usize {
        (time_s * self.frames_per_second).floor().max(0.0) as usize % self.frames.len()
    }

    /// Shows the frame for a time, and starts a thread that reads the next one.
    fn show(&self, time_s: f64, shown: impl FnOnce(&Content)) -> Result<()> {
        let frame = self.frame(time_s);
        let mut kept = self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        if kept.last.as_ref().is_none_or(|(last, _)| *last != frame) {
            let ahead = kept.next.take().filter(|(next, _)| *next == frame);
            // If the thread panicked, read the frame here.
            let read = ahead.and_then(|(_, thread)| thread.join().ok());
            let content = read.unwrap_or_else(|| load(&self.frames, frame, &self.kind))?;
            kept.last = Some((frame, content));
        }
        let next = (frame + 1) % self.frames.len();
        if next != frame && kept.next.as_ref().is_none_or(|(waits, _)| *waits != next) {
            let (frames, kind) = (self.frames.clone(), self.kind.clone());
            kept.next = Some((next, std::thread::spawn(move || load(&frames, next, &kind))));
        }
        if let Some((_, content)) = &kept.last {
            shown(content);
        }
        Ok(())
    }
}

#[cfg(feature = "program")]
impl Sequence {
    fn read_ahead(&self) {
        let kept = self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        while kept.next.as_ref().is_some_and(|(_, thread)| !thread.is_finished()) {
            std::thread::sleep(Duration::from_millis(1));
        }
    }
}

impl Frame {
    fn open(path: PathBuf, kind: &Kind, notes: &mut Vec<String>) -> Result<Self> {
        let size = kind.size(&path, notes)?;
        let metadata = std::fs::metadata(&path);
        let metadata = metadata.map_err(|cause| input::error(&path, cause, "check the path and its permissions"))?;
        Ok(Self { path, size, bytes: metadata.len(), changed: metadata.modified().ok() })
    }
}

/// The debug text goes into a scene's fingerprint, so it must stay the same while files do not change. Static content is hashed with the
/// scene itself.
impl fmt::Debug for Animation {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("Animation(")?;
        for part in &self.parts {
            match part {
                Part::Still(content) => write!(f, "{:?}; ", content.size())?,
                Part::Moving(sequence) => {
                    let Sequence { frames, frames_per_second, kind, .. } = &**sequence;
                    write!(f, "{frames:?} {frames_per_second} {kind:?}; ")?;
                }
            }
        }
        self.motions.iter().try_for_each(|motion| write!(f, "{motion:?}; "))?;
        f.write_str(")")
    }
}

/// Compares sequences regardless of which frames have been read so far.
impl PartialEq for Sequence {
    fn eq(&self, other: &Self) -> bool {
        self.frames == other.frames && self.frames_per_second == other.frames_per_second && self.kind == other.kind
    }
}

/// Returns whether a path denotes a sequence: its name contains a `#`, and no file has this exact name.
pub(in crate::scene) fn is_sequence(path: &Path) -> bool {
    around(path).is_some() && !path.exists()
}

/// Returns the name of a scene that is a single sequence: the text before the number.
pub(in crate::scene) fn stem(pattern: &Path) -> String {
    let (before, _, after) = around(pattern).unwrap_or_default();
    let before = before.trim_end_matches(['.', '-', '_', ' ']);
    if before.is_empty() {
        input::stem(Path::new(after.trim_start_matches('.')))
    } else {
        input::stem(Path::new(&format!("{before}.{}", input::ending(pattern))))
    }
}

/// Splits a path's file name into the text before the first `#`, the number of `#`, and the text after them.
fn around(path: &Path) -> Option<(String, usize, String)> {
    let name = path.file_name()?.to_str()?;
    let first = name.find('#')?;
    let (before, rest) = name.split_at(first);
    let after = rest.trim_start_matches('#');
    Some((before.into(), rest.len() - after.len(), after.into()))
}

/// Returns all files of a sequence with their numbers, which have at least as many digits as the pattern has `#`.
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

/// Reads a frame. Each has as many volumes as that which has most; further ones are empty.
fn load(frames: &[Frame], number: usize, kind: &Kind) -> Result<Content> {
    let frame = &frames[number];
    // What it leaves out was told when it was opened.
    let mut content = kind.read(&frame.path, &mut Vec::new())?;
    let (size, was) = (content.size(), &frame.size);
    if size.max(was) != *was {
        let more = if matches!(kind, Kind::Particles(_)) { "particles" } else { "cells" };
        return Err(input::error(&frame.path, format!("it has more {more} than when it was opened"), "run again"));
    }
    if let Content::Volumes(volumes) = &mut content {
        let most = frames.iter().map(|frame| frame.size.blocks.len()).max().unwrap_or_default();
        let empty = volumes.first().and_then(|first| Volume::new(Arc::default(), *first.placed()).ok());
        volumes.extend(std::iter::repeat_n(empty, most.saturating_sub(volumes.len())).flatten());
    }
    Ok(content)
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
        Sequence::open(&folder.join(pattern), 10.0, Kind::Particles(Placement::AS_IT_STANDS), &mut Vec::new())
    }

    /// Each file has as many particles as its frame number. Every time must show its own frame, regardless of the order in which times are
    /// requested.
    #[test]
    fn every_time_has_its_frame() {
        let folder = tempfile::tempdir().expect("a folder");
        for number in [9, 10, 11, 12] {
            write(folder.path(), &format!("s.{number:03}.ply"), number);
        }
        // Neither of these files belongs to the sequence: one has too few digits, the other no number.
        write(folder.path(), "s.13.ply", 1);
        write(folder.path(), "s.0xa.ply", 1);
        let sequence = open(folder.path(), "s.###.ply").expect("four frames");
        let animation =
            Animation::new(vec![Part::Still(Content::Particles(vec![])), Part::Moving(Box::new(sequence))], Vec::new());
        assert_eq!(animation.reserve().particles, 12);
        for (time_s, particles) in
            [(0.0, 9), (0.05, 9), (0.1, 10), (0.25, 11), (0.3, 12), (0.4, 9), (0.1, 10), (39.31, 10), (0.0, 9)]
        {
            let at = animation.at(time_s).expect("files").0;
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

    /// A file that has grown, one that is truncated, and one that is missing: each must give a one-line error with the file's name.
    #[test]
    fn a_bad_frame_is_named() {
        let folder = tempfile::tempdir().expect("a folder");
        (0..3).for_each(|number| write(folder.path(), &format!("{number}.ply"), 2));
        let sequence = open(folder.path(), "#.ply").expect("three frames");
        write(folder.path(), "1.ply", 3);
        std::fs::remove_file(folder.path().join("2.ply")).expect("there");
        for (time_s, cause) in [(0.1, "1.ply: it has more particles"), (0.2, "2.ply")] {
            let error = sequence.show(time_s, |_| ()).expect_err("bad").to_string();
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
