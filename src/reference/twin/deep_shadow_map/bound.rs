//! CPU twin of glsl/technique/deep_shadow_map/bound.glsl: chooses nodes greedily, as few as an error bound allows.

/// If optical depth rises by more than this between two points, points between them are checked too. Twin: RISE.
pub const RISE: f32 = 0.25;

/// Part of the allowed error that is reserved for errors between checked points. Twin: BETWEEN.
const BETWEEN: f32 = 1.0 / 64.0;

/// Error bound for the last node's transmittance. Twin: TAIL.
const TAIL: f32 = 1e-4;

/// Returns the optical depth beyond which so little light is left that points between nodes need no check. Twin: dark_from.
pub fn dark_from(error: f32) -> f32 {
    5.0 - (2.0 * error).ln()
}

/// Returns the range of optical depths whose transmittance is within `error` of the transmittance of `value`. Twin: window.
fn window(value: f32, error: f32) -> [f32; 2] {
    let through = (-value).exp();
    let low = -(through + error).min(1.0).ln();
    // If `error` is more than half of the light left, the bound is the tangent to the exact bound. The exact bound is curved: a line below
    // it at two points may exceed it between them.
    let high = if through >= 2.0 * error {
        -(through - error).ln()
    } else {
        2.0 * value + (2.0 * error).ln() * 2.0 - error.ln()
    };
    [low.max(0.0), high]
}

/// Chooses nodes as the points of a curve arrive in order.
pub struct Lines {
    error: f32,
    /// Optical depth of the whole curve.
    total: f32,
    all: Vec<(f32, f32)>,
    /// Minimum and maximum slope of a line from the last node that passes through the windows of all points since then.
    slopes: [f32; 2],
    /// The last point.
    end: (f32, f32),
}

impl Lines {
    /// Starts a curve without nodes, whose total optical depth is `total`.
    pub fn new(error: f32, total: f32) -> Self {
        Self { error: error * (1.0 - BETWEEN), total, all: Vec::new(), slopes: [0.0, f32::MAX], end: (0.0, 0.0) }
    }

    pub fn nodes(self) -> Vec<(f32, f32)> {
        self.all
    }

    fn start(&mut self, node: (f32, f32)) {
        self.all.push(node);
        self.slopes = [0.0, f32::MAX];
        self.end = node;
    }

    /// Ends the line at the last point's depth, as close to the point as the slopes allow. Twin: line_end.
    fn finish(&mut self) {
        let (depth, value) = self.all[self.all.len() - 1];
        let along = self.end.0 - depth;
        if along > 0.0 {
            let aim = self.end.1.clamp(value + self.slopes[0] * along, value + self.slopes[1] * along);
            self.start((self.end.0, aim));
        }
    }

    /// Twin: line_point.
    pub fn point(&mut self, depth: f32, value: f32, is_last: bool) {
        let [low, high] = window(value, if is_last { self.error.min(TAIL) } else { self.error });
        let high = high.min(self.total.max(value));
        if self.all.is_empty() {
            self.start((depth, value));
            return;
        }
        let from = self.all[self.all.len() - 1];
        if depth > from.0 {
            let along = depth - from.0;
            let slopes = [self.slopes[0].max((low - from.1) / along), self.slopes[1].min((high - from.1) / along)];
            if slopes[0] <= slopes[1] {
                self.slopes = slopes;
                self.end = (depth, value);
                if is_last {
                    self.finish();
                }
                return;
            }
            self.finish();
        }
        let from = self.all[self.all.len() - 1];
        if depth > from.0 {
            // The last line has just ended, so only this window bounds the next one.
            let along = depth - from.0;
            self.slopes = [((low - from.1) / along).max(0.0), (high - from.1) / along];
            self.end = (depth, value);
            if is_last {
                self.finish();
            }
        } else if !(low..=high).contains(&from.1) {
            self.step(depth, value);
        }
    }

    /// Adds a step at the depth of the last node. A first step needs no node in front of it; if several steps share a depth, only the last
    /// counts.
    fn step(&mut self, depth: f32, value: f32) {
        let count = self.all.len();
        if count == 1 || self.all[count - 2].0 == depth {
            self.all.pop();
        }
        self.start((depth, value.max(self.all.last().map_or(0.0, |node| node.1))));
    }
}
