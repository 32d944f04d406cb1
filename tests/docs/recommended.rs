//! docs/recommend.md has what `results/recommend.sh` printed.

use gobo::consume::parse;
use std::path::Path;

#[test]
fn recommended_as_printed() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let read = |path: &str| std::fs::read_to_string(root.join(path)).expect(path);
    let (page, printed) = (read("docs/recommend.md"), read("results/nvidia-h100/recommend.txt"));
    let mut scenes = 0;
    for line in printed.lines().filter(|line| line.contains("| `")) {
        let (before, rest) = line.split_once('`').expect("an answer");
        let (spec, after) = rest.split_once('`').expect("an answer");
        let spec = parse(spec).expect("a spec").pop().expect("a spec").short();
        let wanted = format!("{before}`{spec}`{after}");
        assert!(page.contains(&wanted), "docs/recommend.md has no line\n{wanted}");
        scenes += 1;
    }
    assert_eq!(scenes, 5);
}
