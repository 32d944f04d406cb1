//! Runs examples/minimal.rs as a program of its own.

use crate::support::log;
use std::process::Command;

mod example {
    include!("../../examples/minimal.rs");

    /// Started by the test below.
    #[test]
    #[ignore = "sees_the_closed_form starts it"]
    fn runs() {
        main().expect("the light has its closed form");
    }
}

/// The light must match its closed form, and the validation layer, which prints unless there is a callback, must print nothing.
#[test]
fn sees_the_closed_form() {
    let this = std::env::args().next().expect("this program");
    // The libraries of the lavapipe with interlock are meant for programs that GOBO_RUNNER starts.
    let mut command = match std::env::var_os("GOBO_RUNNER").filter(|runner| !runner.is_empty()) {
        Some(runner) => {
            let mut command = Command::new(runner);
            command.arg(this);
            command
        }
        None => Command::new(this),
    };
    let output = command
        .args(["--exact", "minimal::example::runs", "--ignored", "--nocapture"])
        .env("VK_INSTANCE_LAYERS", "VK_LAYER_KHRONOS_validation")
        .env("VK_LAYER_ENABLES", "VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT")
        .env("VK_LOADER_DEBUG", "layer")
        .output()
        .expect("it starts");
    let [said, loader] = [output.stdout, output.stderr].map(|bytes| String::from_utf8_lossy(&bytes).into_owned());
    assert!(output.status.success(), "{said}{loader}");
    assert!(said.contains("of the sun's light"), "{said}");
    assert!(loader.contains("VK_LAYER_KHRONOS_validation"), "the layer is not loaded: {loader}");
    let is_message = |line: &&str| ["Validation", "VUID", "SYNC-"].iter().any(|word| line.contains(word));
    assert_eq!(said.lines().filter(is_message).collect::<Vec<_>>(), [""; 0]);
    log("exercised", "sees_the_closed_form", "the first device that has what AVSM needs");
}
