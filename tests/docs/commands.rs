//! Runs the commands in README.md and docs on reduced workloads (`GOBO_TEST_LITTLE`): those in code blocks, and complete commands in
//! running text. The usual loop runs a few of them, `GOBO_TEST_ALL` runs all. If the device lacks a feature, the command is skipped.

use crate::support::{self, log, skipped};
use crate::tables::{name, pages};
use std::path::Path;
use std::process::{Command, Stdio};
use std::sync::Mutex;
use std::time::Instant;

/// Placeholders in commands, and their replacements here. Longer ones come first.
const PLACEHOLDERS: [(&str, &str); 9] = [
    ("glsl NAME", "glsl avsm"),
    ("SCENE…", "cornell"),
    ("SPEC…", "voxel-grid"),
    ("MINUTES", "0"),
    ("SCENE", "cornell"),
    ("SPEC", "voxel-grid"),
    ("DIR", "folder"),
    (" N", " 64"),
    (" L", " 0"),
];

/// Files that the reader supplies, and their replacements here.
const FILES: [(&str, &str); 10] = [
    ("results.json", "results/nvidia-h200/results.json"),
    ("smoke.ply", "fuzz/seeds/ply/ok-particles-ascii.ply"),
    ("garden.splat", "fuzz/seeds/splat/ok-two.splat"),
    ("smoke.nrrd", "fuzz/seeds/nrrd/ok-bytes.nrrd"),
    ("smoke.vdb", "fuzz/seeds/vdb/ok-blosc.vdb"),
    ("smoke.0001.vdb", "fuzz/seeds/vdb/ok-frame-1.vdb"),
    ("smoke.0002.vdb", "fuzz/seeds/vdb/ok-frame-2.vdb"),
    ("smoke.0003.vdb", "fuzz/seeds/vdb/ok-frame-3.vdb"),
    ("head.tfx", "fuzz/seeds/tressfx/ok-version-4.tfx"),
    ("town.glb", "fuzz/seeds/gltf/ok-binary.glb"),
];

/// Commands that need a scene; without one they are only mentioned.
const OF_A_SCENE: [&str; 6] = ["render", "slice", "curve", "map", "bake", "voxels"];

/// The usual loop runs one in this many commands.
const STRIDE: usize = 13;

/// Device limitations that are not named after a Vulkan feature.
const OF_DEVICES: [&str; 5] = [
    "blending into 32-bit floats",
    "bytes of memory",
    "has room for a map",
    "more rounds of a shader's loops",
    "this device has",
];

/// Pages that explain why a row of their command is refused on every device, and words from that refusal.
const SHOWN: [(&str, &str); 2] =
    [("docs/notebook/opaque.md", "virtual point lights"), ("docs/notebook/opaque.md", "directional lights alone")];

/// Returns every reason after `refused: needs ` in a command's output.
fn refusals(said: &str) -> impl Iterator<Item = &str> {
    said.lines().filter_map(|line| Some(line.split_once("refused: needs ")?.1.trim()))
}

/// Whether the device is the cause: the reason names a Vulkan feature or limit, such as `rayQuery`, or a limitation in [`OF_DEVICES`].
fn is_of_device(needs: &str) -> bool {
    let word: String = needs.chars().take_while(char::is_ascii_alphanumeric).collect();
    let is_name = word.starts_with(|c: char| c.is_ascii_lowercase()) && word.chars().any(|c| c.is_ascii_uppercase());
    is_name || OF_DEVICES.iter().any(|words| needs.contains(words))
}

#[test]
fn only_what_a_device_lacks_is_left_out() {
    let printed =
        "x\nray-query  refused: needs rayQuery\nerror: refused: needs meshes in the scene, and hair has none\n";
    let all: Vec<_> = refusals(printed).collect();
    assert_eq!(all, ["rayQuery", "meshes in the scene, and hair has none"]);
    assert_eq!(all.iter().map(|needs| is_of_device(needs)).collect::<Vec<_>>(), [true, false]);
    let of_a_device = ["maxImageDimension2D of 65536 for x (this device has 16384)", "shaderOutputLayer and more"];
    assert!(of_a_device.into_iter().all(is_of_device));
    let others = ["path=binned, for front=weighted", "a scene that the host knows", "lights that the host knows"];
    assert!(!others.into_iter().any(is_of_device));
}

/// A command in a page.
struct Found {
    page: String,
    /// Shell variables that the page sets before this command.
    set: String,
    text: String,
}

/// Returns all commands without comments and line breaks, and separately those that describe syntax with brackets.
fn found(root: &Path) -> (Vec<Found>, Vec<Found>) {
    let mut all = Vec::new();
    for page in pages(root) {
        let text = std::fs::read_to_string(&page).expect("a page").replace("\\\n", " ");
        let page = name(root, &page);
        let (mut set, mut running) = (String::new(), String::new());
        for line in text.lines() {
            let Some(code) = line.strip_prefix("    ") else {
                running += &format!("{line}\n");
                continue;
            };
            let code = code.split(" #").next().unwrap_or_default().split_whitespace().collect::<Vec<_>>().join(" ");
            if code.starts_with(|c: char| c.is_ascii_uppercase()) && code.contains('=') && !code.contains("cargo") {
                set += &format!("{code}; ");
            }
            // A prefix that starts the program, such as a driver's runner, is dropped.
            if let Some(at) = ["gobo ", "cargo run --release -- "].iter().find_map(|start| code.find(start)) {
                let text = code[at..].replace("cargo run --release -- ", "gobo ");
                all.push(Found { page: page.clone(), set: set.clone(), text });
            }
        }
        for text in
            running.split('`').skip(1).step_by(2).map(|text| text.split_whitespace().collect::<Vec<_>>().join(" "))
        {
            let words: Vec<&str> = text.split(' ').collect();
            let is_whole =
                words.len() > 1 && (words.len() > 2 && !words[2].starts_with('-') || !OF_A_SCENE.contains(&words[1]));
            if words[0] == "gobo" && is_whole {
                all.push(Found { page: page.clone(), set: set.clone(), text });
            }
        }
    }
    // Commands with brute-force are left out: another test builds that technique.
    all.retain(|found| !found.text.contains('`') && !found.text.contains("brute-force"));
    all.into_iter().partition(|found| !found.text.contains('['))
}

