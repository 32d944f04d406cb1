//! Scatter plots for the page: rows as points, one color per technique, one shape per path, with labels that do not overlap.

use crate::report::answer::pareto::pareto_front;
use crate::report::format::{shortened, significant};
use crate::report::plot::series::ticks;
use std::fmt::Write;

/// Size in pixels of the page: a plot is never scaled, so its letters are as large as the surrounding text.
#[derive(Clone, Copy)]
pub(in crate::report) struct Size {
    /// Class in the style sheet.
    pub(in crate::report) name: &'static str,
    pub(in crate::report) width: f64,
    pub(in crate::report) height: f64,
    /// Maximum number of characters in a label.
    longest: usize,
    /// Whether only recommended rows and rows on the front have labels.
    few_labels: bool,
}

/// The first size is for windows of at least 860 pixels; from 1400 on, two plots stand side by side. The second is for phones; from 800
/// pixels on, two plots stand side by side.
pub(in crate::report) const SIZES: [Size; 2] = [
    Size { name: "wide", width: 652.0, height: 440.0, longest: 34, few_labels: false },
    Size { name: "narrow", width: 356.0, height: 440.0, longest: 20, few_labels: true },
];

/// Width of the left margin in pixels: fits the axis title and numbers such as `0.0007`.
const LEFT: f64 = 80.0;
const RIGHT: f64 = 14.0;
const TOP: f64 = 12.0;
const BOTTOM: f64 = 52.0;
/// Mean width of a letter, in pixels, in the widest of the common fonts.
const ADVANCE: f64 = 8.1;
const LINE: f64 = 16.0;
/// Radius reserved for a point, in pixels: fits the larger points of recommended rows.
const REACH: f64 = 7.0;
/// Points are drawn at the edge if their x exceeds `FAR` times the median, or their y is below the median divided by `CLOSE`.
const FAR: f64 = 25.0;
const CLOSE: f64 = 1000.0;
const SMALLEST: f64 = 1e-7;

/// A row as a point.
pub(in crate::report) struct Dot {
    /// Index in the results.
    pub(in crate::report) row: usize,
    pub(in crate::report) x: f64,
    pub(in crate::report) y: f64,
    pub(in crate::report) technique: usize,
    pub(in crate::report) path: usize,
    pub(in crate::report) label: String,
    /// Full text of the row, shown when the pointer is on the dot.
    pub(in crate::report) title: String,
    /// Whether the row is shown for comparison only, and does not stretch the axes.
    pub(in crate::report) aside: bool,
    /// What the recommendation calls the row, such as `best balanced`.
    pub(in crate::report) said: Option<&'static str>,
}

type Box = (f64, f64, f64, f64);

/// Ranges of the axes.
struct Ranges {
    x: (f64, f64),
    y: (f64, f64),
    size: Size,
}

impl Ranges {
    fn of(dots: &[Dot], size: Size) -> Option<Self> {
        let shown = || dots.iter().filter(|dot| !dot.aside || dots.len() == 1);
        let middle = |mut values: Vec<f64>| {
            values.retain(|value| *value >= SMALLEST);
            values.sort_by(f64::total_cmp);
            values.get(values.len() / 2).copied()
        };
        let far = middle(shown().map(|dot| dot.x).collect())? * FAR;
        let close = middle(shown().map(|dot| dot.y).collect())? / CLOSE;
        let x = range(shown().map(|dot| dot.x).filter(|x| (SMALLEST..=far).contains(x)))?;
        let y = range(shown().map(|dot| dot.y).filter(|y| *y >= close.max(SMALLEST)))?;
        // Leaves a margin for points at the edge.
        let at_edge = |outside: bool| if outside { 1.15 } else { 1.0 };
        let x = (x.0, x.1 * at_edge(dots.iter().any(|dot| dot.x > x.1)));
        let y = (y.0 / at_edge(dots.iter().any(|dot| dot.y < y.0)), y.1 * at_edge(dots.iter().any(|dot| dot.y > y.1)));
        Some(Self { x, y, size })
    }

    fn area(&self) -> Box {
        (LEFT, TOP, self.size.width - RIGHT, self.size.height - BOTTOM)
    }

    /// Returns where a point is drawn, and a note if that is not its true position.
    fn place(&self, dot: &Dot) -> (f64, f64, String) {
        let (left, top, right, bottom) = self.area();
        let along = |value: f64, (low, high): (f64, f64)| (value.max(SMALLEST * 0.01) / low).ln() / (high / low).ln();
        let (x, y) = (along(dot.x, self.x), along(dot.y, self.y));
        let inset = 11.0;
        let px = (left + x * (right - left)).clamp(left + inset, right - inset);
        let py = (bottom - y * (bottom - top)).clamp(top + inset, bottom - inset);
        let mut beyond = String::new();
        for (value, along, under, over) in [(dot.x, x, '←', '→'), (dot.y, y, '↓', '↑')] {
            if !(0.0..=1.0).contains(&along) {
                write!(beyond, " {} {}", if along < 0.0 { under } else { over }, significant(value)).ok();
            }
        }
        (px, py, beyond)
    }
}

