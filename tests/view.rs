//! `gobo view` under a virtual X server, by scripts: what its files show is what the commands make that it copies.

#![cfg(feature = "view")]

use std::collections::HashSet;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use tempfile::TempDir;

/// A virtual X server, which ends with the test.
struct Screen {
    server: Child,
    display: String,
}

impl Drop for Screen {
    fn drop(&mut self) {
        let _ = self.server.kill();
        let _ = self.server.wait();
    }
}

/// None, and a line that says so, where no Xvfb is installed.
fn screen(test: &str) -> Option<Screen> {
    let arguments = ["-displayfd", "1", "-screen", "0", "1400x800x24", "-nolisten", "tcp"];
    let started = Command::new("Xvfb").args(arguments).stdout(Stdio::piped()).stderr(Stdio::null()).spawn();
    let Ok(mut server) = started else {
        println!("{test}: skipped: no Xvfb; ./setup.sh installs it");
        return None;
    };
    let mut number = String::new();
    BufReader::new(server.stdout.take().expect("piped")).read_line(&mut number).expect("Xvfb says its display");
    Some(Screen { server, display: format!(":{}", number.trim()) })
}

fn gobo() -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_gobo"));
    command.env_remove("WAYLAND_DISPLAY").env_remove("WAYLAND_SOCKET").env("WINIT_X11_SCALE_FACTOR", "1");
    command
}

/// Runs a script in a folder.
fn view(screen: &Screen, folder: &Path, arguments: &[&str], script: &str) -> Output {
    std::fs::write(folder.join("script"), script).expect("written");
    let mut command = gobo();
    command.args(["--test-hooks", "view"]).args(arguments).args(["--script", "script"]);
    command.current_dir(folder).env("DISPLAY", &screen.display).output().expect("it starts")
}

/// Its lines, where all went well.
#[track_caller]
fn lines(output: &Output) -> Vec<String> {
    let [said, error] = [&output.stdout, &output.stderr].map(|bytes| String::from_utf8_lossy(bytes).into_owned());
    assert!(output.status.success() && error.is_empty(), "{said}\n{error}");
    said.lines().map(str::to_owned).collect()
}

fn pixels(path: &Path) -> ([u32; 2], Vec<u8>) {
    let image = image::open(path).unwrap_or_else(|error| panic!("{}: {error}", path.display())).into_rgb8();
    ([image.width(), image.height()], image.into_raw())
}

/// What a command that was copied makes.
fn made(folder: &Path, command: &str) -> PathBuf {
    let words: Vec<&str> = command.split(' ').skip(1).collect();
    let out = folder.join("made.png");
    let output = gobo().args(&words).args(["-o", "made.png"]).current_dir(folder).output().expect("it starts");
    assert!(output.status.success(), "{command}: {}", String::from_utf8_lossy(&output.stderr));
    out
}

fn folder() -> TempDir {
    tempfile::tempdir().expect("a folder")
}

const SMALL: [&str; 4] = ["--width", "200", "--height", "120"];

