//! Moving worlds: `compare`, `render` and `slice` with `--moving`.

use crate::support::{is_long, log, skipped, some_usual};
use crate::{decodes, folder, ok, results, run, runs, small_scene, text, write_scene};
use gobo::bench::Status;

/// The scene grows from a hundred particles to several hundred. A build whose buffers start too small must lose nothing: lists of all
/// segments must have next to no error at map points at any time.
#[test]
fn compare_moves() {
    log("exercised", "compare_moves", &runs("avsm", "binned").0);
    let out = folder();
    let moving = ["compare", "three-emitters", "--moving", "0.4..4", "--frames", "6", "--quick", "--validation"];
    let moving = moving.into_iter().chain(["--picture", "96x54"]);
    // A path that draws in depth order and that the device supports.
    let by_depth = ["interlock", "raster-order"].into_iter().find(|path| runs("avsm", path).1);
    let two_pass = ["two-pass"].into_iter().filter(|path| runs("avsm", path).1);
    let paths = ["binned"].into_iter().chain(two_pass).chain(by_depth);
    // With four nodes, all devices have enough attachments for raster-order.
    let mut specs: Vec<_> = paths.map(|path| format!("avsm:path={path},nodes=4,size=32")).collect();
    specs.extend(runs("uncompressed", "list").1.then(|| "uncompressed:size=32".to_owned()));
    let techniques = specs.iter().flat_map(|spec| ["--technique", spec]);
    ok(&moving.chain(techniques).chain(["--out", text(out.path())]).collect::<Vec<_>>());
    let results = results(out.path());
    assert_eq!(results.rows.len(), specs.len());
    let timed = results.device.features["timestamp_valid_bits"] != 0;
    for row in &results.rows {
        assert_eq!(row.status, Status::Ok, "{}", row.reason);
        let passes: Vec<_> = row.passes.iter().map(|p| p.name.as_str()).collect();
        if timed {
            assert_eq!(passes[..4], ["world.move", "maps.aim", "maps.bounds", "maps.fit"], "{}", row.spec());
            let drawn_by_depth = Some(row.path.as_str()) == by_depth;
            assert_eq!(passes.contains(&"order.scatter"), drawn_by_depth, "{passes:?}");
            assert_eq!(row.build_ns.expect("timed").samples, 6);
        }
        assert!(row.flicker_rms.is_some_and(|f| f > 0.0 && f < 0.05), "{:?}", row.flicker_rms);
        let error = row.error.as_ref().expect("measured");
        let [map, surface] = [error.map, error.surface].map(|e| e.expect("points"));
        assert!(map.within.is_some() && surface.mean_abs < 0.05, "{error:?}");
        if row.path == "list" {
            let beyond = map.beyond().and_then(|beyond| beyond.mean_abs).expect("most points");
            assert!(beyond < 1e-5, "{map:?}");
        }
    }
}

/// While the camera turns, large maps must flicker less than small ones, apart from edges of the ground, which flicker with both. A static
/// camera must see no flicker.
#[test]
fn compare_turns_the_camera() {
    if is_long("compare_turns_the_camera") {
        return;
    }
    log("exercised", "compare_turns_the_camera", &runs("avsm", "binned").0);
    let out = folder();
    let small = small_scene(out.path());
    let turned = |degrees: &str| {
        let scene = ["compare", text(&small), "--frames", "4", "--quick", "--picture", "80x45"];
        let specs = ["--technique", "avsm:path=binned,size=4|128,shading=deferred"];
        ok(&[&scene[..], &["--turn", degrees], &specs, &["--out", text(out.path()), "--validation"]].concat());
        let rows = results(out.path()).rows;
        rows.iter().map(|row| row.frames.unwrap_or_else(|| panic!("{}", row.reason))).collect::<Vec<_>>()
    };
    let [coarse, fine] = turned("6")[..] else { panic!("two rows") };
    assert!(fine.flicker_rms > 0.0 && fine.flicker_rms < coarse.flicker_rms, "{fine:?}, {coarse:?}");
    assert!(2.0 * fine.rmse < coarse.rmse, "{fine:?}, {coarse:?}");
    assert!(turned("0").iter().all(|still| still.flicker_rms == 0.0 && still.rmse > 0.0));
}

