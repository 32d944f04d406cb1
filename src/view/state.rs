//! The window's state: everything that a control, a key or a line of a script sets. It is independent of any device.

use crate::animate::AnimatedScene;
use crate::scene::{MOST_GRAVITY, SceneChange, Show as Look, axis_name, number_of, with_number};
use crate::shading::parse;
use crate::technique::Spec;
use crate::technique::keys::check;
use crate::{Error, Result};
use glam::DVec3;

/// The source of a picture's light: a technique or the reference.
#[derive(Clone, Debug)]
pub enum Side {
    /// A technique.
    Technique(Spec),
    /// The f64 reference on the CPU.
    Reference,
}

impl Side {
    /// Parses a spec, or `reference`.
    ///
    /// # Errors
    /// [`Error::Usage`] if the text is neither, or a sweep.
    pub fn read(text: &str) -> Result<Self> {
        if text == "reference" {
            return Ok(Self::Reference);
        }
        let mut specs = parse(text)?;
        match (specs.pop(), specs.is_empty()) {
            (Some(spec), true) => Ok(Self::Technique(spec)),
            _ => Err(Error::usage(text, "a sweep", "name one value per key, or use compare")),
        }
    }

    /// Returns the text that [`Side::read`] parses.
    pub fn text(&self) -> String {
        match self {
            Self::Technique(spec) => spec.short(),
            Self::Reference => "reference".into(),
        }
    }
}

/// Which view of A and B is shown. Twins: the numbers of glsl/view/present.comp.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Show {
    A = 0,
    B = 1,
    /// A to the left of a line, B to the right.
    Wipe = 2,
    /// Difference between A and B, in steps of 1/255.
    Difference = 3,
    /// Transmittance of A at one depth of a light's range.
    Slice = 4,
    /// Number of steps that A's look-ups take.
    Steps = 5,
    /// A, with the triangles of lighting=vertex drawn over some casters. The shader treats this like A.
    Wireframe = 6,
    /// A, the truth and B in a row, with their differences below.
    Beside = 7,
}

impl Show {
    /// Words for the views, in the order of their keys, F1 to F8.
    pub const ALL: [(&str, Self); 8] = [
        ("a", Self::A),
        ("b", Self::B),
        ("wipe", Self::Wipe),
        ("difference", Self::Difference),
        ("slice", Self::Slice),
        ("steps", Self::Steps),
        ("wireframe", Self::Wireframe),
        ("beside", Self::Beside),
    ];

    /// Whether the view consists of pictures of A or B.
    pub fn is_picture(self) -> bool {
        !matches!(self, Self::Slice | Self::Steps)
    }

    /// Whether the view involves A, and B.
    pub fn draws(self) -> [bool; 2] {
        [self != Self::B, matches!(self, Self::B | Self::Wipe | Self::Difference | Self::Beside)]
    }
}

/// Everything that determines the picture.
#[derive(Clone, Debug)]
pub struct State {
    pub scene: String,
    /// Same as the option `--time`.
    pub time_s: f64,
    /// Same as the option `--lights`.
    pub lights: Option<usize>,
    pub eye: Option<DVec3>,
    pub target: Option<DVec3>,
    pub direction: Option<DVec3>,
    pub extinction: f64,
    /// Same as the option `--attractor`.
    pub attractor: Option<DVec3>,
    /// Same as the option `--gravity`.
    pub gravity: f64,
    /// Same as the option `--up`.
    pub up: Option<DVec3>,
    /// A, then B.
    pub sides: [Side; 2],
    pub show: Show,
    /// Position of the wipe's line, from 0 at the left to 1 at the right.
    pub wipe: f64,
    /// Factor that scales differences.
    pub gain: u32,
    /// Whether pictures are shown as by `render`, rather than `render --plain`.
    pub full: bool,
    /// Same as the option `--samples`.
    pub samples: u32,
    /// Same as the option `--exposure`.
    pub exposure: f32,
    /// Light of the slice.
    pub light: usize,
    /// Depth of the slice; 0 is nearest to the light.
    pub depth: f32,
    /// Whether the curve under the pointer is shown.
    pub curve: bool,
    /// Pixel of the picture whose curve is shown; `None` for the centre.
    pub pointer: Option<[u32; 2]>,
    /// Whether time runs.
    pub runs: bool,
    /// Whether the panel is shown.
    pub panel: bool,
}

