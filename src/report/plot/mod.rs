//! Plots of times against errors, as SVGs.

pub(super) mod axes;
pub(super) mod colors;
pub(super) mod curve;
pub(super) mod footprint_plot;
pub(super) mod panels;
pub(super) mod scatter;
pub(super) mod series;
pub(super) mod steps;

use crate::bench::Results;
use crate::report::format::{one_line, shortened};
use crate::report::plot::axes::{AXES, Axes};
use crate::report::plot::colors::COLORS;
use crate::report::plot::footprint_plot::footprint_plot;
use crate::report::plot::series::{Panel, Point, panels, ticks};
use plotters::coord::Shift;
use plotters::coord::types::RangedCoordf64;
use plotters::element::{CoordMapper, Drawable, PointCollection};
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

type Backend<'a> = SVGBackend<'a>;
type PlotResult = Result<(), DrawingAreaErrorKind<std::io::Error>>;
/// Coordinates are decimal logarithms of milliseconds and of error.
type Logarithmic<'a> = DrawingArea<Backend<'a>, Cartesian2d<RangedCoordf64, RangedCoordf64>>;
/// Left, top, right and bottom, in pixels.
type Extent = (i32, i32, i32, i32);

const WIDTH: i32 = 1120;
const TITLE_HEIGHT: i32 = 62;
const PLOT_LEFT: i32 = 84;
const PLOT_RIGHT: i32 = 806;
const PLOT_TOP: i32 = 34;
/// Height reserved for tick labels and the axis title, in pixels.
const BELOW_PLOT: i32 = 62;
const SMALLEST_PLOT_HEIGHT: i32 = 330;
const LEGEND_LEFT: i32 = PLOT_RIGHT + 24;
const LEGEND_LINE: i32 = 21;
/// Pixels from the first line of an entry to the second.
const LEGEND_NEXT_LINE: i32 = 15;

const INK: RGBColor = RGBColor(0x1b, 0x1f, 0x24);
const FAINT_INK: RGBColor = RGBColor(0x5b, 0x63, 0x6e);
const GRID: RGBColor = RGBColor(0xe3, 0xe6, 0xea);
/// Number of shapes; coprime to the number of colors, so that thirty series look different.
const SHAPES: usize = 5;

/// Returns file names and SVGs with logarithmic axes. `cost-vs-seen.svg` plots what shadows add to a frame against the seen error,
/// `time-vs-error.svg` the build time against the map error, and `frame-vs-error.svg` and `frame-vs-surface.svg` the frame time against the
/// error in space and on surfaces; each exists if some row has both figures. They have one panel per scene, with its Pareto front marked.
/// `footprints.svg` exists if errors against area means were measured. Errors too small for the logarithmic axis are drawn on a labelled
/// line.
pub fn plots(results: &Results) -> Vec<(&'static str, String)> {
    let footprints = footprint_plot(results).map(|svg| ("footprints.svg", svg));
    AXES.iter().filter_map(|axes| Some((axes.file, plot(results, axes)?))).chain(footprints).collect()
}

