//! Scripts that replace keys and mouse. Lines run in order, each once its condition holds.

use crate::{Error, Result};
use std::collections::VecDeque;
use std::path::{Path, PathBuf};
use std::time::Duration;
use winit::event::MouseButton;
use winit::keyboard::{Key, NamedKey};

/// A mouse action, in pixels of the window.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Input {
    /// Moves the pointer to this pixel.
    Move([f64; 2]),
    /// Presses (`true`) or releases a button.
    Button(bool, MouseButton),
    /// Turns the wheel by a number of lines; positive is up.
    Wheel(f64),
    /// Presses (`true`) or releases the control key.
    Control(bool),
}

/// A line of a script.
#[derive(Clone, Debug, PartialEq)]
pub enum Step {
    /// Sets a part of the state, as [`super::State::set`] does.
    Set(String, String),
    /// Presses a key, by its name.
    Key(String),
    /// Orbits the camera around its target by radians to the right and up.
    Orbit(f64, f64),
    /// Waits for a duration.
    Wait(Duration),
    /// Draws a number of frames.
    Frames(u64),
    /// Writes a PNG of the window's picture, once it is complete.
    Screenshot(PathBuf),
    /// Appends the window, once it is complete, to a GIF, shown for a number of milliseconds.
    Gif(PathBuf, u32),
    /// Writes an SVG of the curve under the pointer, once it is computed.
    Curve(PathBuf),
    /// Resizes the picture to this many pixels; 0 × 0 acts as if the window were minimized.
    Resize([u32; 2]),
    /// Drops a file onto the window.
    Drop(String),
    /// Uses the mouse.
    Input(Input),
    /// Prints the pace of the frames so far, and the number of device bytes allocated.
    Report,
    /// Closes the window.
    Quit,
}

/// The lines still to run.
pub struct Script(VecDeque<Step>);

impl Script {
    /// Reads a file with one step per line; `#` begins a comment.
    ///
    /// # Errors
    /// [`Error::Input`] names the line.
    pub fn read(path: &Path) -> Result<Self> {
        let text = std::fs::read_to_string(path);
        let text = text.map_err(|cause| Error::input(path.display().to_string(), cause, "name a file of lines"))?;
        let steps = text.lines().enumerate().filter_map(|(number, line)| {
            let line = line.split('#').next().unwrap_or_default().trim();
            let place = format!("{}:{}: {line}", path.display(), number + 1);
            (!line.is_empty()).then(|| step(line).map_err(|known| Error::input(place, "no such line", known)))
        });
        Ok(Self(steps.collect::<Result<_>>()?))
    }

    /// Removes and returns the next line.
    pub fn next(&mut self) -> Option<Step> {
        self.0.pop_front()
    }
}

/// Parses a line. The error lists the allowed lines.
fn step(line: &str) -> std::result::Result<Step, String> {
    let (word, rest) = line.split_once(' ').map_or((line, ""), |(word, rest)| (word, rest.trim()));
    let numbers = || rest.split_whitespace().map(str::parse).collect::<std::result::Result<Vec<f64>, _>>().ok();
    let whole = |n: f64| (n >= 0.0 && n.fract() == 0.0 && n <= 1e6).then_some(n as u32);
    let step = match (word, numbers().as_deref()) {
        ("set", _) => rest.split_once(' ').map(|(key, value)| Step::Set(key.into(), value.trim().into())),
        ("key", _) => (!rest.is_empty()).then(|| Step::Key(rest.to_lowercase())),
        ("orbit", Some([right, up])) => Some(Step::Orbit(*right, *up)),
        ("wait", Some([ms])) => whole(*ms).map(|ms| Step::Wait(Duration::from_millis(ms.into()))),
        ("frames", Some([count])) => whole(*count).map(|count| Step::Frames(count.into())),
        ("screenshot", _) => (!rest.is_empty()).then(|| Step::Screenshot(rest.into())),
        ("gif", _) => rest
            .rsplit_once(' ')
            .and_then(|(file, ms)| Some(Step::Gif(file.trim().into(), ms.parse().ok().filter(|ms| *ms <= 60_000)?))),
        ("curve", _) => (!rest.is_empty()).then(|| Step::Curve(rest.into())),
        ("resize", Some([width, height])) => whole(*width).zip(whole(*height)).map(|(w, h)| Step::Resize([w, h])),
        ("drop", _) => (!rest.is_empty()).then(|| Step::Drop(rest.into())),
        ("move", Some([x, y])) => Some(Step::Input(Input::Move([*x, *y]))),
        ("wheel", Some([lines])) => Some(Step::Input(Input::Wheel(*lines))),
        ("press" | "release", _) => {
            let is_down = word == "press";
            let button = match rest {
                "left" => Some(Input::Button(is_down, MouseButton::Left)),
                "right" => Some(Input::Button(is_down, MouseButton::Right)),
                "control" => Some(Input::Control(is_down)),
                _ => None,
            };
            button.map(Step::Input)
        }
        ("report", Some([])) => Some(Step::Report),
        ("quit", Some([])) => Some(Step::Quit),
        _ => None,
    };
    let known = "set KEY VALUE, key NAME, orbit RIGHT UP, wait MILLISECONDS, frames N, screenshot FILE, curve FILE, gif FILE MILLISECONDS, resize W H, drop FILE, move X Y, press left, release left, wheel LINES, report, quit";
    step.ok_or_else(|| format!("write one of: {known}"))
}