impl State {
    /// Creates a state that shows a scene unchanged, lit by the usual technique.
    pub fn new(scene: &str, time_s: f64, lights: Option<usize>) -> Self {
        Self {
            scene: scene.into(),
            time_s,
            lights,
            eye: None,
            target: None,
            direction: None,
            extinction: 1.0,
            attractor: None,
            gravity: 1.0,
            up: None,
            sides: [Side::Reference, Side::Reference],
            show: Show::A,
            wipe: 0.5,
            gain: 8,
            full: false,
            samples: 4,
            exposure: 0.0,
            light: 0,
            depth: 0.5,
            curve: false,
            pointer: None,
            runs: false,
            panel: true,
        }
    }

    /// Returns the changes that the state makes to the scene.
    pub fn change(&self) -> SceneChange {
        SceneChange { eye: self.eye, target: self.target, direction: self.direction, extinction: self.extinction }
    }

    /// Returns how to show pictures; `None` to show them as measured, and for views that are not pictures.
    pub fn look(&self) -> Option<Look> {
        let look = Look::new(self.samples, self.exposure).ok();
        look.filter(|_| self.full && self.show.is_picture())
    }

    /// Loads the scene that the state names, at its time.
    ///
    /// # Errors
    /// See [`AnimatedScene::load`], [`AnimatedScene::with_lights`] and [`AnimatedScene::pulled`].
    pub fn load(&self) -> Result<AnimatedScene> {
        let scene = AnimatedScene::load_upright(&self.scene, self.time_s, self.up)?;
        let scene = match self.lights {
            Some(lights) => scene.with_lights(lights, self.time_s)?,
            None => scene,
        };
        if self.pull() == (None, 1.0) {
            return Ok(scene);
        }
        scene.pulled(self.attractor, self.gravity, self.time_s)
    }

    /// Returns the attractor and the gravity of simulated particles: by default no attractor, and gravity 1.
    pub fn pull(&self) -> (Option<DVec3>, f64) {
        (self.attractor, self.gravity)
    }

    /// Switches to another scene, with the camera and the light from its file.
    pub fn choose(&mut self, scene: &str) {
        (self.scene, self.lights, self.light) = (scene.into(), None, 0);
        (self.eye, self.target, self.direction, self.extinction) = (None, None, None, 1.0);
        (self.attractor, self.gravity, self.up) = (None, 1.0, None);
    }

    /// Returns to the scene of `good` and stops time, since the present scene cannot be shown.
    pub fn go_back_to(&mut self, good: &Self) {
        self.choose(&good.scene);
        (self.lights, self.light, self.time_s, self.runs) = (good.lights, good.light, good.time_s, false);
        (self.attractor, self.gravity) = good.pull();
        self.up = good.up;
        (self.eye, self.target) = (good.eye, good.target);
        (self.direction, self.extinction) = (good.direction, good.extinction);
    }