/// Each control changes what is seen, and the command that is copied then makes the very pixels: on a device of its own, at once.
#[test]
fn what_is_seen_is_what_the_command_makes() {
    let Some(screen) = screen("what_is_seen_is_what_the_command_makes") else { return };
    let folder = folder();
    let controls = [
        "set panel on",
        "set a.nodes 4",
        "set a.size 64",
        "set a psm:size=32,slices=16",
        "set direction 0.5,0.2,-1",
        "set extinction 0.3",
        "orbit 0.4 0.1",
        "set target 0.3,0.1,0.5",
        "key w",
        "set time 4",
        "set a.path fused",
        "set a voxel-grid:size=64",
        "key f6",
        "set a avsm:size=32\nkey f5",
        "set depth 0.3",
        "key x\nkey f1",
        "set scene plume_8k",
        "resize 150 130",
        "set show b",
        "set b avsm:size=16,shading=tiled",
    ];
    let script: String =
        controls.iter().enumerate().map(|(i, control)| format!("{control}\nscreenshot {i}.png\nkey c\n")).collect();
    let specs = ["--technique", "avsm:size=48", "--against", "translucency-map:size=32"];
    let output =
        view(&screen, folder.path(), &[&["three-emitters"], &specs[..], &SMALL].concat(), &(script + "quit\n"));
    let lines = lines(&output);
    let commands: Vec<_> = lines.iter().filter(|line| line.starts_with("gobo ")).collect();
    assert_eq!(commands.len(), controls.len(), "{lines:#?}");
    let mut seen = HashSet::new();
    for (i, (control, command)) in controls.iter().zip(commands).enumerate() {
        let seen_now = pixels(&folder.path().join(format!("{i}.png")));
        let made = pixels(&made(folder.path(), command));
        assert_eq!(seen_now.0, made.0, "{control}: {command}");
        let far = seen_now.1.iter().zip(&made.1).filter(|(a, b)| a != b).count();
        assert_eq!(far, 0, "{control}: {command}: bytes that are others, of {}", made.1.len());
        // AVSM's nodes are more than plain smoke needs; a path of one technique is no other picture.
        let is_other = seen.insert(seen_now.1);
        assert!(is_other || control.contains("path"), "{control} changes nothing");
    }
}

/// A wipe has A's pixels left of its line and B's right of it; a difference is theirs, times the gain.
#[test]
fn pictures_stand_side_by_side() {
    let Some(screen) = screen("pictures_stand_side_by_side") else { return };
    let folder = folder();
    let script = "key f1\nscreenshot a.png\nkey f2\nscreenshot b.png\nkey f3\nset wipe 0.5\nscreenshot wipe.png\nkey f4\nset gain 3\n\
                  screenshot difference.png\nset show b\nset b reference\nscreenshot truth.png\nset show difference\nscreenshot error.png\nquit\n";
    let specs = ["--technique", "avsm:size=16,nodes=4", "--against", "avsm:size=64"];
    lines(&view(&screen, folder.path(), &[&["plume_8k"], &specs[..], &SMALL].concat(), script));
    let [a, b, wipe, difference, truth, error] = ["a", "b", "wipe", "difference", "truth", "error"]
        .map(|name| pixels(&folder.path().join(format!("{name}.png"))).1);
    let left = |i: usize| i / 3 % 200 < 100;
    assert!((0..a.len()).all(|i| wipe[i] == if left(i) { a[i] } else { b[i] }));
    assert!(a != b && wipe != a && wipe != b);
    let apart = |a: &[u8], b: &[u8], i: usize| (u32::from(a[i].abs_diff(b[i])) * 3).min(255);
    assert!((0..a.len()).all(|i| u32::from(difference[i]) == apart(&a, &b, i)));
    assert!((0..a.len()).all(|i| u32::from(error[i]) == apart(&a, &truth, i)));
    let made = made(folder.path(), "gobo render plume_8k --plain --technique reference --width 200 --height 120");
    assert_eq!(truth, pixels(&made).1, "the reference fills in to what render makes");
}

/// 300 frames, 100 in the usual loop, in which smoke and camera move, under the validation layer, with as much memory at the end as near the beginning.
#[test]
fn it_goes_on_for_long() {
    let Some(screen) = screen("it_goes_on_for_long") else { return };
    let folder = folder();
    let frames = if std::env::var_os("GOBO_TEST_ALL").is_some_and(|value| !value.is_empty()) { 300 } else { 100 };
    let script = format!(
        "set panel off\nresize 64 48\nset show wipe\nset runs on\nframes 40\norbit 0.2 0.1\nset runs off\nset time 2\nscreenshot first.png\nreport\nset runs on\n\
                  frames {}\nset runs off\nset time 2\nscreenshot last.png\nreport\nquit\n",
        frames - 40
    );
    let specs = ["--technique", "avsm:size=32", "--against", "psm:size=32,slices=16"];
    let small = ["--width", "64", "--height", "48", "--validation"];
    let lines = lines(&view(&screen, folder.path(), &[&["three-emitters"], &specs[..], &small].concat(), &script));
    let reports: Vec<Vec<u64>> = lines
        .iter()
        .filter(|line| line.contains("bytes of device memory"))
        .map(|line| line.split(' ').filter_map(|word| word.parse().ok()).collect())
        .collect();
    println!("{reports:?}");
    assert!(reports[1][0] >= frames, "frames: {reports:?}");
    assert_eq!(reports[0][1], reports[1][1], "bytes: {reports:?}");
    let [first, last] = ["first.png", "last.png"].map(|name| pixels(&folder.path().join(name)));
    assert!(first == last, "the same state is the same picture, whatever was before");
}

