//! `gobo render --wireframe`: black pixels must be on the projected sides of triangles, and every side must be drawn.

use super::rgb8;
use crate::support::log;
use crate::{folder, ok, runs, text, write_scene};
use glam::DVec2;
use gobo::reference::twin::vertex_lit::quad;
use gobo::scene::{Scene, View};
use gobo::shading::VERTEX_SPACING;

const SIZE: [u32; 2] = [480, 270];

/// Three spheres side by side across the camera's view, so dense that their lines are black.
#[test]
fn lines_are_where_triangles_meet() {
    const NAME: &str = "lines_are_where_triangles_meet";
    let (device, runs) = runs("any", "render --wireframe");
    if !runs {
        return crate::support::skipped(NAME, "needs tessellationShader and fillModeNonSolid");
    }
    log("exercised", NAME, &device);
    let folder = folder();
    let rows = [[-1.3, -1.3, 1.0, 0.5, 40.0], [0.0, 0.0, 1.3, 0.7, 40.0], [1.2, 1.2, 0.8, 0.3, 40.0]];
    let file = write_scene(folder.path(), "three", &rows.map(|row| row.map(|v: f64| v.to_string()).join(" ")));
    let out = folder.path().join("lines.png");
    let picture = SIZE.map(|side| side.to_string()).join("x");
    let technique = ["--plain", "--technique", "avsm:path=binned,size=32,lighting=vertex", "--wireframe"];
    let size = ["--picture", &picture, "--out", text(&out)];
    ok(&[&["render", text(&file)][..], &technique, &size].concat());

    let scene = Scene::load(text(&file), 20.0).expect("written");
    let camera = View::camera(&scene.camera, &scene, SIZE);
    let (_, pixels) = rgb8(&out);
    let black = |x: i32, y: i32| {
        let inside = (0..SIZE[0] as i32).contains(&x) && (0..SIZE[1] as i32).contains(&y);
        inside && pixels[(y as u32 * SIZE[0] + x as u32) as usize].iter().all(|c| *c < 12)
    };
    // Per caster's grid of vertices: its corner, the size of a part (one cell) in pixels, and the number of parts along each axis.
    let grids: Vec<(DVec2, DVec2, [usize; 2])> = scene
        .casters()
        .iter()
        .map(|caster| {
            let quad = quad(&camera, caster, VERTEX_SPACING.into()).expect("in the picture");
            let corners = quad.corners.map(|ndc| (0.5 * ndc + 0.5) * DVec2::from(SIZE.map(f64::from)));
            let low = corners[0].min(corners[1]);
            (low, (corners[0] - corners[1]).abs() / DVec2::from(quad.parts.map(|n| n as f64)), quad.parts)
        })
        .collect();

    // Each black pixel must be on a side of a part or on one of its diagonals; the device chooses which.
    let mut lines = 0;
    for i in 0..SIZE[0] * SIZE[1] {
        let (x, y) = (i % SIZE[0], i / SIZE[0]);
        if !black(x as i32, y as i32) {
            continue;
        }
        let at = DVec2::new(x.into(), y.into()) + 0.5;
        let near = |(low, part, parts): &(DVec2, DVec2, [usize; 2])| {
            let place = (at - *low) / *part;
            let inside = [place.x, place.y].iter().zip(parts).all(|(p, n)| (-0.2..*n as f64 + 0.2).contains(p));
            let within = place - place.floor();
            let side = ((place - place.round()).abs() * *part).min_element();
            let steep = part.x * part.y / part.length();
            let diagonal = (within.x - within.y).abs().min((within.x + within.y - 1.0).abs()) * steep;
            inside && side.min(diagonal) < 1.1
        };
        assert!(grids.iter().any(near), "a line at {at}, where no side of a triangle is");
        lines += 1;
    }
    // Every side of a part must be drawn along its full length.
    let (mut drawn, mut sides) = (0, 0);
    for (low, part, parts) in &grids {
        let high = *low + *part * DVec2::from(parts.map(|n| n as f64));
        for axis in [0, 1] {
            for line in 0..=parts[axis] {
                let across = low[axis] + line as f64 * part[axis];
                for along in low[1 - axis].ceil() as i32..high[1 - axis].floor() as i32 {
                    let middle = across.floor() as i32;
                    let is_black =
                        |by: i32| if axis == 0 { black(middle + by, along) } else { black(along, middle + by) };
                    sides += 1;
                    drawn += usize::from((-1..=1).any(is_black));
                }
            }
        }
    }
    let area: f64 = grids.iter().map(|(_, part, parts)| part.x * part.y * (parts[0] * parts[1]) as f64).sum();
    println!("{lines} black pixels of {area:.0}, {drawn} of {sides} along the sides, parts {:?}", grids);
    assert!(grids.iter().all(|grid| grid.2.iter().all(|n| *n > 1)), "the test proves nothing");
    assert!(100 * drawn > 98 * sides, "{drawn} of {sides} pixels along the sides");
    assert!((lines as f64) < 0.6 * area, "{lines} of {area}: lines, and no filled triangles");
}