    /// Sets the part of the state named by `key`: `scene`, `number` (of its particles or lights), `a`, `b`, `a.KEY` and `b.KEY` of a spec,
    /// `show`, `wipe`, `gain`, `look`, `samples`, `exposure`, `light` and `depth` of the slice, `curve`, `pointer`, `eye`, `target`,
    /// `direction`, `extinction`, `attractor`, `gravity`, `time`, `runs`, `panel`.
    ///
    /// # Errors
    /// [`Error::Input`] if there is no such key, or the value is not allowed for it.
    pub fn set(&mut self, key: &str, value: &str) -> Result<()> {
        let wrong = |known: &str| Error::input(format!("{key} {value}"), "is not known", format!("give {known}"));
        let number = |low: f64, high: f64| {
            let number = value.parse().ok().filter(|n| (low..=high).contains(n));
            number.ok_or_else(|| wrong(&format!("a number from {low} to {high}")))
        };
        let vector = || {
            let numbers: Vec<f64> = value.split(',').filter_map(|n| n.trim().parse().ok()).collect();
            let three = <[f64; 3]>::try_from(numbers).ok().filter(|v| v.iter().all(|n| n.is_finite()));
            three.map(DVec3::from).map(Some).ok_or_else(|| wrong("three numbers, X,Y,Z"))
        };
        let switch = || match value {
            "on" => Ok(true),
            "off" => Ok(false),
            _ => Err(wrong("on or off")),
        };
        match key {
            "scene" => self.choose(value),
            "number" => {
                let (_, _, most) = number_of(&self.scene).ok_or_else(|| wrong("a scene that takes one first"))?;
                self.scene = with_number(&self.scene, number(1.0, most.into())? as u32);
            }
            "a" => self.sides[0] = Side::read(value)?,
            "b" => self.sides[1] = Side::read(value)?,
            "show" => {
                let word = Show::ALL.iter().find(|(word, _)| *word == value);
                self.show = word.ok_or_else(|| wrong(&Show::ALL.map(|(word, _)| word).join(", ")))?.1;
            }
            "wipe" => self.wipe = number(0.0, 1.0)?,
            "gain" => self.gain = number(1.0, 255.0)? as u32,
            "light" => self.light = number(0.0, 65535.0)? as usize,
            "depth" => self.depth = number(0.0, 1.0)? as f32,
            "eye" => self.eye = vector()?,
            "target" => self.target = vector()?,
            "direction" => self.direction = vector()?,
            "extinction" => self.extinction = number(0.0, 1e6)?,
            "attractor" => self.attractor = if value == "off" { None } else { vector()? },
            "gravity" => self.gravity = number(0.0, MOST_GRAVITY)?,
            "time" => self.time_s = number(0.0, 1e6)?,
            "look" => {
                self.full = match value {
                    "full" => true,
                    "plain" => false,
                    _ => return Err(wrong("full or plain")),
                }
            }
            "samples" => {
                let samples = value.parse().ok().filter(|samples| Look::new(*samples, 0.0).is_ok());
                self.samples = samples.ok_or_else(|| wrong("1, 4, 8 or 16"))?;
            }
            "exposure" => self.exposure = number(-20.0, 20.0)? as f32,
            "curve" => self.curve = switch()?,
            "pointer" => {
                let numbers: Vec<u32> = value.split(',').filter_map(|n| n.trim().parse().ok()).collect();
                self.pointer = Some(numbers.try_into().map_err(|_| wrong("two whole numbers, X,Y"))?);
            }
            "runs" => self.runs = switch()?,
            "panel" => self.panel = switch()?,
            _ => match key.split_once('.') {
                Some(("a", key)) => set_key(&mut self.sides[0], key, value)?,
                Some(("b", key)) => set_key(&mut self.sides[1], key, value)?,
                _ => {
                    let known = "a, b, a.KEY, b.KEY, scene, number, show, wipe, gain, look, samples, exposure, light, depth, curve, pointer, eye, target, direction, extinction, attractor, gravity, time, runs, panel";
                    return Err(Error::input(format!("set {key}"), "no such key", format!("choose one of: {known}")));
                }
            },
        }
        Ok(())
    }

    /// Formats a command for this state; `more` holds the command's own options.
    fn line(&self, command: &str, more: &str) -> String {
        let mut line = format!("gobo {command} {}{more} --time {}", quoted(&self.scene), self.time_s);
        if let Some(lights) = self.lights {
            line += &format!(" --lights {lights}");
        }
        for (name, value) in [("eye", self.eye), ("target", self.target), ("direction", self.direction)] {
            if let Some(DVec3 { x, y, z }) = value {
                line += &format!(" --{name} {x},{y},{z}");
            }
        }
        if let Some(up) = self.up {
            line += &format!(" --up {}", axis_name(up));
        }
        if let Some(DVec3 { x, y, z }) = self.attractor {
            line += &format!(" --attractor {x},{y},{z}");
        }
        if self.gravity != 1.0 {
            line += &format!(" --gravity {}", self.gravity);
        }
        if self.extinction != 1.0 {
            line += &format!(" --extinction {}", self.extinction);
        }
        line
    }

    /// Returns the command that plots the curve of a texel of light 0's map, for the techniques `specs`.
    pub fn curve_command(&self, [x, y]: [u32; 2], face: Option<&str>, specs: &[&Spec]) -> String {
        let face = face.map_or_else(String::new, |face| format!(" --face {face}"));
        let techniques: String = specs.iter().map(|spec| format!(" --technique {}", quoted(&spec.short()))).collect();
        self.line("curve", &format!(" --texel {x},{y}{face}{techniques}"))
    }

