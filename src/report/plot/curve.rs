//! Plots the transmittance along one light ray, as each technique reconstructs it, as an SVG.

use crate::bench::{LightRay, RayPoints};
use crate::report::plot::colors::COLORS;
use crate::{Error, Result};
use plotters::prelude::*;

/// Text sizes for Plotters, which divides them by 1.24 in an SVG: 13.7 and 16 pixels.
pub(in crate::report) const TEXT: u32 = 17;
pub(in crate::report) const TITLE: u32 = 20;

/// Draws the true curve in black, and each technique's line in its own color, labelled from `names`. The technique's nodes are dots on its
/// line.
///
/// # Errors
/// [`Error::Input`] if there is nothing to draw.
pub fn curve(title: &str, ray: &LightRay, names: &[String]) -> Result<String> {
    if ray.truth.is_empty() {
        return Err(Error::input(title, "no points to draw", "choose a texel that casters cover"));
    }
    let mut svg = String::new();
    draw(&mut svg, title, ray, names)
        .map_err(|e| Error::input(title, format!("cannot be drawn: {e}"), "report this as a bug"))?;
    Ok(svg)
}

fn draw(
    svg: &mut String,
    title: &str,
    ray: &LightRay,
    names: &[String],
) -> std::result::Result<(), Box<dyn std::error::Error>> {
    let LightRay { truth, lines, .. } = ray;
    let range = ray.range();
    let root = SVGBackend::with_string(svg, (960, 540)).into_drawing_area();
    root.fill(&WHITE)?;
    let mut chart = ChartBuilder::on(&root)
        .caption(title, ("sans-serif", TITLE))
        .margin(12)
        .x_label_area_size(44)
        .y_label_area_size(56)
        .build_cartesian_2d(range.clone(), 0.0..1.02)?;
    chart
        .configure_mesh()
        .light_line_style(TRANSPARENT)
        .x_desc("depth in the light's range")
        .y_desc("transmittance")
        .label_style(("sans-serif", TEXT))
        .draw()?;
    // Plotters would draw points outside the range at the edge.
    let within = |points: &RayPoints| points.iter().copied().filter(|(x, _)| range.contains(x)).collect::<Vec<_>>();
    let path = |points: &RayPoints, style: ShapeStyle| PathElement::new(within(points), style);
    chart
        .draw_series(std::iter::once(path(truth, BLACK.stroke_width(3))))?
        .label("true")
        .legend(|(x, y)| PathElement::new([(x, y), (x + 18, y)], BLACK.stroke_width(3)));
    for (i, (line, name)) in lines.iter().zip(names).enumerate() {
        let color = COLORS[i % COLORS.len()];
        chart
            .draw_series(std::iter::once(path(&line.points, color.stroke_width(2))))?
            .label(name)
            .legend(move |(x, y)| PathElement::new([(x, y), (x + 18, y)], color.stroke_width(2)));
        chart.draw_series(within(&line.nodes).into_iter().map(|p| Circle::new(p, 4, color.filled())))?;
    }
    chart
        .configure_series_labels()
        .position(SeriesLabelPosition::UpperRight)
        .background_style(WHITE.mix(0.9))
        .border_style(BLACK.mix(0.3))
        .label_font(("sans-serif", TEXT))
        .draw()?;
    root.present()?;
    Ok(())
}
