//! `gobo view` under a virtual X server, driven by scripts: its pictures must equal those made by the commands that it copies.

#![cfg(feature = "view")]

use glam::{DVec2, DVec3};
use gobo::bench::Results;
use gobo::reference::truth::Casters;
use gobo::scene::{Scene, View};
use image::AnimationDecoder;
use image::codecs::gif::GifDecoder;
use std::collections::HashSet;
use std::fs::File;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};
use tempfile::TempDir;

mod support;

#[path = "view/beside.rs"]
mod beside;
#[path = "view/faults.rs"]
mod faults;
#[path = "view/input.rs"]
mod input;

/// A virtual X server, stopped at the end of the test.
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

/// Starts a screen; returns `None`, after a message, if Xvfb is not installed.
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

/// Returns the output lines of a successful run.
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

/// Runs a copied command, and returns the file that it made.
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

const SMALL: [&str; 2] = ["--picture", "200x120"];

/// Each control must change the picture, and the command copied then must give the same pixels, on its own device and in one go.
#[test]
fn what_is_seen_is_what_the_command_makes() {
    if crate::support::is_costly("what_is_seen_is_what_the_command_makes") {
        return;
    }
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
        "set show slice\nset scene lantern\nset light 1",
        "key x\nkey f1",
        "set scene plume_8k",
        "resize 150 130",
        "set show b",
        "set b avsm:size=16,shading=tiled",
        "set a avsm:size=32,lighting=vertex\nset show wireframe",
        "set scene fountain:particles=2000\nset show a",
        "set attractor 1.5,0.5,2.5",
        "set gravity 4",
        "set look full\nset a avsm:size=32",
        "set samples 8\nset exposure 1.5",
        "set a reference\nset samples 1\nset scene plume_8k",
        "set a avsm:size=32,lighting=vertex\nset show wireframe",
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
        // Each command starts a program, so the usual loop runs every third.
        if !support::is_usual() || i % 3 == 0 {
            let made = pixels(&made(folder.path(), command));
            assert_eq!(seen_now.0, made.0, "{control}: {command}");
            let far = seen_now.1.iter().zip(&made.1).filter(|(a, b)| a != b).count();
            assert_eq!(far, 0, "{control}: {command}: bytes that are others, of {}", made.1.len());
        }
        // AVSM's nodes exceed what plain smoke needs; another path of a technique must give the same picture.
        let is_other = seen.insert(seen_now.1);
        assert!(is_other || control.contains("path"), "{control} changes nothing");
    }
}

/// The SVG of the curve under the pointer must equal that of `gobo curve` for the texel that the f64 reference finds there.
#[test]
fn the_curve_is_of_what_the_pointer_is_at() {
    if crate::support::is_costly("the_curve_is_of_what_the_pointer_is_at") {
        return;
    }
    let Some(screen) = screen("the_curve_is_of_what_the_pointer_is_at") else { return };
    let folder = folder();
    let pointers = [[100, 60], [112, 40], [90, 52]];
    let mut script: String = String::new();
    for (i, [x, y]) in pointers.iter().enumerate() {
        script += &format!("set pointer {x},{y}\ncurve {i}.svg\nkey c\n");
    }
    script += "wait 6000\nreport\n";
    script += "set direction 0.4,0.1,-1\nset extinction 0.5\nset a.nodes 4\ncurve 3.svg\nkey c\nquit\n";
    let specs = ["--technique", "avsm:size=40,nodes=8", "--against", "uncompressed:size=40"];
    let output = view(&screen, folder.path(), &[&["plume_8k"], &specs[..], &SMALL].concat(), &script);
    let lines = lines(&output);
    let commands: Vec<_> = lines.iter().filter(|line| line.starts_with("gobo curve ")).collect();
    assert_eq!(commands.len(), 4, "{lines:#?}");
    seen_errors_are_those_of_compare(folder.path(), &lines);
    let scene = Scene::load("plume_8k", 20.0).expect("built in");
    let camera = View::camera(&scene.camera, &scene, [200, 120]);
    let (casters, map) = (Casters::new(&scene), View::volumes(&scene, 40)[0]);
    let mut seen = HashSet::new();
    for (i, command) in commands.into_iter().enumerate() {
        let words: Vec<&str> = command.split(' ').skip(1).collect();
        let output =
            gobo().args(&words).args(["-o", "made.svg"]).current_dir(folder.path()).output().expect("it starts");
        assert!(output.status.success(), "{command}: {}", String::from_utf8_lossy(&output.stderr));
        let [shown, made] = [format!("{i}.svg"), "made.svg".into()]
            .map(|name| std::fs::read_to_string(folder.path().join(name)).expect("written"));
        assert!(shown == made, "{command}");
        assert!(seen.insert(shown), "{command}: it is another curve");
        if let Some(pixel) = pointers.get(i) {
            let place = casters.seen(&camera, DVec2::from(pixel.map(f64::from)) + 0.5).expect("smoke");
            let [x, y] = map.project(place).0.to_array().map(|at| at as u32);
            assert!(words.contains(&format!("{x},{y}").as_str()), "{command}: not {x},{y}");
        }
    }
}