fn plot(results: &Results, axes: &Axes) -> Option<String> {
    let panels = panels(results, axes);
    if panels.is_empty() {
        return None;
    }
    // A technique looks the same in every scene.
    let mut names: Vec<&str> = Vec::new();
    for series in panels.iter().flat_map(|panel| &panel.series) {
        if !names.contains(&series.name.as_str()) {
            names.push(&series.name);
        }
    }
    let heights: Vec<i32> = panels.iter().map(|panel| PLOT_TOP + plot_height(panel) + BELOW_PLOT).collect();
    let height = TITLE_HEIGHT + heights.iter().sum::<i32>();
    let mut svg = String::new();
    {
        let root = SVGBackend::with_string(&mut svg, (WIDTH as u32, height as u32)).into_drawing_area();
        // Drawing into a string cannot fail; if it ever did, there would be no plot to show.
        root.fill(&WHITE).ok()?;
        title(&root, results, axes).ok()?;
        let mut top = TITLE_HEIGHT;
        for (panel, height) in panels.iter().zip(heights) {
            draw_panel(&root, panel, axes, top, &names).ok()?;
            top += height;
        }
        root.present().ok()?;
    }
    let role = format!(r#"<svg role="img" aria-label="{}" "#, axes.aria_label);
    Some(svg.replacen("<svg ", &role, 1))
}

/// Returns the height of a plot, which its legend determines: the series and at most four fixed entries.
fn plot_height(panel: &Panel) -> i32 {
    let names = panel.series.iter().map(|series| legend_height(&legend_lines(&series.name))).sum::<i32>();
    SMALLEST_PLOT_HEIGHT.max(names + 4 * LEGEND_LINE + 16)
}

fn legend_height(lines: &[String]) -> i32 {
    LEGEND_LINE + (lines.len() as i32 - 1) * LEGEND_NEXT_LINE
}

/// Splits a label into one line, or two if a blank, comma or dash is near enough to break at; text that does not fit loses its middle.
fn legend_lines(label: &str) -> Vec<String> {
    let room = characters_in(WIDTH - LEGEND_LEFT - 44, 13);
    let label: Vec<char> = shortened(label, 2 * room - room / 4).chars().collect();
    if label.len() <= room {
        return vec![label.into_iter().collect()];
    }
    let near = (room / 2..room).rev().find(|&place| matches!(label[place], ' ' | ',' | '-'));
    let (first, second) = label.split_at(near.map_or(room, |place| place + 1));
    vec![first.iter().collect(), shortened(&second.iter().collect::<String>(), room)]
}

fn title(root: &DrawingArea<Backend, Shift>, results: &Results, axes: &Axes) -> PlotResult {
    let device = &results.device;
    text(root, axes.title, (20, 22), 18, &INK, (HPos::Left, VPos::Center), true)?;
    let facts = one_line(&format!("{} ({}) · {} · Vulkan {}", device.name, device.kind, device.driver, device.api));
    let room = characters_in(WIDTH - 40, 13);
    text(root, &shortened(&facts, room), (20, 44), 13, &FAINT_INK, (HPos::Left, VPos::Center), false)
}

fn draw_panel(root: &DrawingArea<Backend, Shift>, panel: &Panel, axes: &Axes, top: i32, names: &[&str]) -> PlotResult {
    let extent = (PLOT_LEFT, top + PLOT_TOP, PLOT_RIGHT, top + PLOT_TOP + plot_height(panel));
    let (left, upper, right, lower) = extent;
    let log = |(low, high): (f64, f64)| low.log10()..high.log10();
    let (times, errors) = (log(panel.milliseconds), log(panel.error));
    let area = root.apply_coord_spec(Cartesian2d::new(times, errors, (left..right, lower..upper)));
    let room = characters_in(WIDTH - left - 20, 15);
    text(root, &shortened(&panel.scene, room), (left, top + 16), 15, &INK, (HPos::Left, VPos::Center), true)?;

    draw_axes(root, &area, panel, axes, extent)?;
    let mut labels = Labels { extent, taken: Vec::new() };
    limits_and_floor(root, &area, panel, extent, &mut labels)?;
    front(&area, panel)?;
    let pixel = |point: &Point| area.map_coordinate(&(point.milliseconds.log10(), point.error.log10()));
    for point in panel.series.iter().flat_map(|series| &series.points) {
        let (x, y) = pixel(point);
        let reach = if point.on_front { 10 } else { 6 };
        labels.taken.push((x - reach, y - reach, x + reach, y + reach));
    }
    for series in &panel.series {
        let look = names.iter().position(|&name| name == series.name).unwrap_or(0);
        let color = &COLORS[look % COLORS.len()];
        let places: Vec<_> = series.points.iter().map(pixel).collect();
        root.draw(&PathElement::new(places.clone(), color.mix(0.55).stroke_width(1)))?;
        for (point, &(x, y)) in series.points.iter().zip(&places) {
            if let Some((low, high)) = point.spread_milliseconds {
                let clamped = |ms: f64| ms.clamp(panel.milliseconds.0, panel.milliseconds.1).log10();
                let spread = [clamped(low), clamped(high)].map(|ms| area.map_coordinate(&(ms, point.error.log10())));
                root.draw(&PathElement::new(spread.to_vec(), color.mix(0.55).stroke_width(2)))?;
            }
            if point.on_front {
                root.draw(&Circle::new((x, y), 9, INK.stroke_width(2)))?;
            }
            marker(root, look, (x, y))?;
        }
    }
    for point in panel.series.iter().flat_map(|series| &series.points) {
        if let Some((place, anchor)) = labels.place(&point.label, pixel(point)) {
            text(root, &point.label, place, 13, &INK, (anchor, VPos::Center), false)?;
        }
    }
    legend(root, panel, upper, names)
}

fn draw_axes(
    root: &DrawingArea<Backend, Shift>,
    area: &Logarithmic,
    panel: &Panel,
    axes: &Axes,
    extent: Extent,
) -> PlotResult {
    let (left, upper, right, lower) = extent;
    for (milliseconds, labelled) in ticks(panel.milliseconds) {
        let (x, _) = area.map_coordinate(&(milliseconds.log10(), 0.0));
        let strength = if labelled { 1.0 } else { 0.45 };
        root.draw(&PathElement::new(vec![(x, upper), (x, lower)], GRID.mix(strength).stroke_width(1)))?;
        if labelled {
            let label = tick_label(milliseconds);
            text(root, &label, (x, lower + 14), 13, &FAINT_INK, (HPos::Center, VPos::Center), false)?;
        }
    }
    for (error, labelled) in ticks(panel.error) {
        let (_, y) = area.map_coordinate(&(0.0, error.log10()));
        let strength = if labelled { 1.0 } else { 0.45 };
        root.draw(&PathElement::new(vec![(left, y), (right, y)], GRID.mix(strength).stroke_width(1)))?;
        if labelled {
            text(root, &tick_label(error), (left - 8, y), 13, &FAINT_INK, (HPos::Right, VPos::Center), false)?;
        }
    }
    root.draw(&Rectangle::new([(left, upper), (right, lower)], FAINT_INK.stroke_width(1)))?;
    let middle = ((left + right) / 2, (upper + lower) / 2);
    let centred = (HPos::Center, VPos::Center);
    text(root, axes.time_title, (middle.0, lower + 36), 13, &INK, centred, false)?;
    let style = style_of(13, &INK, centred, false).transform(FontTransform::Rotate270);
    root.draw(&Text::new(axes.error_title, (22, middle.1), style))
}

/// Draws lines across the panel, each labelled at one end if the label fits.
fn limits_and_floor(
    root: &DrawingArea<Backend, Shift>,
    area: &Logarithmic,
    panel: &Panel,
    (left, _, right, _): Extent,
    labels: &mut Labels,
) -> PlotResult {
    let height_of = |error: f64| area.map_coordinate(&(0.0, error.log10())).1;
    for limit in &panel.limits {
        let y = height_of(limit.error);
        dashed(root, (left, right), y, &FAINT_INK, (2, 4))?;
        let label = shortened(&limit.label, 16);
        let width = text_width(&label, 13);
        let extent = (right - 8 - width, y - 16, right - 4, y - 1);
        if labels.is_free(extent) {
            labels.taken.push(extent);
            text(root, &label, (right - 6, y - 8), 13, &FAINT_INK, (HPos::Right, VPos::Center), false)?;
        }
    }
    let Some(floor) = panel.floor else { return Ok(()) };
    let y = height_of(floor);
    dashed(root, (left, right), y, &COLORS[1], (7, 5))?;
    let label = format!("{} or less, zero included", tick_label(floor));
    labels.taken.push((left + 4, y + 2, left + 10 + text_width(&label, 13), y + 15));
    text(root, &label, (left + 6, y + 10), 13, &COLORS[1], (HPos::Left, VPos::Center), false)
}

/// Draws the border of the region that the front beats, as steps, since nothing between two points of the front was measured.
fn front(area: &Logarithmic, panel: &Panel) -> PlotResult {
    let mut corners: Vec<(f64, f64)> = panel
        .series
        .iter()
        .flat_map(|series| &series.points)
        .filter(|point| point.on_front)
        .map(|point| (point.milliseconds.log10(), point.error.log10()))
        .collect();
    corners.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(b.1.total_cmp(&a.1)));
    let (Some(&first), Some(&last)) = (corners.first(), corners.last()) else { return Ok(()) };
    let mut steps = vec![(first.0, panel.error.1.log10())];
    for pair in corners.windows(2) {
        steps.extend([pair[0], (pair[1].0, pair[0].1)]);
    }
    steps.extend([last, (panel.milliseconds.1.log10(), last.1)]);
    area.draw(&PathElement::new(steps, INK.mix(0.22).stroke_width(4)))
}