/// What cannot be is a line, and the window goes on as it was.
#[test]
fn what_goes_wrong_is_a_line() {
    let Some(screen) = screen("what_goes_wrong_is_a_line") else { return };
    let folder = folder();
    std::fs::write(folder.path().join("broken.toml"), "particles = 3\n").expect("written");
    let script = "screenshot a.png\nresize 0 0\nframes 3\nresize 200 120\nscreenshot b.png\ndrop broken.toml\nscreenshot c.png\n\
                  set a ism\nframes 3\nset a avsm:size=32\nset direction 0,0,0\nframes 2\nscreenshot d.png\ndrop shafts\n\
                  screenshot e.png\nset direction 0,0,1\nframes 2\nscreenshot f.png\nquit\n";
    let output =
        view(&screen, folder.path(), &[&["plume_8k", "--technique", "avsm:size=32"], &SMALL[..]].concat(), script);
    let error = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{error}");
    let words = ["broken.toml", "of no length", "none of its lights has a direction"];
    assert_eq!(error.lines().count(), words.len(), "{error}");
    error.lines().zip(words).for_each(|(line, words)| assert!(line.contains(words), "{line}"));
    let [a, b, c, d, e, f] =
        ["a", "b", "c", "d", "e", "f"].map(|name| pixels(&folder.path().join(format!("{name}.png"))));
    assert!(a == b && a == c && a == d, "it is as it was");
    assert!(a != e && e == f, "a scene that can be loaded is shown");
}

/// What ends it is one line and a failure.
#[test]
fn what_ends_it_is_one_line() {
    let Some(screen) = screen("what_ends_it_is_one_line") else { return };
    let folder = folder();
    let fails = |output: Output, words: &[&str]| {
        let error = String::from_utf8_lossy(&output.stderr).into_owned();
        let error: Vec<_> = error.lines().filter(|line| !line.starts_with("GOBO_TEST_FAULT")).collect();
        assert!(!output.status.success() && error.len() == 1, "{error:?}");
        words.iter().for_each(|word| assert!(error[0].contains(word), "{word}: {error:?}"));
    };
    let plume = [&["plume_8k", "--technique", "avsm:size=16"], &SMALL[..]].concat();
    fails(view(&screen, folder.path(), &plume, "frames 2\njump\n"), &["script:2: jump", "screenshot FILE"]);
    fails(view(&screen, folder.path(), &plume, "frames 2\nset a.nodes 5\n"), &["nodes=5", "4, 8, 16"]);
    fails(view(&screen, folder.path(), &["no-such-scene"], "quit\n"), &["no-such-scene"]);
    fails(view(&screen, folder.path(), &plume, "screenshot no/dir/a.png\n"), &["no/dir/a.png"]);
    let mut lost = gobo();
    lost.args(["--test-hooks", "view"]).args(&plume).args(["--script", "script"]).current_dir(folder.path());
    std::fs::write(folder.path().join("script"), "frames 50\nquit\n").expect("written");
    lost.env("DISPLAY", &screen.display).env("GOBO_TEST_FAULT", "submission:5");
    fails(lost.output().expect("it starts"), &["ERROR_DEVICE_LOST", "gobo devices"]);
    let mut nowhere = gobo();
    nowhere.args(["view", "plume_8k"]).env_remove("DISPLAY").current_dir(folder.path());
    fails(nowhere.output().expect("it starts"), &["a window", "display"]);
}