/// The script's report must contain the seen errors of A and B, consistent with those of `gobo compare` at other points.
fn seen_errors_are_those_of_compare(folder: &Path, lines: &[String]) {
    let specs = ["--technique", "avsm:size=40,nodes=8", "--technique", "uncompressed:size=40"];
    let size = ["--picture", "200x120", "--frames", "1", "--out", "compared"];
    let output = gobo().args(["compare", "plume_8k"]).args(specs).args(size).current_dir(folder).output();
    assert!(output.expect("it starts").status.success());
    let results = Results::read(&folder.join("compared/results.json")).expect("written");
    let report = lines.iter().find(|line| line.contains("seen error")).unwrap_or_else(|| panic!("{lines:#?}"));
    for (row, part) in results.rows.iter().zip(report.split("seen error ").skip(1)) {
        let seen = row.error.as_ref().and_then(|error| error.seen).expect("seen");
        let mut numbers = part.split([' ', ',', ';']).filter_map(|word| word.parse::<f64>().ok());
        let (mean, off) = (numbers.next().expect("the error"), numbers.next().expect("its standard error"));
        let most = 4.0 * (off + seen.standard_error.expect("many points")) + 1e-4;
        assert!(off > 0.0 && (mean - seen.mean).abs() <= most, "{}: {mean} ± {off}, not {seen:?}", row.technique);
    }
    assert_eq!(report.matches("seen error").count(), 2, "{report}");
}

/// If the attractor is held to the left or right of the camera, the particles must appear there.
#[test]
fn particles_are_seen_where_they_are_pulled() {
    if crate::support::is_costly("particles_are_seen_where_they_are_pulled") {
        return;
    }
    let Some(screen) = screen("particles_are_seen_where_they_are_pulled") else { return };
    let folder = folder();
    let script = "set attractor -1.2,0,2.8\nscreenshot left.png\nset attractor 1.2,0,2.8\nscreenshot right.png\n\
                  set attractor off\nset gravity 0\nscreenshot light.png\nset gravity 6\nscreenshot heavy.png\nquit\n";
    let specs = ["--technique", "avsm:size=32"];
    lines(&view(&screen, folder.path(), &[&["fountain:particles=3000"], &specs[..], &SMALL].concat(), script));
    let [left, right, light, heavy] =
        ["left", "right", "light", "heavy"].map(|name| pixels(&folder.path().join(format!("{name}.png"))).1);
    // Mean position, as column and row, of the pixels that are brighter in the first picture than in the second.
    let middle = |a: &[u8], b: &[u8]| {
        let (mut all, mut sums) = (0.0, [0.0; 2]);
        for (i, (a, b)) in a.iter().zip(b).enumerate() {
            let weight = f64::from(a.saturating_sub(*b));
            all += weight;
            sums[0] += weight * (i / 3 % 200) as f64;
            sums[1] += weight * (i / 3 / 200) as f64;
        }
        sums.map(|sum| sum / all)
    };
    let (at_left, at_right) = (middle(&left, &right), middle(&right, &left));
    println!("{at_left:?} {at_right:?} {:?} {:?}", middle(&light, &heavy), middle(&heavy, &light));
    assert!(at_left[0] + 15.0 < at_right[0], "{at_left:?} {at_right:?}");
    // Rows count from the top.
    assert!(middle(&light, &heavy)[1] + 10.0 < middle(&heavy, &light)[1]);
}

/// A report; its numbers are found by the words after them.
struct Report(String);

impl Report {
    fn all(lines: &[String]) -> Vec<Self> {
        let reports = lines.iter().filter(|line| line.contains("bytes of device memory"));
        reports.map(|line| Self(line.replace(['(', ')', ':'], ""))).collect()
    }