fn legend(root: &DrawingArea<Backend, Shift>, panel: &Panel, top: i32, names: &[&str]) -> PlotResult {
    let mut y = top + 10;
    let mut entry = |label: &str, draw: &dyn Fn(i32) -> PlotResult| -> PlotResult {
        draw(y)?;
        let lines = legend_lines(label);
        for (place, line) in (0..).zip(&lines) {
            let place = (LEGEND_LEFT + 34, y + place * LEGEND_NEXT_LINE);
            text(root, line, place, 13, &INK, (HPos::Left, VPos::Center), false)?;
        }
        y += legend_height(&lines);
        Ok(())
    };
    let across = (LEGEND_LEFT, LEGEND_LEFT + 24);
    for series in &panel.series {
        let look = names.iter().position(|&name| name == series.name).unwrap_or(0);
        entry(&series.name, &|y| {
            let style = COLORS[look % COLORS.len()].mix(0.55).stroke_width(1);
            root.draw(&PathElement::new(vec![(across.0, y), (across.1, y)], style))?;
            marker(root, look, (LEGEND_LEFT + 12, y))
        })?;
    }
    entry("Pareto front of the scene", &|y| {
        root.draw(&PathElement::new(vec![(across.0, y), (across.1, y)], INK.mix(0.22).stroke_width(4)))?;
        root.draw(&Circle::new((LEGEND_LEFT + 12, y), 8, INK.stroke_width(2)))
    })?;
    if !panel.limits.is_empty() {
        entry("limit of that many nodes", &|y| dashed(root, across, y, &FAINT_INK, (2, 4)))?;
    }
    if panel.floor.is_some() {
        entry("error too small for the axis", &|y| dashed(root, across, y, &COLORS[1], (7, 5)))?;
    }
    if panel.series.iter().flat_map(|series| &series.points).any(|point| !point.label.is_empty()) {
        entry("number at a point: nodes", &|_| Ok(()))?;
    }
    Ok(())
}

