//! The page in a browser: headless Chromium opens copies of it with an injected test script, in frames as wide as a telephone, a tablet and
//! a desktop screen, in either theme. The script writes its findings into the document, which Chromium prints.

use super::{folder, ok, small_scene, text, write_scene};
use crate::support::{is_long, log, skipped};
use serde_json::Value;
use std::path::Path;
use std::process::Command;

const WIDTHS: [u32; 3] = [420, 900, 1600];

/// Records everything that goes wrong from the page's first line on.
const HEARS: &str = r#"<script>window.heard = [];
addEventListener("error", event => heard.push(String(event.message)), true);
addEventListener("unhandledrejection", event => heard.push(String(event.reason)));
addEventListener("securitypolicyviolation", event => heard.push(`refused ${event.blockedURI}`));
// Virtual time does not wait for the threads that decode; what is drawn is decoded where it is drawn.
HTMLImageElement.prototype.decode = function() {
  return this.complete ? Promise.resolve() : new Promise((done, failed) => { this.onload = done; this.onerror = failed; });
};
for (const kind of ["error", "warn"]) console[kind] = (...words) => heard.push(words.join(" "));</script>"#;

/// The document around the frames; each frame reports its findings to it.
const AROUND: &str = r#"<!DOCTYPE html><body style="margin:0"><pre></pre><script>
let findings = [];
addEventListener("message", event => { findings.push(event.data); document.querySelector("pre").textContent = findings.join("\n"); });
</script>"#;

/// Runs Chromium, under whichever name it is installed.
fn chromium(arguments: &[&str]) -> std::process::Output {
    for name in ["chromium", "chromium-browser", "google-chrome"] {
        match Command::new(name).args(arguments).output() {
            Ok(output) => return output,
            Err(cause) if cause.kind() == std::io::ErrorKind::NotFound => {}
            Err(cause) => panic!("{name}: {cause}"),
        }
    }
    panic!("no Chromium to open the page in: run ./setup.sh, which installs it");
}