    fn get(&self, words: &str) -> Option<f64> {
        let before = self.0.split(words).next().filter(|before| before.len() < self.0.len())?;
        before.trim_end().rsplit(' ').next()?.parse().ok()
    }

    #[track_caller]
    fn number(&self, words: &str) -> f64 {
        self.get(words).unwrap_or_else(|| panic!("{words}: {}", self.0))
    }
}

/// A report's times must be those of its frames: larger maps must lengthen passes, a script's waits must lengthen the time to the next
/// frame but not the host's part, and frames that draw nothing must have no passes.
#[test]
fn a_report_has_the_pace_of_frames() {
    if crate::support::is_long("a_report_has_the_pace_of_frames") {
        return;
    }
    let Some(screen) = screen("a_report_has_the_pace_of_frames") else { return };
    let folder = folder();
    let turning = |wait: u32| format!("orbit 0.02 0\nframes 1\nwait {wait}\n").repeat(5);
    let script = format!(
        "frames 3\nreport\n{}frames 3\nreport\nset a.size 512\nframes 4\nreport\nset runs on\nframes 10\nreport\nset extinction 0.5\n\
         frames 1\nset extinction 0.6\nframes 1\nset extinction 0.7\nframes 4\nreport\nset runs off\n{}frames 3\nreport\nquit\n",
        turning(0),
        turning(300)
    );
    let start = Instant::now();
    let output =
        view(&screen, folder.path(), &["plume_8k", "--technique", "avsm:size=32", "--picture", "64x48"], &script);
    let open_ms = start.elapsed().as_secs_f64() * 1e3;
    let reports = Report::all(&lines(&output));
    reports.iter().for_each(|report| println!("{}", report.0));
    let [_, turned, _, still, built, waited] = &reports[..] else { panic!("{}", reports.len()) };
    let [host, passes, next] = ["ms of the host", "ms of passes", "ms to the next frame"];
    assert!(built.number(passes) > 2.0 * turned.number(passes), "256 times the texels");
    assert!(
        still.get(passes).is_none() && still.number("builds") < built.number("builds"),
        "time alone moves no still scene"
    );
    assert!(waited.number(next) >= 300.0 && turned.number(next) < 300.0 && waited.number(host) < 300.0);
    for report in [turned, built, waited] {
        assert!(
            0.0 < report.number(host) && report.number(host) <= report.number(next) && report.number(next) <= open_ms
        );
    }
}

/// Unchanged parts must not be rebuilt: running time must rebuild a moving scene in every frame, and a static one never.
#[test]
fn what_stands_still_is_not_built_again() {
    if crate::support::is_costly("what_stands_still_is_not_built_again") {
        return;
    }
    let Some(screen) = screen("what_stands_still_is_not_built_again") else { return };
    let folder = folder();
    let scene =
        |name: &str| format!("set runs off\nset scene {name}\nframes 8\nreport\nset runs on\nframes 12\nreport\n");
    let script = format!("{}{}{}quit\n", scene("plume_8k"), scene("three-emitters"), scene("fountain:particles=300"));
    let output =
        view(&screen, folder.path(), &[&["plume_8k", "--technique", "avsm:size=32"], &SMALL[..]].concat(), &script);
    let builds: Vec<f64> = Report::all(&lines(&output)).iter().map(|report| report.number("builds")).collect();
    println!("{builds:?}");
    let more = |i: usize| builds[2 * i + 1] - builds[2 * i];
    assert!(more(0) == 0.0 && more(1) >= 12.0 && more(2) >= 12.0, "{builds:?}");
}