    /// Returns the commands that produce the window's pictures, one line each. `size` is the size of the picture. `faces` tells whether the
    /// slice's light has six maps.
    pub fn commands(&self, size: [u32; 2], faces: bool) -> Vec<String> {
        let look = match self.look() {
            None => " --plain".into(),
            Some(_) => format!(" --samples {} --exposure {}", self.samples, self.exposure),
        };
        let line = |side: &Side, command: &str, more: String| {
            self.line(command, &format!("{look} --technique {}{more}", quoted(&side.text())))
        };
        let [a, b] = &self.sides;
        let pixels = format!(" --picture {}x{}", size[0], size[1]);
        match self.show {
            Show::A => vec![line(a, "render", pixels)],
            Show::B => vec![line(b, "render", pixels)],
            Show::Wipe | Show::Difference => [a, b].map(|side| line(side, "render", pixels.clone())).to_vec(),
            Show::Beside => [a, &Side::Reference, b].map(|side| line(side, "render", pixels.clone())).to_vec(),
            Show::Slice => {
                let face = if faces { " --face +x" } else { "" };
                let light = if self.light > 0 { format!(" --light {}", self.light) } else { String::new() };
                let side = size[0].min(size[1]);
                vec![line(a, "slice", format!(" --picture {side}x{side} --depth {}{light}{face}", self.depth))]
            }
            Show::Wireframe => vec![line(a, "render", pixels + " --wireframe")],
            Show::Steps => vec![line(a, "render", pixels + " --steps")],
        }
    }
}

/// Sets a key of a spec.
fn set_key(side: &mut Side, key: &str, value: &str) -> Result<()> {
    let Side::Technique(spec) = side else {
        return Err(Error::input(format!("set {key}"), "the reference has no keys", "choose a technique first"));
    };
    let Some(known) = spec.keys().find(|known| known.name == key && !spec.text(*known).is_empty()) else {
        let keys: Vec<_> = spec.keys().filter(|key| !spec.text(*key).is_empty()).map(|key| key.name).collect();
        return Err(Error::input(format!("set {key}"), "no such key", format!("choose one of: {}", keys.join(", "))));
    };
    check(known, value).map_err(|known| Error::input(format!("{key}={value}"), "is not known", known))?;
    spec.set(known, value);
    Ok(())
}

/// Quotes text for a shell if necessary.
fn quoted(text: &str) -> String {
    let plain = |c: char| c.is_alphanumeric() || "-_./:=,".contains(c);
    if text.chars().all(plain) { text.into() } else { format!("'{}'", text.replace('\'', r"'\''")) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn state() -> State {
        let sides = ["avsm:size=32", "psm"].map(|text| Side::read(text).expect(text));
        State { sides, ..State::new("plume_8k", 20.0, None) }
    }

    #[test]
    fn a_command_says_all_that_was_set() {
        let mut state = state();
        for (key, value) in [
            ("a.nodes", "4"),
            ("eye", "1,2,3.5"),
            ("direction", "0,0.1,-1"),
            ("extinction", "0.25"),
            ("time", "3"),
            ("show", "wipe"),
        ] {
            state.set(key, value).expect(key);
        }
        let rest = "--picture 64x48 --time 3 --eye 1,2,3.5 --direction 0,0.1,-1 --extinction 0.25";
        let lines = ["avsm:nodes=4,size=32", "psm"]
            .map(|spec| format!("gobo render plume_8k --plain --technique {spec} {rest}"));
        assert_eq!(state.commands([64, 48], false), lines);
        state.choose("a file's.toml");
        assert!(state.commands([1, 1], false)[0].starts_with(r"gobo render 'a file'\''s.toml' --plain --technique"));
    }

    #[test]
    fn a_number_keeps_the_camera() {
        let mut state = state();
        assert!(state.set("number", "3").is_err(), "plume_8k takes none");
        state.choose("fountain");
        state.set("eye", "1,2,3").expect("a place");
        state.set("number", "1000").expect("a number");
        assert_eq!((&*state.scene, state.eye), ("fountain:particles=1000", Some(DVec3::new(1.0, 2.0, 3.0))));
        assert!(state.commands([1, 1], false)[0].starts_with("gobo render fountain:particles=1000"));
        assert!(state.set("number", "0").is_err());
    }

    #[test]
    fn what_is_no_value_is_refused_in_one_line() {
        let mut state = state();
        for (key, value, words) in [
            ("a.nodes", "5", "4, 8, 16"),
            ("a.knots", "5", "nodes"),
            ("show", "c", "wipe"),
            ("depth", "2", "from 0 to 1"),
            ("eye", "1,2", "X,Y,Z"),
            ("runs", "yes", "on or off"),
            ("b", "vsm", "avsm"),
            ("b", "avsm:nodes=4|8", "sweep"),
            ("lamp", "1", "extinction"),
        ] {
            let error = state.set(key, value).expect_err(value).to_string();
            assert!(error.contains(words) && !error.contains('\n'), "{error}");
        }
        assert_eq!(state.sides[0].text(), "avsm:size=32", "what is refused changes nothing");
    }
}