/// Rows must be measured and drawn with the particles that the device simulates, and their truth must come from the host's twin.
#[test]
fn compare_simulates() {
    if crate::support::is_costly("compare_simulates") {
        return;
    }
    log("exercised", "compare_simulates", &runs("avsm", "binned").0);
    for truth in some_usual([true, false]) {
        let out = folder();
        let moving = ["compare", "fountain:particles=700", "--moving", "20..20.2", "--frames", "5", "--quick"];
        let rest = [
            "--validation",
            "--technique",
            "avsm:path=binned,size=64",
            "--passes",
            "--picture",
            "96x54",
            "--out",
            text(out.path()),
        ];
        let no_truth = ["--no-truth"].into_iter().filter(|_| !truth);
        let printed = ok(&moving.into_iter().chain(rest).chain(no_truth).collect::<Vec<_>>());
        let mut results = results(out.path());
        let timed = results.device.features["timestamp_valid_bits"] != 0;
        let row = results.rows.remove(0);
        assert_eq!((row.status, row.scene.as_str()), (Status::Ok, "fountain-700"), "{}", row.reason);
        decodes(&out.path().join("fountain-700-01-avsm.png"), [96, 54]);
        if timed {
            let passes: Vec<_> = row.passes.iter().map(|p| p.name.as_str()).collect();
            assert_eq!(passes[..4], ["simulate.step", "maps.aim", "maps.bounds", "maps.fit"]);
            assert_eq!(passes.last(), Some(&"avsm.cells"));
            let drawn: Vec<_> = row.draw_passes.iter().map(|p| p.name.as_str()).collect();
            assert_eq!(
                drawn,
                ["shading.forward", "shading.points"],
                "a frame blends nothing in an order of the host's"
            );
            assert!(passes.iter().chain(&drawn).all(|name| printed.contains(name)), "{printed}");
            let sum: f64 = row.draw_passes.iter().map(|p| p.p05_ns).sum();
            assert!(0.0 < sum && sum <= row.draw_ns.expect("timed").p95 * 1.001, "{:?}", row.draw_passes);
        }
        assert_eq!((row.flicker_rms.is_some(), row.error.is_some()), (truth, truth));
        if let Some(error) = &row.error {
            let map = error.map.expect("points");
            assert!(map.mean_abs < 0.005 && row.flicker_rms.is_some_and(|f| f < 0.05), "{map:?}");
        }
    }
}

/// Pictures of particles must depend on the time only, not on the steps that led there.
#[test]
fn render_draws_simulated_particles() {
    if crate::support::is_costly("render_draws_simulated_particles") {
        return;
    }
    log("exercised", "render_draws_simulated_particles", &runs("avsm", "binned").0);
    let folder = folder();
    let scene = ["render", "fountain:particles=900", "--picture", "96x54", "--validation"];
    let drawn = ["--technique", "avsm:path=binned,size=32", "--particles"];
    let mut written = Vec::new();
    for colors in some_usual(["speed", "density"]) {
        let path = |name: &str| folder.path().join(format!("{colors}{name}"));
        let out = path(".png");
        let moving = ["--moving", "1..2", "--frames", "3", "--out", text(&out)];
        ok(&[&scene[..], &drawn, &[colors], &moving].concat());
        for (frame, time) in ["1", "1.5", "2"].into_iter().enumerate() {
            let alone = path(&format!("-alone-{frame}.png"));
            ok(&[&scene[..], &drawn, &[colors, "--time", time, "--out", text(&alone)]].concat());
            let [moved, alone] = [path(&format!("-{frame}.png")), alone].map(|p| std::fs::read(p).expect("written"));
            assert!(moved == alone, "{colors}, {time} s");
            written.push(alone);
        }
    }
    let count = written.len();
    written.sort();
    written.dedup();
    assert_eq!(written.len(), count, "each is another picture");
}

