//! A and B, each beside the truth.

use crate::*;

/// A, the truth and B in a row must equal the pictures of their commands, with the differences below, multiplied by the gain.
#[test]
fn both_stand_beside_the_truth() {
    if crate::support::is_costly("both_stand_beside_the_truth") {
        return;
    }
    let Some(screen) = screen("both_stand_beside_the_truth") else { return };
    let folder = folder();
    // Three pictures do not fill the width: two columns are left over.
    let script = "set show beside\nset gain 3\nkey c\nscreenshot six.png\nset a reference\nkey c\nset look full\nset samples 1\n\
                  screenshot none.png\nkey f1\nscreenshot one.png\nquit\n";
    let specs = ["--technique", "avsm:size=16,nodes=4", "--against", "psm:size=32,slices=16"];
    let lines = lines(&view(&screen, folder.path(), &[&["plume_8k"], &specs[..], &SMALL].concat(), script));
    let commands: Vec<&String> = lines.iter().filter(|line| line.starts_with("gobo ")).collect();
    assert_eq!(commands.len(), 6, "{lines:#?}");
    let wanted: Vec<Vec<u8>> = commands[..3]
        .iter()
        .map(|command| {
            let (size, bytes) = pixels(&made(folder.path(), command));
            assert_eq!(size, [66, 60], "{command}");
            bytes
        })
        .collect();
    let [six, none, one] = ["six", "none", "one"].map(|name| pixels(&folder.path().join(format!("{name}.png"))));
    assert!([&six, &none, &one].iter().all(|(size, _)| *size == [200, 120]), "all of the window");
    let part = |image: &[u8], [column, row]: [usize; 2]| -> Vec<u8> {
        let line = |y: usize| &image[3 * ((60 * row + y) * 200 + 66 * column)..][..3 * 66];
        (0..60).flat_map(line).copied().collect()
    };
    let apart = |a: usize, b: usize| -> Vec<u8> {
        let each = wanted[a].iter().zip(&wanted[b]);
        each.map(|(a, b)| (u32::from(a.abs_diff(*b)) * 3).min(255) as u8).collect()
    };
    for column in 0..3 {
        assert!(part(&six.1, [column, 0]) == wanted[column], "{}", commands[column]);
    }
    for (column, [a, b]) in [[0, 1], [0, 2], [2, 1]].into_iter().enumerate() {
        let is = part(&six.1, [column, 1]);
        assert!(is == apart(a, b) && is.iter().any(|byte| *byte > 30), "below picture {column}");
    }
    // The reference must not differ from itself, and its difference from B must be symmetric; a single picture must fill the window again.
    assert!(part(&none.1, [0, 0]) == part(&none.1, [1, 0]) && part(&none.1, [0, 1]).iter().all(|byte| *byte == 0));
    assert!(part(&none.1, [1, 1]) == part(&none.1, [2, 1]) && part(&none.1, [2, 1]).iter().any(|byte| *byte > 30));
    assert!(part(&one.1, [0, 0]) != part(&none.1, [0, 0]));
}