/// Returns a script's findings at each of `WIDTHS`, in that order.
pub fn findings(page: &Path, script: &str, dark: bool) -> Vec<Value> {
    let dir = folder();
    let html = std::fs::read_to_string(page).expect("a page");
    let tries = format!("<script>{script}</script></body>");
    let html = html.replacen("<head>", &format!("<head>{HEARS}"), 1).replacen("</body>", &tries, 1);
    std::fs::write(dir.path().join("page.html"), html).expect("written");
    let frames =
        WIDTHS.map(|w| format!(r#"<iframe src="page.html" style="border:0;width:{w}px;height:1200px"></iframe>"#));
    let around = dir.path().join("around.html");
    std::fs::write(&around, AROUND.to_owned() + &frames.concat()).expect("written");
    let profile = format!("--user-data-dir={}", text(&dir.path().join("profile")));
    let address = format!("file://{}", text(&around));
    let mut arguments =
        vec!["--headless=new", "--no-sandbox", "--disable-gpu", "--no-first-run", "--window-size=1700,1300"];
    arguments.extend([
        "--enable-logging=stderr",
        "--timeout=60000",
        "--virtual-time-budget=8000",
        "--dump-dom",
        &profile,
    ]);
    arguments.extend(dark.then_some("--blink-settings=preferredColorScheme=0"));
    arguments.push(&address);
    let output = chromium(&arguments);
    let (dom, said) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    let console: Vec<&str> = said.lines().filter(|line| line.contains(":CONSOLE")).collect();
    assert!(console.is_empty(), "{console:?}");
    let told = dom.split("<pre>").nth(1).and_then(|rest| rest.split("</pre>").next()).unwrap_or_default();
    let told = told.replace("&amp;", "&").replace("&lt;", "<").replace("&gt;", ">");
    let mut all: Vec<Value> = told.lines().map(|line| serde_json::from_str(line).expect("JSON")).collect();
    all.sort_by_key(|found| found["width"].as_u64());
    assert_eq!(
        all.iter().map(|found| found["width"].as_u64()).collect::<Vec<_>>(),
        WIDTHS.map(|w| Some(w.into())),
        "{said}"
    );
    all
}

/// Computes from the file alone: the row with the smallest product of cost and seen error whose picture is not wrong, and all rows that
/// cast shadows and have both.
fn best(results: &Value) -> (u64, Vec<u64>) {
    let rows = results["rows"].as_array().expect("rows");
    let noise_ns = |row: &Value| {
        let at = |key: &str| row["unshadowed"]["draw_ns"][key].as_f64();
        Some(f64::max(0.5 * (at("p95")? - at("p05")?), 0.005 * at("median")?))
    };
    let floor = rows.iter().filter_map(noise_ns).fold(0.0, f64::max);
    let numbers = |row: &Value| {
        let [cost, seen] = [&row["cost_ns"], &row["error"]["seen"]["mean"]].map(Value::as_f64);
        Some([cost?.max(floor), seen?, row["error"]["image"]["flip_mean"].as_f64()?])
    };
    let shadows = |row: &&(u64, &Value)| row.1["technique"] != "none";
    let measured: Vec<(u64, [f64; 3])> =
        (0..).zip(rows).filter(|row| shadows(&row)).filter_map(|(i, row)| Some((i, numbers(row)?))).collect();
    let bare = &rows[0]["unshadowed"];
    let [dark, dark_flip] = ["seen", "flip_mean"].map(|key| bare[key].as_f64().expect("no shadow is told"));
    let could: Vec<_> =
        measured.iter().filter(|(_, [_, seen, flip])| *seen < dark && *flip < dark_flip).copied().collect();
    let is_right = |[cost, _, flip]: [f64; 3]| could.iter().all(|(_, [c, _, f])| *c > 1.25 * cost || flip <= 1.5 * f);
    let mut best = (f64::INFINITY, 0);
    for &(index, figures) in could.iter().filter(|(_, figures)| is_right(*figures)) {
        let product = figures[0] * figures[1].max(1e-3);
        if product < best.0 {
            best = (product, index);
        }
    }
    (best.1, measured.iter().map(|row| row.0).collect())
}

/// With two scenes, choosing one must hide everything of the other scene.
#[test]
fn one_of_two_scenes_is_chosen() {
    if is_long("one_of_two_scenes_is_chosen") {
        return;
    }
    log("exercised", "one_of_two_scenes_is_chosen", "Chromium");
    let (scenes, out) = (folder(), folder());
    let first = small_scene(scenes.path());
    let second = write_scene(scenes.path(), "other", &["0.1 0 1 0.7 1.5".into()]);
    let mut arguments = vec!["compare", text(&first), text(&second), "--quick", "--frames", "2"];
    arguments.extend(["--picture", "32x18", "--technique", "none", "--technique", "psm:size=16|32"]);
    ok(&[&arguments[..], &["--out", text(out.path())]].concat());
    for found in findings(&out.path().join("report.html"), include_str!("scenes.js"), false) {
        assert!(found["failed"].is_null() && found["errors"] == serde_json::json!([]), "{found}");
        assert_eq!(found["options"], serde_json::json!(["all", "small", "other"]), "{found}");
        // Each scene that is left must have an answer, a table and pictures, and plots if there are times to choose by.
        for (chosen, left) in [("all", vec!["small", "other"]), ("other", vec!["other"]), ("small", vec!["small"])] {
            assert_eq!(found["seen"][chosen]["scenes"], serde_json::json!(left), "{chosen}: {found}");
            assert_eq!(found["seen"][chosen]["rows"], 3 * left.len(), "{chosen}: {found}");
        }
    }
}

#[test]
fn a_reader_sees_the_answer_first() {
    if crate::support::is_costly("a_reader_sees_the_answer_first") {
        return;
    }
    log("exercised", "a_reader_sees_the_answer_first", "Chromium");
    let (scenes, out) = (folder(), folder());
    let scene = small_scene(scenes.path());
    let mut arguments =
        vec!["compare", text(&scene), "--quick", "--frames", "2", "--picture", "160x90", "--out", text(out.path())];
    let techniques =
        ["none", "avsm:nodes=4|8|16,size=64", "psm:size=64", "translucency-map:size=64", "uncompressed:size=64"];
    techniques.iter().for_each(|technique| arguments.extend(["--technique", technique]));
    ok(&arguments);
    let json = std::fs::read(out.path().join("results.json")).expect("written");
    let results: Value = serde_json::from_slice(&json).expect("JSON");
    // Without timestamps there are no times to choose by.
    if results["rows"].as_array().expect("rows").iter().all(|row| row["cost_ns"].is_null()) {
        return skipped("a_reader_sees_the_answer_first", "needs timestamps");
    }
    let (best, measured) = best(&results);
    let of = |wanted: &dyn Fn(&Value) -> bool| -> Vec<u64> {
        let rows = results["rows"].as_array().expect("rows");
        (0..).zip(rows).filter(|(i, row)| measured.contains(i) && wanted(row)).map(|(i, _)| i).collect()
    };
    let numbers = |value: &Value| -> Vec<u64> {
        let mut numbers: Vec<u64> = value.as_array().expect("a list").iter().filter_map(Value::as_u64).collect();
        numbers.sort_unstable();
        numbers
    };
    for dark in [false, true] {
        for found in findings(&out.path().join("report.html"), include_str!("page.js"), dark) {
            let number = |key: &str| found[key].as_f64().unwrap_or_else(|| panic!("no {key}: {found}"));
            assert!(found["failed"].is_null() && found["errors"] == serde_json::json!([]), "{found}");
            assert_eq!(found["resources"], serde_json::json!([]), "no network");
            let themes = ["rgb(255, 255, 255)", "rgb(20, 23, 26)"];
            let is = [&found["background"], &found["toggled"]];
            assert_eq!(is, if dark { [themes[1], themes[0]] } else { themes }, "{found}");
            assert_eq!(numbers(&found["answers"]), [best], "the sentence names the row of the smallest product");
            assert_eq!(numbers(&found["plots"][0]), measured, "a point a row");
            assert!(number("overflow") <= 0.0 && number("letters") >= 13.0, "{found}");
            assert!(number("overlaps") == 0.0 && number("outside") == 0.0 && number("labels") >= 6.0, "{found}");
            assert!(number("moved").abs() < 1.0 && number("folded") == 0.0, "{found}");
            assert!(number("scrolled") > 0.0 || number("width") > 500.0, "a narrow table scrolls: {found}");
            // Chromium writes four values, or three if two are equal.
            assert!(found["wipe"].as_str().is_some_and(|clip| clip.contains("20%")), "{found}");
            assert_eq!(number("crops"), number("cards"), "{found}");
            let printed = &found["printed"];
            assert_eq!((&printed["background"], &printed["controls"]), (&themes[0].into(), &0.into()), "{found}");
            assert_eq!(printed["kinds"], serde_json::json!(["Color", "Shape"]), "nothing to click is printed: {found}");
            assert!(printed["folded"].as_u64() > Some(0) && printed["letters"].as_f64() < Some(13.0), "{found}");
            let eight = of(&|row| row["variant"]["nodes"] == "8");
            let others = of(&|row| row["technique"] != "avsm");
            // `none` is a row and a picture; it costs nothing, so it is not a point.
            let with_none = |all: &[u64]| [&[0], all].concat();
            for (kind, place, is_point) in [("rows", 0, false), ("points", 1, true), ("pictures", 3, false)] {
                let of_kind = |all: &[u64]| if is_point { all.to_vec() } else { with_none(all) };
                assert_eq!(numbers(&found["left"][place]), eight, "{kind} that have nodes=8: {found}");
                assert_eq!(numbers(&found["without"][place]), of_kind(&others), "{kind} but avsm's: {found}");
                assert_eq!(numbers(&found["again"][place]), of_kind(&measured), "{kind}, all: {found}");
            }
        }
    }
}