#[test]
fn times_alone_have_no_errors() {
    log("exercised", "times_alone_have_no_errors", &runs("avsm", "binned").0);
    let out = folder();
    let arguments = [
        "compare",
        "big-8k",
        "--no-truth",
        "--quick",
        "--picture",
        "96x54",
        "--technique",
        "avsm:path=binned,size=16",
        "--out",
    ];
    ok(&[&arguments[..], &[text(out.path())]].concat());
    let mut results = results(out.path());
    let timed = results.device.features["timestamp_valid_bits"] != 0;
    let row = results.rows.remove(0);
    assert_eq!(row.status, Status::Ok, "{}", row.reason);
    let times = [row.build_ns.is_some(), row.lookup_ns_per_million.is_some(), row.draw_ns.is_some()];
    assert_eq!(times, [timed; 3]);
    assert!(
        row.error.is_none() && row.limit_mean_abs.is_none() && row.flicker_rms.is_none() && row.difference.is_none()
    );
}

/// Each frame must be the picture at its own time, the animation must contain all of them, and the output must name the files written.
#[test]
fn render_and_slice_write_sequences() {
    if crate::support::is_costly("render_and_slice_write_sequences") {
        return;
    }
    use image::AnimationDecoder;
    log("exercised", "render_and_slice_write_sequences", &runs("avsm", "two-pass").0);
    let folder = folder();
    let size = ["--picture", "96x54", "--technique", "avsm:size=32"];
    for (command, size) in [("render", &size[..]), ("slice", &["--picture", "32x32", "--technique", "avsm:size=32"])] {
        let path = |name: String| folder.path().join(format!("{command}{name}"));
        let out = path(".png".into());
        let moving = [command, "three-emitters", "--moving", "1..2", "--frames", "3", "--out", text(&out)];
        let printed = ok(&[&moving[..], size].concat());
        let [first, last, animation] = ["-0.png", "-2.png", ".gif"].map(|end| path(end.into()));
        let written = format!("{} … {}, {}: avsm", first.display(), last.display(), animation.display());
        assert!(printed.starts_with(&written) && !out.exists(), "{command}: {printed}");
        for (frame, time) in ["1", "1.5", "2"].into_iter().enumerate() {
            let alone = path(format!("-alone-{frame}.png"));
            let printed = ok(&[&[command, "three-emitters", "--time", time, "--out", text(&alone)][..], size].concat());
            assert!(printed.starts_with(&format!("{}: avsm", text(&alone))), "{command}: {printed}");
            let [moved, alone] = [path(format!("-{frame}.png")), alone].map(|p| std::fs::read(p).expect("written"));
            assert!(moved == alone, "{command}, {time} s");
        }
        let gif = std::fs::File::open(path(".gif".into())).expect("an animation");
        let frames = image::codecs::gif::GifDecoder::new(std::io::BufReader::new(gif)).expect("a GIF").into_frames();
        assert_eq!(frames.count(), 3, "{command}");
    }
    decodes(&folder.path().join("render-0.png"), [96, 54]);
}

