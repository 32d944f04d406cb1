//! Runs the bodies of the fuzz targets on their seeds and on thousands of mutations, the same ones each time. Whatever cargo-fuzz finds
//! becomes a seed. docs/reference/fuzzing.md.

mod bodies;
mod mutate;
use mutate::{Seed, mutated, seeds};
use rand_pcg::Pcg32;
use std::fs::File;
use std::io::{Seek, Write};
use std::path::Path;
use std::sync::mpsc::{self, RecvTimeoutError};
use std::time::Duration;

/// Anything slower than this is a hang, even on the slowest machine.
const PATIENCE: Duration = Duration::from_secs(60);

/// Runs a body on every seed, which it must accept or refuse according to the seed's name, and on a number of mutations. A failure names
/// the case and the file with its bytes; if the process crashes, that file contains them too.
fn fuzz(name: &'static str, body: fn(&[u8]) -> bool, mutations: u64) {
    let seeds = seeds(name);
    assert!(seeds.iter().any(|seed| seed.name.starts_with("ok-")), "{name}: none of the seeds is taken");
    let mutations = if crate::support::all() { 10 * mutations } else { mutations };
    let last = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("fuzz-{name}"));
    let (says, hears) = mpsc::channel();
    let worker = std::thread::spawn({
        let last = last.clone();
        move || {
            // One file, never truncated to nothing: file systems flush such files to disk at once.
            let mut file = File::create(&last).expect("a folder for tests to write to");
            let mut run = |case: String, bytes: &[u8]| {
                file.rewind()
                    .and_then(|()| file.write_all(bytes))
                    .and_then(|()| file.set_len(bytes.len() as u64))
                    .expect("room");
                says.send(case).expect("somebody waits");
                body(bytes)
            };
            for Seed { name, bytes } in &seeds {
                assert_eq!(run(format!("seed {name}"), bytes), name.starts_with("ok-"), "whether {name} is taken");
            }
            for number in 0..mutations {
                run(format!("mutation {number}"), &mutated(&seeds, &mut Pcg32::new(number, 0)));
            }
        }
    });
    let mut case = String::new();
    loop {
        match hears.recv_timeout(PATIENCE) {
            Ok(next) => case = next,
            Err(RecvTimeoutError::Timeout) => panic!("{name}, {case} hangs; its bytes are in {}", last.display()),
            Err(RecvTimeoutError::Disconnected) => break,
        }
    }
    assert!(worker.join().is_ok(), "{name}, {case}; its bytes are in {}", last.display());
}

macro_rules! fuzzed {
    ($($name:ident: $mutations:literal),+ $(,)?) => {
        $(
            #[test]
            fn $name() {
                fuzz(stringify!($name), bodies::$name, $mutations);
            }
        )+
    };
}

fuzzed! {
    avsm: 1000,
    bake: 1000,
    cells: 1000,
    gltf: 1000,
    hair: 1000,
    ksplat: 300,
    ply: 1000,
    psm: 1000,
    scene: 1000,
    spec: 1000,
    sog: 200,
    splat: 1000,
    spz: 1000,
    nrrd: 1000,
    nvdb: 200,
    vdb: 300,
    volume: 1000,
    tressfx: 1000,
    voxels: 100,
}