/// However slow the reference, one worker must compute the latest request on its own few threads, while frames continue.
#[test]
fn a_slow_reference_keeps_no_frame_waiting() {
    if crate::support::is_long("a_slow_reference_keeps_no_frame_waiting") {
        return;
    }
    let Some(screen) = screen("a_slow_reference_keeps_no_frame_waiting") else { return };
    let folder = folder();
    // A reference that takes a second per row, during this many frames.
    let turning = "orbit 0.05 0\nframes 1\n".repeat(60);
    std::fs::write(
        folder.path().join("script"),
        format!("set show difference\nframes 2\nreport\n{turning}report\nquit\n"),
    )
    .expect("written");
    let mut command = gobo();
    command
        .args(["--test-hooks", "view", "plume_8k", "--technique", "avsm:size=32"])
        .args(SMALL)
        .args(["--script", "script"]);
    command.current_dir(folder.path()).env("DISPLAY", &screen.display).env("GOBO_TEST_SLOW_TRUTH", "1000");
    let start = Instant::now();
    let child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("it starts");
    let tasks = PathBuf::from(format!("/proc/{}/task", child.id()));
    let watch = std::thread::spawn(move || {
        let mut most = 0;
        while let Ok(threads) = std::fs::read_dir(&tasks) {
            let names = threads.flatten().filter_map(|thread| std::fs::read_to_string(thread.path().join("comm")).ok());
            let count = names.filter(|name| name.starts_with("truth")).count();
            if most > 0 && count == 0 {
                break;
            }
            most = most.max(count);
            std::thread::sleep(Duration::from_millis(20));
        }
        most
    });
    let output = child.wait_with_output().expect("it ends");
    let open_s = start.elapsed().as_secs_f64();
    let threads = watch.join().expect("it watched");
    let reports = Report::all(&lines(&output));
    println!("{threads} threads, {open_s} s, {}", reports[1].0);
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    assert!((1..=cores.max(2)).contains(&threads), "{threads} threads on {cores} cores");
    let [begun, finished, dropped] = ["begun", "finished", "dropped"].map(|what| reports[1].number(what));
    assert!(begun >= 1.0 && begun <= open_s + 1.0 && finished == 0.0 && begun - dropped <= 1.0, "{}", reports[1].0);
    // The time of the device itself depends on the machine's load.
    let [next, passes] = ["ms to the next frame", "ms of passes"].map(|what| reports[1].number(what));
    assert!(next - passes < 500.0, "{}", reports[1].0);
}

/// A GIF must contain the window: the picture, and the panel beside it.
#[test]
fn a_gif_has_the_window() {
    if crate::support::is_costly("a_gif_has_the_window") {
        return;
    }
    let Some(screen) = screen("a_gif_has_the_window") else { return };
    let folder = folder();
    let script = "screenshot a.png\ngif a.gif 100\nset extinction 0.1\nscreenshot b.png\ngif a.gif 300\nquit\n";
    let specs = ["--technique", "avsm:size=32", "--validation"];
    lines(&view(&screen, folder.path(), &[&["plume_8k"], &specs[..], &SMALL].concat(), script));
    let file = BufReader::new(File::open(folder.path().join("a.gif")).expect("written"));
    let frames = GifDecoder::new(file).expect("a GIF").into_frames().collect_frames().expect("frames");
    let times: Vec<u32> = frames.iter().map(|frame| frame.delay().numer_denom_ms().0).collect();
    assert_eq!(times, [100, 300]);
    let shots = ["a.png", "b.png"].map(|name| pixels(&folder.path().join(name)).1);
    // Mean difference between the left of the window and a picture: a GIF has 256 colors.
    let apart = |frame: usize, shot: usize| {
        let image = frames[frame].buffer();
        assert_eq!(image.height(), 120);
        let far = |i: usize| {
            let pixel = image.get_pixel((i / 3 % 200) as u32, (i / 3 / 200) as u32);
            f64::from(pixel.0[i % 3].abs_diff(shots[shot][i]))
        };
        (0..shots[shot].len()).map(far).sum::<f64>() / shots[shot].len() as f64
    };
    let all = [[apart(0, 0), apart(0, 1)], [apart(1, 0), apart(1, 1)]];
    println!("{all:?}");
    assert!(all[0][0] < 3.0 && all[1][1] < 3.0, "{all:?}");
    assert!(all[0][1] > 2.0 * all[0][0] && all[1][0] > 2.0 * all[1][1], "{all:?}");
    // The panel has letters: light on dark.
    let panel = frames[0].buffer();
    let light = (210..panel.width()).flat_map(|x| (0..120).map(move |y| panel.get_pixel(x, y).0[1]));
    assert!(panel.width() > 400 && light.clone().max() > Some(120) && light.min() < Some(60));
}

