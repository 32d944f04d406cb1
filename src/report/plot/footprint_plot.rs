//! Plots the error against area means over the area's width, as an SVG.

use crate::bench::{FOOTPRINTS, Results, Row};
use crate::report::answer::pareto::scenes;
use crate::report::format::{Specs, one_line, shortened};
use crate::report::plot::colors::COLORS;
use crate::report::plot::curve::{TEXT, TITLE};
use crate::report::plot::series::{range_with_air, ticks};
use plotters::prelude::*;

const WIDTH: u32 = 1120;
const HEIGHT: u32 = 480;

/// Lower end of the logarithmic error axis; smaller errors are drawn here.
const LEAST: f64 = 1e-3;

/// Draws a panel per scene and a line per row, over the widths of the squares; `None` unless footprints were measured.
pub(in crate::report) fn footprint_plot(results: &Results) -> Option<String> {
    let specs = Specs::of(&results.rows);
    let of = |scene: &str| {
        let rows = results.rows.iter().filter(|row| row.scene == scene && !row.footprints.is_empty());
        (one_line(scene), rows.collect::<Vec<_>>())
    };
    let panels: Vec<_> = scenes(results).into_iter().map(of).filter(|(_, rows)| !rows.is_empty()).collect();
    let mut svg = String::new();
    // Drawing into a string cannot fail; if it ever did, there would be no plot to show.
    draw(&mut svg, &panels, &specs).ok()?;
    let label = "Error against what squares see, by their width";
    (!panels.is_empty()).then(|| svg.replacen("<svg ", &format!(r#"<svg role="img" aria-label="{label}" "#), 1))
}

fn draw(svg: &mut String, panels: &[(String, Vec<&Row>)], specs: &Specs) -> Result<(), Box<dyn std::error::Error>> {
    let root = SVGBackend::with_string(svg, (WIDTH, HEIGHT * panels.len().max(1) as u32)).into_drawing_area();
    root.fill(&WHITE)?;
    for ((scene, rows), area) in panels.iter().zip(root.split_evenly((panels.len().max(1), 1))) {
        let errors = rows.iter().flat_map(|row| &row.footprints).map(|error| error.rms.max(LEAST));
        let range = range_with_air(errors).unwrap_or((LEAST, 1.0));
        let labelled = ticks(range).into_iter().filter(|(_, labelled)| *labelled).map(|(value, _)| value).collect();
        let (first, last) = (FOOTPRINTS[0], FOOTPRINTS[FOOTPRINTS.len() - 1]);
        let errors_axis = (range.0..range.1).log_scale().with_key_points(labelled);
        let (area, legend) = area.split_horizontally(WIDTH * 6 / 10);
        let mut chart = ChartBuilder::on(&area)
            .caption(format!("{scene}: error against what squares see"), ("sans-serif", TITLE))
            .margin(12)
            .x_label_area_size(44)
            .y_label_area_size(60)
            .build_cartesian_2d((first..last).log_scale().base(4.0), errors_axis)?;
        chart
            .configure_mesh()
            .light_line_style(TRANSPARENT)
            .x_desc("side of the square, texels of a fitted map of 256²")
            .y_desc("root mean square")
            .x_label_formatter(&|x| if *x < 1.0 { format!("1/{:.0}", 1.0 / x) } else { format!("{x:.0}") })
            .y_label_formatter(&|y| y.to_string())
            .label_style(("sans-serif", TEXT))
            .draw()?;
        for (i, row) in rows.iter().enumerate() {
            let color = COLORS[i % COLORS.len()];
            let points: Vec<_> = row.footprints.iter().map(|error| (error.texels, error.rms.max(LEAST))).collect();
            // The second line in the same color has hollow dots.
            let dot = if i < COLORS.len() { color.filled() } else { color.stroke_width(2) };
            chart.draw_series([PathElement::new(points.clone(), color.stroke_width(2))])?;
            chart.draw_series(points.into_iter().map(|point| Circle::new(point, 4, dot)))?;
            let y = 48 + 20 * i as i32;
            legend.draw(&PathElement::new([(8, y), (30, y)], color.stroke_width(2)))?;
            legend.draw(&Circle::new((19, y), 4, dot))?;
            let name = shortened(&specs.compact(row), 56);
            legend.draw(&Text::new(name, (38, y - 8), ("sans-serif", TEXT)))?;
        }
    }
    root.present()?;
    Ok(())
}
