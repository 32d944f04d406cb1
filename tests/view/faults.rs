//! Errors in the window: each gives a line, and the window continues or closes.

use crate::*;

/// An impossible request must give a line, and the window must continue unchanged.
#[test]
fn what_goes_wrong_is_a_line() {
    if crate::support::is_costly("what_goes_wrong_is_a_line") {
        return;
    }
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

/// Same as [`view`], but with a call that fails.
fn lost(screen: &Screen, folder: &Path, fault: &str, script: &str) -> Output {
    std::fs::write(folder.join("script"), script).expect("written");
    let mut command = gobo();
    command.args(["--test-hooks", "view", "plume_8k", "--technique", "avsm:size=32"]).args(SMALL);
    command.args(["--script", "script"]).current_dir(folder);
    command.env("DISPLAY", &screen.display).env("GOBO_TEST_FAULT", fault).output().expect("it starts")
}

/// A lost device must give a line, and the window must continue on a new one in the same state, whatever was in progress.
#[test]
fn a_lost_device_is_opened_anew() {
    if crate::support::is_long("a_lost_device_is_opened_anew") {
        return;
    }
    let Some(screen) = screen("a_lost_device_is_opened_anew") else { return };
    let folder = folder();
    let script =
        |name: &str| format!("orbit 0.3 0.1\nframes 4\nset a.nodes 4\nscreenshot {name}.png\nframes 3\nquit\n");
    let mut shots = Vec::new();
    for (fault, losses) in [("submission:0", 0), ("submission:3", 1), ("submission:6", 1), ("submission:8", 1)] {
        let output = lost(&screen, folder.path(), fault, &script("shot"));
        let error = String::from_utf8_lossy(&output.stderr).into_owned();
        let error: Vec<_> = error.lines().filter(|line| !line.starts_with("GOBO_TEST_FAULT")).collect();
        assert!(output.status.success() && error.len() == losses, "{fault}: {error:?}");
        assert!(
            error.iter().all(|line| line.contains("opened anew") && line.contains("ERROR_DEVICE_LOST")),
            "{error:?}"
        );
        shots.push(pixels(&folder.path().join("shot.png")));
    }
    assert!(shots.iter().all(|shot| *shot == shots[0]));
}

/// A fatal error must give one line and a failure.
#[test]
fn what_ends_it_is_one_line() {
    if crate::support::is_costly("what_ends_it_is_one_line") {
        return;
    }
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
    // A device that is lost repeatedly.
    let output = lost(&screen, folder.path(), "submission:5+", "frames 50\nquit\n");
    let error = String::from_utf8_lossy(&output.stderr).into_owned();
    let error: Vec<_> = error.lines().filter(|line| !line.starts_with("GOBO_TEST_FAULT")).collect();
    assert!(!output.status.success() && error.len() == 4, "{error:?}");
    assert!(error[..3].iter().all(|line| line.contains("opened anew")), "{error:?}");
    assert!(error[3].contains("ERROR_DEVICE_LOST") && error[3].contains("gobo devices"), "{error:?}");
    let mut nowhere = gobo();
    nowhere.args(["view", "plume_8k"]).env_remove("DISPLAY").current_dir(folder.path());
    fails(nowhere.output().expect("it starts"), &["a window", "display"]);
}