/// A sequence of files must be drawn and measured as each of its files alone.
#[test]
fn files_are_frames() {
    if crate::support::is_costly("files_are_frames") {
        return;
    }
    log("exercised", "files_are_frames", &runs("avsm", "binned").0);
    let folder = folder();
    for number in 0..3 {
        let rows = (0..4 + number)
            .map(|i| format!("{} 0 {} 0.5 1.2", 0.4 * f64::from(i) - 0.6, 1.0 + 0.3 * f64::from(number)));
        write_scene(folder.path(), &format!("puff.{number:02}"), &rows.collect::<Vec<_>>());
    }
    let one = std::fs::read_to_string(folder.path().join("puff.00.toml")).expect("written");
    let all = folder.path().join("puff.toml");
    std::fs::write(&all, one.replace("puff.00.ply", "puff.##.ply")).expect("write");
    let path = |name: &str| folder.path().join(name);
    let size = ["--picture", "64x36", "--technique", "avsm:path=binned,size=32", "--out"];
    let moving = ["render", text(&all), "--moving", "0.01..0.1", "--frames", "3"];
    ok(&[&moving[..], &size, &[text(&path("all.png"))]].concat());
    let mut pictures = Vec::new();
    for number in 0..3 {
        let (scene, out) = (path(&format!("puff.{number:02}.toml")), path(&format!("alone-{number}.png")));
        ok(&[&["render", text(&scene)][..], &size, &[text(&out)]].concat());
        let [of_all, alone] = [path(&format!("all-{number}.png")), out].map(|p| std::fs::read(p).expect("written"));
        assert!(of_all == alone, "frame {number}");
        pictures.push(alone);
    }
    pictures.dedup();
    assert_eq!(pictures.len(), 3, "each is another picture");
    let compared = [
        "compare",
        text(&all),
        "--moving",
        "0.01..0.1",
        "--frames",
        "3",
        "--quick",
        "--picture",
        "64x36",
        "--validation",
    ];
    ok(&[&compared[..], &["--technique", "avsm:path=binned,size=32", "--out", text(&path("out"))]].concat());
    let row = results(&path("out")).rows.remove(0);
    assert_eq!((row.status, row.scene.as_str()), (Status::Ok, "puff"), "{}", row.reason);
    assert!(row.flicker_rms.is_some_and(|flicker| flicker > 0.0), "{:?}", row.flicker_rms);
}

/// Writes a scene with a ground below the volume of a file written by results/files/vdb.py, or below a sequence of such files, and returns
/// its path.
fn puff(folder: &std::path::Path, of: &str) -> std::path::PathBuf {
    write_scene(folder, "none", &[]);
    let ground = std::fs::read_to_string(folder.join("none.toml")).expect("written");
    let (_, rest) = ground.split_once("[[meshes]]").expect("a ground");
    let seeds = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("fuzz/seeds/vdb");
    for number in 1..=3 {
        for (from, to) in [(number, "rising"), (2, "same")] {
            let from = seeds.join(format!("ok-frame-{from}.vdb"));
            std::fs::copy(from, folder.join(format!("{to}.{number:02}.vdb"))).expect("copied");
        }
    }
    let volumes = format!("[[volumes]]\nfile = \"{of}\"\nextinction = 2.0\ntranslate = [-1, 0, 0.8]\n[[meshes]]{rest}");
    let path = folder.join(format!("{}.toml", of.trim_end_matches(".vdb").replace('#', "x")));
    std::fs::write(&path, volumes).expect("write the scene");
    path
}

/// A sequence of volumes must be drawn and sliced as each of its files alone.
#[test]
fn volumes_of_files_are_frames() {
    if crate::support::is_long("volumes_of_files_are_frames") {
        return;
    }
    log("exercised", "volumes_of_files_are_frames", &runs("avsm", "binned").0);
    let folder = folder();
    let all = puff(folder.path(), "rising.##.vdb");
    let path = |name: &str| folder.path().join(name);
    let technique = ["--technique", "avsm:path=binned,size=32", "--out"];
    for (command, size) in [("render", &["--picture", "64x36"][..]), ("slice", &["--picture", "32x32"])] {
        let moving = [command, text(&all), "--moving", "0.01..0.1", "--frames", "3"];
        ok(&[&moving[..], size, &technique, &[text(&path(&format!("{command}.png")))]].concat());
        let mut pictures = Vec::new();
        for number in 0..3 {
            let scene = puff(folder.path(), &format!("rising.{:02}.vdb", number + 1));
            let out = path(&format!("{command}-alone-{number}.png"));
            ok(&[&[command, text(&scene)][..], size, &technique, &[text(&out)]].concat());
            let of_all = path(&format!("{command}-{number}.png"));
            let [of_all, alone] = [of_all, out].map(|p| std::fs::read(p).expect("written"));
            // A slice's depth is a fraction of the light's depth range over all casters of that frame.
            assert!(of_all == alone, "{command}, frame {number}");
            pictures.push(alone);
        }
        pictures.dedup();
        assert_eq!(pictures.len(), 3, "{command}: each is another picture");
    }
    let error = run(&["render", text(&all), "--moving", "0..0.1", "--technique", "avsm", "--frames", "1"]);
    let words = String::from_utf8_lossy(&error.stderr).into_owned();
    assert!(!error.status.success() && words.contains("--frames"), "{words}");
}

