//! Reads an SVG of `gobo curve` from its elements: axes from the positions of their numbers, lines and dots.

use glam::DVec2;
use std::path::Path;

/// A line and its dots, in pixels.
#[derive(Default)]
pub struct Drawn {
    pub line: Vec<DVec2>,
    pub dots: Vec<DVec2>,
}

pub struct Plot {
    /// The truth, then the techniques.
    pub drawn: Vec<Drawn>,
    pub names: Vec<String>,
    /// Two values for x and for y, with the pixels where their labels are.
    axes: [[(f64, f64); 2]; 2],
}

fn attribute<'a>(element: &'a str, name: &str) -> &'a str {
    let start = element.find(&format!(" {name}=\"")).unwrap_or_else(|| panic!("no {name} in {element}"));
    let value = &element[start + name.len() + 3..];
    &value[..value.find('"').expect("a closing quote")]
}

fn number(element: &str, name: &str) -> f64 {
    attribute(element, name).parse().unwrap_or_else(|_| panic!("{name} of {element}"))
}

impl Plot {
    pub fn read(path: &Path) -> Self {
        let svg = std::fs::read_to_string(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
        let (mut drawn, mut names, mut ticks) = (Vec::<Drawn>::new(), Vec::new(), [Vec::new(), Vec::new()]);
        let mut colors = Vec::new();
        let mut lines = svg.lines().peekable();
        while let Some(element) = lines.next() {
            if element.starts_with("<text") {
                let text = lines.peek().expect("its text").trim();
                match (text.parse::<f64>(), attribute(element, "text-anchor")) {
                    (Ok(value), "middle") => ticks[0].push((value, number(element, "x"))),
                    (Ok(value), _) => ticks[1].push((value, number(element, "y"))),
                    (Err(_), "start") => names.push(text.to_owned()),
                    (Err(_), _) => {}
                }
            } else if element.starts_with("<polyline") && number(element, "stroke-width") > 1.0 {
                let pixel = |pair: &str| {
                    let (x, y) = pair.split_once(',').expect("a pair");
                    DVec2::new(x.parse().expect("a number"), y.parse().expect("a number"))
                };
                let line: Vec<DVec2> = attribute(element, "points").split_whitespace().map(pixel).collect();
                // Lines in the legend have two points.
                if line.len() > 2 {
                    drawn.push(Drawn { line, dots: Vec::new() });
                    colors.push(attribute(element, "stroke").to_owned());
                }
            } else if element.starts_with("<circle") {
                let last = drawn.last_mut().expect("its line");
                assert_eq!(attribute(element, "fill"), colors[colors.len() - 1], "a dot is of its line's color");
                last.dots.push(DVec2::new(number(element, "cx"), number(element, "cy")));
            }
        }
        let ends = |ticks: &Vec<(f64, f64)>| [ticks[0], ticks[ticks.len() - 1]];
        let mut apart = colors.clone();
        apart.sort();
        apart.dedup();
        assert_eq!(apart.len(), drawn.len(), "a color for each: {colors:?}");
        Self { drawn, names, axes: [ends(&ticks[0]), ends(&ticks[1])] }
    }

    /// Returns the pixel of a point, according to the axes' numbers.
    pub fn pixel(&self, (x, y): (f64, f64)) -> DVec2 {
        let on = |axis: usize, value: f64| {
            let [(low, from), (high, to)] = self.axes[axis];
            from + (value - low) / (high - low) * (to - from)
        };
        DVec2::new(on(0, x), on(1, y))
    }

    /// Whether a pixel is well inside the plot's frame.
    pub fn shows(&self, pixel: DVec2) -> bool {
        let truth = &self.drawn[0].line;
        truth[0].x + 2.0 < pixel.x && pixel.x < truth[truth.len() - 1].x - 2.0
    }

    /// Returns the distance in pixels between two lines in their common range, measured from each to the other.
    pub fn apart(&self, a: &[DVec2], b: &[DVec2]) -> f64 {
        self.off(a, b).max(self.off(b, a))
    }

    /// Returns the largest distance of the points from a line.
    pub fn off(&self, points: &[DVec2], line: &[DVec2]) -> f64 {
        let to_segment = |point: DVec2, from: DVec2, to: DVec2| {
            let way = to - from;
            let along = ((point - from).dot(way) / way.length_squared().max(1e-12)).clamp(0.0, 1.0);
            (from + along * way - point).length()
        };
        let to_line = |point: &DVec2| line.windows(2).map(|s| to_segment(*point, s[0], s[1])).fold(f64::MAX, f64::min);
        points.iter().filter(|point| self.shows(**point)).map(to_line).fold(0.0, f64::max)
    }
}
