//! Help, manual pages and completions must cover everything that the program offers.

use crate::{folder, ok, run, text};
use std::process::Command;

/// Returns the commands listed by `gobo --help`.
fn commands() -> Vec<String> {
    let help = ok(&["--help"]);
    let listed = help.lines().skip_while(|line| *line != "Commands:").skip(1).take_while(|line| line.starts_with("  "));
    // Continuation lines of a description are indented further.
    let first = listed.filter(|line| !line.starts_with("   ")).filter_map(|line| line.split_whitespace().next());
    let all: Vec<String> = first.filter(|name| *name != "help").map(str::to_owned).collect();
    assert!(all.len() >= 11, "{help}");
    all
}

#[test]
fn no_line_of_help_is_wider_than_a_terminal() {
    for command in commands() {
        let page = ok(&["help", &command]);
        assert!(page.contains("Usage: gobo"), "{page}");
        for help in [page, ok(&[&command, "-h"]), ok(&[&command, "--help"])] {
            let wide = help.lines().find(|line| line.chars().count() > 100);
            assert!(wide.is_none(), "{command}: {}", wide.unwrap_or_default());
        }
    }
}

#[test]
fn a_technique_has_a_page() {
    let page = ok(&["help", "avsm"]);
    for word in ["interlock", "fragmentShaderPixelInterlock", "nodes", "casts from all kinds of casters"] {
        assert!(page.contains(word), "{word} is not in:\n{page}");
    }
    assert!(page.lines().all(|line| line.chars().count() <= 100), "{page}");
    // Words must express what the entry states as numbers.
    assert!(page.contains("0 leaks and false shadows beyond its resolution"), "{page}");
    for (word, meant) in
        [("avsn", "did you mean avsm?"), ("compar", "did you mean compare?"), ("xyzzy", "unrecognized")]
    {
        let unknown = run(&["help", word]);
        let said = String::from_utf8_lossy(&unknown.stderr).into_owned();
        assert!(unknown.status.code() == Some(2) && said.contains(meant), "{said}");
    }
}

/// Each command must have a manual page, and the shell must be able to read the completion script.
#[test]
fn manual_and_completions() {
    let folder = folder();
    let _ = ok(&["man", "--out", text(folder.path())]);
    let page = |name: &str| std::fs::read_to_string(folder.path().join(name)).expect("a page of the manual");
    assert!(page("gobo.1").contains(".TH"));
    for command in commands() {
        assert!(page(&format!("gobo-{command}.1")).contains(&format!("gobo {command}")), "{command}");
    }
    let script = folder.path().join("gobo.bash");
    std::fs::write(&script, ok(&["completions", "bash"])).expect("write");
    // Requests completions as the Tab key does.
    let ask = format!(
        "source {}; COMP_WORDS=(gobo comp); COMP_CWORD=1; _gobo gobo comp gobo; echo ${{COMPREPLY[@]}}",
        text(&script)
    );
    let output = Command::new("bash").args(["-c", &ask]).output().expect("bash");
    let said = String::from_utf8_lossy(&output.stdout).into_owned();
    assert_eq!(said.split_whitespace().collect::<Vec<_>>(), ["compare", "completions"], "{output:?}");
}

/// Exit statuses must be those documented in `--help`.
#[test]
fn exit_statuses() {
    assert!(ok(&["--help"]).contains("Exit status: 0"));
    for (arguments, code) in [
        (&["--version"][..], 0),
        (&["compare", "--no-such-option"], 2),
        (&["no-such-command"], 2),
        (&["help", "avsn"], 2),
        (&["help", "no-such-word"], 2),
        (&["glsl", "avsn"], 2),
        (&["compare", "no-such-scene"], 2),
        (&["compare", "big-8k:lights=0"], 2),
        (&["recommend", "no-such-scene"], 2),
        (&["recommend"], 2),
        (&["recommend", "big-8k", "--max-ms", "0"], 2),
        (&["stress", "extincton"], 2),
        (&["slice", "big-8k", "--depth", "2"], 2),
        (&["render", "big-8k", "-o", "x.jpg"], 2),
        (&["render", "fountain", "--time", "-1"], 2),
        (&["render", "big-8k", "--samples", "3"], 2),
        (&["compare", "cornell", "--vpls", "63"], 2),
        // Problems with a file, a scene or a device are not usage errors.
        (&["compare", "absent.toml"], 1),
        (&["compare", "absent.ply"], 1),
        (&["compare", "--baseline", "absent.json"], 1),
        (&["slice", "lantern", "--light", "9"], 1),
        (&["compare", "--device", "no such device"], 1),
    ] {
        assert_eq!(run(arguments).status.code(), Some(code), "{arguments:?}");
    }
    // A misspelt technique, key or value must be a usage error in every command that takes a technique.
    for spec in ["avsn", "avsm:node=4", "avsm:nodes=5"] {
        for command in [
            &["compare", "big-8k"][..],
            &["render", "big-8k"],
            &["slice", "big-8k"],
            &["curve", "big-8k", "--texel", "4,4"],
            &["map", "cornell"],
            &["bake", "town"],
            &["stress", "extinction"],
        ] {
            let output = run(&[command, &["--technique", spec]].concat());
            let said = String::from_utf8_lossy(&output.stderr).into_owned();
            assert_eq!(output.status.code(), Some(2), "{command:?} {spec}: {said}");
            assert!(said.contains(&format!("--technique {spec}")), "{command:?} {spec}: {said}");
        }
    }
}