#[test]
fn commands_run() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let (all, syntax) = found(root);
    assert!(all.len() > 100, "{} commands: where are the others?", all.len());
    for Found { page, text, .. } in &syntax {
        let help = run(root, &format!("gobo {} --help", text.split(' ').nth(1).unwrap_or_default())).0;
        for option in text.split([' ', '[', ']']).filter(|word| word.starts_with("--")) {
            assert!(help.contains(option), "{page}: {text}: there is no {option}");
        }
    }
    let folder = tempfile::TempDir::new().expect("a temporary folder");
    for (name, seed) in FILES {
        std::fs::copy(root.join(seed), folder.path().join(name)).expect(seed);
    }
    std::os::unix::fs::symlink(root.join("fuzz"), folder.path().join("fuzz")).expect("a link to the seeds");
    // Files that commands read; none of them is written.
    for device in ["nvidia-h100", "nvidia-h200", "lavapipe-22.3", "lavapipe-26.1", "swiftshader"] {
        std::fs::create_dir_all(folder.path().join("results")).expect("a folder");
        std::os::unix::fs::symlink(root.join("results").join(device), folder.path().join("results").join(device))
            .expect("a link");
    }
    let total = all.len();
    let few = |(i, _): &(usize, &Found)| support::is_drawn(*i) || i % STRIDE == 0;
    // Some of the selected commands open a file that another must have baked.
    let opened: Vec<&str> = all
        .iter()
        .enumerate()
        .filter(few)
        .filter_map(|(_, f)| f.text.split("file=").nth(1)?.split(',').next())
        .collect();
    let bakes = |found: &Found| opened.iter().any(|file| found.text.ends_with(&format!("-o {file}")));
    let chosen: Vec<&Found> =
        all.iter().enumerate().filter(|one| few(one) || bakes(one.1)).map(|(_, found)| found).collect();
    // Starts them in order, since a command may open what the one before it has baked.
    let next = Mutex::new(chosen.iter());
    let failed = Mutex::new(Vec::new());
    std::thread::scope(|scope| {
        for _ in 0..2 {
            scope.spawn(|| {
                loop {
                    let Some(Found { page, set, text }) = next.lock().expect("no panic").next() else { break };
                    let started = Instant::now();
                    let filled = PLACEHOLDERS.iter().fold(text.clone(), |text, (what, is)| text.replace(what, is));
                    let (_, error, is_ok) = run(folder.path(), &format!("{set}{filled}"));
                    log("ran", "commands_run", &format!("{:.1} s: {page}: {text}", started.elapsed().as_secs_f64()));
                    // The page is not to blame for features missing from this build.
                    let reasons = ["rebuild with --features", "run it where there is a display"];
                    let left_out = reasons.iter().any(|reason| error.contains(reason))
                        || refusals(&error).next().is_some() && refusals(&error).all(is_of_device);
                    // A refused row by itself does not make the command fail. The table breaks reasons into lines, the log does not.
                    let is_shown = |needs: &&str| SHOWN.iter().any(|(of, words)| of == page && needs.contains(words));
                    let refused = refusals(&error).find(|needs| !is_of_device(needs) && !is_shown(needs));
                    if let Some(needs) = refused.filter(|_| is_ok) {
                        let text =
                            format!("{page}: {text}\n    a row is refused, which the page does not say: needs {needs}");
                        failed.lock().expect("no panic").push(text);
                    } else if !is_ok && left_out {
                        skipped("commands_run", &format!("{text}: {}", error.trim()));
                    } else if !is_ok {
                        failed.lock().expect("no panic").push(format!("{page}: {text}\n    {}", error.trim()));
                    }
                }
            });
        }
    });
    if chosen.len() < total {
        skipped("commands_run", &format!("{} of {total} commands, which GOBO_TEST_ALL runs", total - chosen.len()));
    }
    let failed = failed.into_inner().expect("no panic");
    println!("{total} commands, {} of syntax beside them; {} run, {} failed", syntax.len(), chosen.len(), failed.len());
    assert!(failed.is_empty(), "{} of {} failed:\n{}", failed.len(), chosen.len(), failed.join("\n"));
}

/// Runs a shell line in which `gobo` is the program; returns its standard output and error, and whether it succeeded.
pub fn run(folder: &Path, line: &str) -> (String, String, bool) {
    let runner = std::env::var("GOBO_RUNNER").unwrap_or_default();
    let script = format!("gobo() {{ {runner} {} --test-hooks \"$@\"; }}\n{line}\n", env!("CARGO_BIN_EXE_gobo"));
    let mut command = Command::new("bash");
    command.args(["-c", &script]).current_dir(folder).env("GOBO_TEST_LITTLE", "1").stdin(Stdio::null());
    let output = command.output().expect("bash starts");
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    (text(&output.stdout), text(&output.stderr), output.status.success())
}