/// Returns the range of an axis: a tenth of the values' extent stays free at each end, and the range fits at least two numbers.
fn range(values: impl Iterator<Item = f64> + Clone) -> Option<(f64, f64)> {
    let low = values.clone().reduce(f64::min)?.ln();
    let high = values.reduce(f64::max)?.ln();
    let air = ((high - low) / 10.0).max((2.4f64.ln() - (high - low)) / 2.0);
    Some(((low - air).exp(), (high + air).exp()))
}

/// Draws the SVG; `None` if it would show no differences.
pub(in crate::report) fn scatter(dots: &[Dot], size: Size, titles: [&str; 2], aria_label: &str) -> Option<String> {
    let ranges = Ranges::of(dots, size)?;
    let front = pareto_front(&dots.iter().map(|dot| (dot.x, dot.y)).collect::<Vec<_>>());
    let Size { name, width, height, .. } = size;
    let mut svg = format!(
        r#"<svg class="scatter {name}" role="img" aria-label="{}" width="{width}" height="{height}" viewBox="0 0 {width} {height}">"#,
        escaped(aria_label)
    );
    axes(&mut svg, &ranges, titles);
    steps(&mut svg, dots, &front, &ranges);
    let places: Vec<_> = dots.iter().map(|dot| ranges.place(dot)).collect();
    let mut taken: Vec<Box> = places.iter().map(|(x, y, _)| (x - REACH, y - REACH, x + REACH, y + REACH)).collect();
    let mut order: Vec<usize> = (0..dots.len()).collect();
    order.sort_by_key(|&i| (dots[i].said.is_none(), !front.contains(&i)));
    let mut labels = String::new();
    for &i in &order {
        let (dot, (x, y, beyond)) = (&dots[i], &places[i]);
        if size.few_labels && dot.said.is_none() && !dot.aside && !front.contains(&i) {
            continue;
        }
        let words = shortened(&dot.label, size.longest) + beyond;
        label(&mut labels, dot, &words, (*x, *y), ranges.area(), &mut taken);
    }
    // Draws recommended rows last, on top of the others.
    for &i in order.iter().rev() {
        let (dot, (x, y, _)) = (&dots[i], &places[i]);
        let on_front = if front.contains(&i) { " onfront" } else { "" };
        let said = if dot.said.is_some() { " said" } else { "" };
        let (row, technique, title) = (dot.row, dot.technique, escaped(&dot.title));
        write!(svg, r#"<g class="point{on_front}{said}" data-row="{row}"><title>{title}</title>"#).ok();
        if dot.said.is_some() {
            write!(svg, r#"<circle class="ring" cx="{x:.1}" cy="{y:.1}" r="11"/>"#).ok();
        }
        write!(svg, r#"<path class="t{technique}" transform="translate({x:.1} {y:.1})" d="{}"/></g>"#, shape(dot.path))
            .ok();
    }
    Some(svg + &labels + "</svg>")
}

fn axes(svg: &mut String, ranges: &Ranges, [x_title, y_title]: [&str; 2]) {
    let (left, top, right, bottom) = ranges.area();
    let along = |value: f64, (low, high): (f64, f64)| (value / low).ln() / (high / low).ln();
    // Keeps labels at least as far apart as they are wide.
    let mut last = f64::NEG_INFINITY;
    for (value, labelled) in ticks(ranges.x) {
        let x = left + along(value, ranges.x) * (right - left);
        let class = if labelled { "grid" } else { "grid faint" };
        write!(svg, r#"<path class="{class}" d="M{x:.1} {top}V{bottom}"/>"#).ok();
        let words = tick(value);
        let half = words.chars().count() as f64 * ADVANCE / 2.0;
        if labelled && x - half > last + 6.0 && x + half <= right + RIGHT {
            last = x + half;
            write!(svg, r#"<text class="tick" text-anchor="middle" x="{x:.1}" y="{}">{words}</text>"#, bottom + 18.0)
                .ok();
        }
    }
    let mut last = f64::INFINITY;
    for (value, labelled) in ticks(ranges.y) {
        let y = bottom - along(value, ranges.y) * (bottom - top);
        let class = if labelled { "grid" } else { "grid faint" };
        write!(svg, r#"<path class="{class}" d="M{left} {y:.1}H{right}"/>"#).ok();
        if labelled && y < last - LINE - 2.0 {
            last = y;
            let (x, y) = (left - 7.0, y + 4.5);
            write!(svg, r#"<text class="tick" text-anchor="end" x="{x}" y="{y:.1}">{}</text>"#, tick(value)).ok();
        }
    }
    let (middle, below) = ((left + right) / 2.0, bottom + 40.0);
    let across = (top + bottom) / 2.0;
    write!(svg, r#"<rect class="frame" x="{left}" y="{top}" width="{}" height="{}"/>"#, right - left, bottom - top)
        .ok();
    write!(svg, r#"<text class="axis" text-anchor="middle" x="{middle}" y="{below}">{}</text>"#, escaped(x_title)).ok();
    let turned = format!("translate(13 {across}) rotate(-90)");
    write!(svg, r#"<text class="axis" text-anchor="middle" transform="{turned}">{}</text>"#, escaped(y_title)).ok();
}

/// Draws the front as steps, since nothing between two of its points was measured.
fn steps(svg: &mut String, dots: &[Dot], front: &[usize], ranges: &Ranges) {
    let (_, top, right, _) = ranges.area();
    let mut path = String::new();
    for &i in front {
        let (x, y, ..) = ranges.place(&dots[i]);
        if path.is_empty() {
            write!(path, "M{x:.1} {top}V{y:.1}").ok();
        } else {
            write!(path, "H{x:.1}V{y:.1}").ok();
        }
    }
    if !path.is_empty() {
        write!(svg, r#"<path class="steps" d="{path}H{right}"/>"#).ok();
    }
}

/// Puts the label at the nearest free position, with a line to its dot if they are far apart. If no position is free, the label is left
/// out: overlapping labels would be harder to read.
fn label(svg: &mut String, dot: &Dot, words: &str, (x, y): (f64, f64), area: Box, taken: &mut Vec<Box>) {
    // Bold letters are wider.
    let advance = if dot.said.is_some() { ADVANCE * 1.15 } else { ADVANCE };
    let width = words.chars().count() as f64 * advance;
    let free = |b: &Box, taken: &[Box]| {
        let inside = b.0 >= area.0 + 2.0 && b.1 >= area.1 + 2.0 && b.2 <= area.2 - 2.0 && b.3 <= area.3 - 2.0;
        inside && !taken.iter().any(|t| b.0 < t.2 && t.0 < b.2 && b.1 < t.3 && t.1 < b.3)
    };
    let gap = if dot.said.is_some() { 14.0 } else { 10.0 };
    let rings = [gap, gap + 14.0, gap + 30.0, gap + 48.0, gap + 70.0];
    let around = [(1.0, 0.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 0.0), (0.0, -1.0), (-1.0, -1.0), (0.0, 1.0), (-1.0, 1.0)];
    for (ring, (dx, dy)) in rings.iter().flat_map(|ring| around.map(|side| (*ring, side))) {
        let left = match dx {
            1.0 => x + ring,
            0.0 => x - width / 2.0,
            _ => x - ring - width,
        };
        let middle = y + dy * (ring + 2.0);
        let extent = (left, middle - LINE / 2.0, left + width, middle + LINE / 2.0);
        if !free(&extent, taken) {
            continue;
        }
        taken.push(extent);
        let (row, baseline) = (dot.row, middle + 4.5);
        if ring > gap {
            let (to_x, to_y) = (x.clamp(extent.0, extent.2), y.clamp(extent.1, extent.3));
            write!(svg, r#"<path class="leader" data-row="{row}" d="M{x:.1} {y:.1}L{to_x:.1} {to_y:.1}"/>"#).ok();
        }
        // The label is anchored at the end nearest the dot, or at its middle if it is above or below the dot, so that a font of another
        // width does not move the label away from the dot.
        let (anchor, at) = match dx {
            1.0 => ("start", left),
            0.0 => ("middle", x),
            _ => ("end", left + width),
        };
        let said = if dot.said.is_some() { " said" } else { "" };
        let words = escaped(words);
        write!(svg, r#"<text class="label{said}" data-row="{row}" text-anchor="{anchor}" x="{at:.1}" y="{baseline:.1}">{words}</text>"#).ok();
        return;
    }
}

/// Returns the SVG path of a path's shape, centred at zero. The shapes repeat after eight.
pub(in crate::report) fn shape(path: usize) -> &'static str {
    const SHAPES: [&str; 8] = [
        "M-5.5 0a5.5 5.5 0 1 0 11 0a5.5 5.5 0 1 0 -11 0z",
        "M-5 -5H5V5H-5z",
        "M0 -6.5L6.2 5H-6.2z",
        "M0 -7L6 0L0 7L-6 0z",
        "M0 6.5L6.2 -5H-6.2z",
        "M-2 -6H2V-2H6V2H2V6H-2V2H-6V-2H-2z",
        "M-6 -3.2L-3.2 -6L0 -2.8L3.2 -6L6 -3.2L2.8 0L6 3.2L3.2 6L0 2.8L-3.2 6L-6 3.2L-2.8 0z",
        "M-6.5 -3H6.5V3H-6.5z",
    ];
    SHAPES[path % SHAPES.len()]
}

fn tick(value: f64) -> String {
    if (0.9e-4..0.9e6).contains(&value) { format!("{value}") } else { format!("{value:e}") }
}

pub(in crate::report) fn escaped(text: &str) -> String {
    let mut safe = String::new();
    for character in text.chars() {
        match character {
            '&' => safe += "&amp;",
            '<' => safe += "&lt;",
            '>' => safe += "&gt;",
            '"' => safe += "&quot;",
            '\'' => safe += "&#39;",
            c if c.is_control() => safe.push(' '),
            c => safe.push(c),
        }
    }
    safe
}