/// Flicker is the change of a technique's answers that the truth does not share: it must be zero if all frames are the same file, largest
/// without shadows, and smaller for more accurate techniques.
#[test]
fn volumes_of_files_flicker() {
    if is_long("volumes_of_files_flicker") {
        return;
    }
    log("exercised", "volumes_of_files_flicker", &runs("avsm", "binned").0);
    let folder = folder();
    let specs = ["none", "avsm:path=binned,size=8", "grid-query"];
    let flicker = |of: &str| {
        let (scene, out) = (puff(folder.path(), of), folder.path().join("out"));
        let moving = ["compare", text(&scene), "--moving", "0.01..0.1", "--frames", "3", "--quick", "--validation"];
        let techniques = specs.iter().flat_map(|spec| ["--technique", spec]).collect::<Vec<_>>();
        ok(&[&moving[..], &techniques, &["--out", text(&out)]].concat());
        let mut rows = results(&out).rows;
        // With cells, grid-query needs more buffers than the smallest device supports.
        if rows[2].status == Status::Refused {
            skipped("volumes_of_files_flicker", &format!("grid-query: {}", rows[2].reason));
            rows.truncate(2);
        }
        assert!(rows.iter().all(|row| row.status == Status::Ok), "{rows:?}");
        let errors = rows.iter().map(|row| row.error.as_ref().and_then(|e| e.space).expect("points"));
        let all: Vec<_> = errors.zip(rows.iter().map(|row| row.flicker_rms.expect("it moves"))).collect();
        println!("{of}: {:?}", all.iter().map(|(error, flicker)| (error.rms, *flicker)).collect::<Vec<_>>());
        all
    };
    let rising = flicker("rising.##.vdb");
    assert!(rising.windows(2).all(|pair| pair[1].1 < pair[0].1), "each technique is nearer than the one before it");
    if let Some((error, of_cells)) = rising.get(2) {
        assert!(
            *of_cells <= 2.0 * error.max.expect("points") && rising[0].1 > 10.0 * of_cells,
            "{of_cells}, {error:?}"
        );
    }
    assert!(flicker("same.##.vdb").iter().all(|(_, flicker)| *flicker == 0.0), "nothing moves");
}

#[test]
fn what_cannot_move_says_so() {
    for (arguments, wanted) in [
        (["compare", "big-8k", "--moving", "1..2"], "nothing moves in it; leave --moving out"),
        (["compare", "three-emitters", "--moving", "-1..2"], "not in [0, 3600]"),
        (["render", "three-emitters", "--moving", "1..x"], "from..to in seconds"),
        (["compare", "three-emitters", "--moving", "1..5000"], "not in [0, 3600]"),
        (["compare", "fountain", "--moving", "1..5000"], "not in [0, 3600]"),
        (["compare", "big-8k", "--turn", "361"], "at most 360"),
        (["compare", "big-8k", "--picture", "0x720"], "1 to 16384 per side"),
        (["render", "lantern", "--particles", "speed"], "nothing of lantern is simulated on the device"),
    ] {
        let output = run(&arguments);
        let error = String::from_utf8_lossy(&output.stderr);
        assert!(!output.status.success() && error.contains(wanted), "{arguments:?}: {error}");
    }
}