/// Finds free positions for the labels of points.
struct Labels {
    extent: Extent,
    taken: Vec<Extent>,
}

impl Labels {
    fn is_free(&self, (left, top, right, bottom): Extent) -> bool {
        let inside = left > self.extent.0 && top > self.extent.1 && right < self.extent.2 && bottom < self.extent.3;
        inside && !self.taken.iter().any(|t| left < t.2 && t.0 < right && top < t.3 && t.1 < bottom)
    }

    /// Returns a free position near the point, or `None`: overlapping labels say less than no label.
    fn place(&mut self, label: &str, (x, y): (i32, i32)) -> Option<((i32, i32), HPos)> {
        let width = text_width(label, 13);
        let diagonal = [(11, -12), (11, 12), (-11, -12), (-11, 12)];
        let straight = [(14, 0), (0, -18), (0, 18), (-14, 0), (14, -24), (14, 24), (-14, -24), (-14, 24)];
        for (dx, dy) in diagonal.into_iter().chain(straight) {
            let (anchor, left) = match dx {
                0 => (HPos::Center, x - width / 2),
                1.. => (HPos::Left, x + dx),
                _ => (HPos::Right, x + dx - width),
            };
            let extent = (left, y + dy - 7, left + width, y + dy + 7);
            if !label.is_empty() && self.is_free(extent) {
                self.taken.push(extent);
                return Some(((x + dx, y + dy), anchor));
            }
        }
        None
    }
}