/// Returns the name of a key in scripts.
pub fn key_name(key: &Key) -> String {
    match key {
        Key::Named(NamedKey::Space) => "space".into(),
        Key::Named(named) => format!("{named:?}").to_lowercase(),
        Key::Character(text) => text.to_lowercase(),
        _ => String::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_steps() {
        for (line, is) in [
            ("set a.nodes 4", Step::Set("a.nodes".into(), "4".into())),
            ("set scene my file.toml", Step::Set("scene".into(), "my file.toml".into())),
            ("key F12", Step::Key("f12".into())),
            ("orbit -0.5 0.25", Step::Orbit(-0.5, 0.25)),
            ("wait 20", Step::Wait(Duration::from_millis(20))),
            ("frames 300", Step::Frames(300)),
            ("screenshot a b.png", Step::Screenshot("a b.png".into())),
            ("gif a b.gif 80", Step::Gif("a b.gif".into(), 80)),
            ("curve a.svg", Step::Curve("a.svg".into())),
            ("resize 64 0", Step::Resize([64, 0])),
            ("move 3 4.5", Step::Input(Input::Move([3.0, 4.5]))),
            ("press right", Step::Input(Input::Button(true, MouseButton::Right))),
            ("release control", Step::Input(Input::Control(false))),
            ("wheel -2", Step::Input(Input::Wheel(-2.0))),
            ("report", Step::Report),
            ("quit", Step::Quit),
        ] {
            assert_eq!(step(line), Ok(is), "{line}");
        }
        for line in [
            "set a",
            "frames",
            "frames -1",
            "frames 1.5",
            "resize 1",
            "quit now",
            "jump",
            "press",
            "press middle",
            "move 1",
            "gif 80",
            "gif a.gif",
            "gif a.gif -1",
            "screenshot",
        ] {
            assert!(step(line).is_err_and(|known| known.contains("screenshot FILE")), "{line}");
        }
    }

    #[test]
    fn keys_have_names() {
        let named = [NamedKey::Space, NamedKey::F12, NamedKey::Escape].map(|key| key_name(&Key::Named(key)));
        assert_eq!(named, ["space", "f12", "escape"]);
        assert_eq!(key_name(&Key::Character("C".into())), "c");
    }

    #[test]
    fn a_file_names_its_wrong_line() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("script");
        std::fs::write(&path, "# first\nquit # last\n").expect("written");
        let mut script = Script::read(&path).expect("right");
        assert_eq!((script.next(), script.next()), (Some(Step::Quit), None));
        std::fs::write(&path, "quit\n\njump 3\n").expect("written");
        let error = Script::read(&path).map(|_| ()).expect_err("wrong").to_string();
        assert!(error.contains("script:3: jump 3: no such line") && !error.contains('\n'), "{error}");
    }
}
