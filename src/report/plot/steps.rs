//! Step counts of look-ups as colors.

/// Step counts of one picture, rows from the top; `None` for pixels without a mesh.
pub type Counts = Vec<Option<u32>>;

/// Colors from few to many steps, sRGB: the ends and the middle of cividis, which looks the same with any color vision (Nuñez, Anderton and
/// Renslow 2018).
const COLORS: [[f64; 3]; 3] = [[0.0, 32.0, 77.0], [124.0, 123.0, 120.0], [255.0, 234.0, 70.0]];

/// Color of pixels without a mesh.
const NOTHING: [u8; 3] = [0; 3];

/// Returns the color for a share from 0 to 1.
pub fn step_color(share: f64) -> [u8; 3] {
    let at = 2.0 * share;
    let [from, to] = if at < 1.0 { [COLORS[0], COLORS[1]] } else { [COLORS[1], COLORS[2]] };
    let share = if at < 1.0 { at } else { at - 1.0 };
    [0, 1, 2].map(|i| (from[i] + share * (to[i] - from[i])).round() as u8)
}

/// The minimum, mean and maximum of step counts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepRange {
    least: u32,
    mean: f64,
    most: u32,
}

impl StepRange {
    /// Computes the range over several pictures; `None` if they show no mesh.
    pub fn of(pictures: &[Counts]) -> Option<Self> {
        let all = || pictures.iter().flatten().flatten().copied();
        let mean = all().map(f64::from).sum::<f64>() / all().count() as f64;
        Some(Self { least: all().min()?, mean, most: all().max()? })
    }

    /// Returns the minimum and the maximum.
    pub fn ends(self) -> [u32; 2] {
        [self.least, self.most]
    }

    /// Colors `counts` on the scale of `range`, three bytes per pixel.
    pub fn paint(range: Option<Self>, counts: &[Option<u32>]) -> Vec<u8> {
        let (least, most) = range.map_or((0, 1), |range| (range.least, range.most));
        let color = |count: u32| step_color(f64::from(count - least) / f64::from((most - least).max(1)));
        counts.iter().flat_map(|count| count.map_or(NOTHING, color)).collect()
    }
}

impl std::fmt::Display for StepRange {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { least, mean, most } = self;
        write!(f, "steps of a pixel's look-ups: {least} (dark blue) to {most} (yellow), {mean:.2} in the mean")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dark_blue_to_yellow() {
        let pictures = [vec![Some(2), None], vec![Some(10), Some(6)]];
        let range = StepRange::of(&pictures).expect("counts");
        assert_eq!(range, StepRange { least: 2, mean: 6.0, most: 10 });
        assert_eq!(StepRange::paint(Some(range), &pictures[0]), [0, 32, 77, 0, 0, 0]);
        assert_eq!(StepRange::paint(Some(range), &pictures[1]), [255, 234, 70, 124, 123, 120]);
        assert_eq!(StepRange::of(&[vec![None]]), None);
        assert_eq!(StepRange::paint(None, &[None]), [0, 0, 0]);
        assert_eq!(StepRange::paint(StepRange::of(&[vec![Some(3)]]), &[Some(3)]), [0, 32, 77]);
    }
}