fn marker(root: &DrawingArea<Backend, Shift>, look: usize, (x, y): (i32, i32)) -> PlotResult {
    let fill = COLORS[look % COLORS.len()].filled();
    let polygon =
        |corners: &[(i32, i32)]| Polygon::new(corners.iter().map(|c| (x + c.0, y + c.1)).collect::<Vec<_>>(), fill);
    match look % SHAPES {
        0 => draw(root, &Circle::new((x, y), 5, fill)),
        1 => draw(root, &polygon(&[(-4, -4), (4, -4), (4, 4), (-4, 4)])),
        2 => draw(root, &polygon(&[(0, -6), (6, 5), (-6, 5)])),
        3 => draw(root, &polygon(&[(0, -6), (6, 0), (0, 6), (-6, 0)])),
        _ => draw(root, &polygon(&[(0, 6), (6, -5), (-6, -5)])),
    }
}

fn draw<'a, 'b, E, M>(root: &DrawingArea<Backend<'b>, Shift>, element: &'a E) -> PlotResult
where
    M: CoordMapper,
    &'a E: PointCollection<'a, (i32, i32), M>,
    E: Drawable<Backend<'b>, M>,
{
    root.draw(element)
}

/// Draws a dashed line as many short lines, since the SVG backend has no dashes.
fn dashed(
    root: &DrawingArea<Backend, Shift>,
    (left, right): (i32, i32),
    y: i32,
    color: &RGBColor,
    (dash, gap): (i32, i32),
) -> PlotResult {
    for start in (left..right).step_by((dash + gap) as usize) {
        let end = (start + dash).min(right);
        root.draw(&PathElement::new(vec![(start, y), (end, y)], color.stroke_width(1)))?;
    }
    Ok(())
}

fn style_of(size: i32, color: &RGBColor, (horizontal, vertical): (HPos, VPos), bold: bool) -> TextStyle<'_> {
    let weight = if bold { FontStyle::Bold } else { FontStyle::Normal };
    // The backend divides sizes by 1.24; the factor undoes that, so sizes are in pixels.
    let font = FontDesc::new(FontFamily::SansSerif, f64::from(size) * 1.24, weight);
    TextStyle::from(font).color(color).pos(Pos::new(horizontal, vertical))
}

fn text(
    root: &DrawingArea<Backend, Shift>,
    text: &str,
    place: (i32, i32),
    size: i32,
    color: &RGBColor,
    anchor: (HPos, VPos),
    bold: bool,
) -> PlotResult {
    root.draw(&Text::new(text, place, style_of(size, color, anchor, bold)))
}

/// Estimates the width of text: the mean advance of common sans-serif fonts is half an em, and 0.62 em in the widest of them.
fn text_width(text: &str, size: i32) -> i32 {
    (text.chars().count() as f64 * f64::from(size) * 0.62).ceil() as i32
}

fn characters_in(width: i32, size: i32) -> usize {
    (f64::from(width) / (f64::from(size) * 0.62)) as usize
}

/// Formats a number such as `0.001` or `20`; as `1e-5` below 1e-4 and from 1e6 on.
fn tick_label(value: f64) -> String {
    if (0.9e-4..0.9e6).contains(&value) { format!("{value}") } else { format!("{value:e}") }
}