/// A view that the reference or a spec does not support must give a line, and no script may wait for it.
#[test]
fn what_has_no_answer_is_not_waited_for() {
    if crate::support::is_costly("what_has_no_answer_is_not_waited_for") {
        return;
    }
    let Some(screen) = screen("what_has_no_answer_is_not_waited_for") else { return };
    let folder = folder();
    let script = "screenshot before.png\nset show wireframe\nscreenshot a.png\nset show slice\nset a reference\nscreenshot b.png\n\
                  set a avsm:size=32\nset show a\nscreenshot after.png\nquit\n";
    let specs = ["--technique", "avsm:size=32"];
    lines(&view(&screen, folder.path(), &[&["plume_8k"], &specs[..], &SMALL].concat(), script));
    let [before, a, after] = ["before", "a", "after"].map(|name| pixels(&folder.path().join(format!("{name}.png"))).1);
    assert!(before == after && before != a, "a picture is a picture again");
    assert!(a.iter().all(|byte| *byte == a[0]), "avsm that is lit per pixel has no triangles");
}

/// A wipe must show A's pixels left of its line and B's right of it; a difference picture must show the difference of A and B, times the
/// gain.
#[test]
fn pictures_stand_side_by_side() {
    if crate::support::is_costly("pictures_stand_side_by_side") {
        return;
    }
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
    let made = made(folder.path(), "gobo render plume_8k --plain --technique reference --picture 200x120");
    assert_eq!(truth, pixels(&made).1, "the reference fills in to what render makes");
}

/// Draws 450 frames under the validation layer, three times through everything that the window shows; memory must be the same at the end as
/// after the first time.
#[test]
fn it_goes_on_for_long() {
    if support::is_long("it_goes_on_for_long") {
        return;
    }
    let Some(screen) = screen("it_goes_on_for_long") else { return };
    let folder = folder();
    let round = |i: u32| {
        format!(
            "set scene three-emitters\nset b psm:size=32,slices=16\nset show wipe\nset runs on\nframes 40\norbit 0.2 0.1\nframes 10\nset runs off\n\
             set time 2\nset show slice\nset depth 0.3\nframes 8\nset depth 0.6\nframes 4\nset a voxel-grid:size=64\nset show steps\nframes 12\n\
             set a avsm:size=32\nset show a\nset time 20\nset curve on\nframes 5\ncurve curve.svg\nset curve off\nset look full\nframes 4\n\
             orbit 0.1 0\nframes 4\nset look plain\nset b reference\nset show difference\nframes 5\norbit 0.1 0\nframes 5\nset show a\n\
             set scene fountain:particles=300\nset runs on\nframes 25\nset attractor 1,0,2\nframes 5\nset runs off\nresize 80 60\nframes 6\n\
             resize 64 48\ndrop shafts\nframes 6\nset scene three-emitters\nset b psm:size=32,slices=16\nset show wipe\nset time 2\n\
             screenshot {i}.png\nreport\n"
        )
    };
    // Comes last: drawing lines leaves tens of megabytes behind in the driver, docs/notebook/view.md.
    let outlined = "set show wireframe\nset a avsm:size=32,lighting=vertex\nframes 20\nreport\n";
    let script = format!("set panel off\nresize 64 48\n{}{}{}{outlined}quit\n", round(0), round(1), round(2));
    let specs = ["--technique", "avsm:size=32", "--against", "psm:size=32,slices=16"];
    let small = ["--picture", "64x48", "--validation"];
    let lines = lines(&view(&screen, folder.path(), &[&["three-emitters"], &specs[..], &small].concat(), &script));
    let [first, second, last, wireframe] = &Report::all(&lines)[..] else { panic!("{lines:#?}") };
    println!("{}\n{}\n{}\n{}", first.0, second.0, last.0, wireframe.0);
    assert!(wireframe.number("frames") >= 300.0, "{}", wireframe.0);
    // The interface's buffers grow with its words, so bytes may change by some hundreds between rounds, but not grow twice. A buffer of 4
    // bytes leaked in each frame would exceed this in both.
    let [early, late] = [(first, second), (second, last)]
        .map(|(before, after)| after.number("bytes of device") - before.number("bytes of device"));
    assert!(early.min(late) < 600.0, "{}\n{}\n{}", first.0, second.0, last.0);
    // Resident memory includes freed blocks that the heap retains, and grows with each round: docs/notebook/view.md. Memory in use does
    // not.
    let grown = |what: &str| Some(second.get(what)? / first.get(what)? - 1.0);
    let [heap, resident] = ["bytes of the heap", "bytes resident"].map(grown);
    assert!(
        heap.is_none_or(|share| share < 0.01) && resident.is_none_or(|share| share < 0.08),
        "{heap:?} {resident:?}"
    );
    let [first, last] = ["0.png", "2.png"].map(|name| pixels(&folder.path().join(name)));
    assert!(first == last, "the same state is the same picture, whatever was before");
}
