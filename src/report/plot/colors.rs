//! Colors of techniques and passes in plots and on the page.

use plotters::style::RGBColor;

/// The colors of Okabe and Ito without yellow, which is too light for lines. They are distinguishable with any color vision.
pub(in crate::report) const COLORS: [RGBColor; 6] = [
    RGBColor(0x00, 0x72, 0xb2),
    RGBColor(0xd5, 0x5e, 0x00),
    RGBColor(0x00, 0x9e, 0x73),
    RGBColor(0xcc, 0x79, 0xa7),
    RGBColor(0xe6, 0x9f, 0x00),
    RGBColor(0x56, 0xb4, 0xe9),
];

/// Lightness range and largest chroma of colors that stand out from both light and dark pages without glare.
const LIGHTNESS: std::ops::RangeInclusive<f64> = 0.43..=0.88;
const LARGEST_CHROMA: f64 = 0.18;
/// Step between the values allowed for a channel.
const CHANNEL_STEP: usize = 17;

/// Matrices that map linear RGB to its appearance without the long-wave cones, and without the medium-wave cones: Machado, Oliveira and
/// Fernandes 2009, A Physiologically-based Model for Simulation of Color Vision Deficiency, severity 1.
const PROTANOPIA: [[f64; 3]; 3] =
    [[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216], [-0.003882, -0.048116, 1.051998]];
const DEUTERANOPIA: [[f64; 3]; 3] =
    [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.011820, 0.042940, 0.968881]];

/// A color in OKLab, as seen with full color vision and with each kind of red–green blindness.
type Seen = [[f64; 3]; 3];

/// Returns `count` colors, all different up to a thousand. Each is as far as possible from all colors before it. The distance to the
/// previous color counts half, since these two often stand side by side. A longer list begins with the same colors.
pub(in crate::report) fn distinct(count: usize) -> Vec<RGBColor> {
    beside(&[], count)
}

/// Returns [`COLORS`], followed by as many more as needed, far from these and from each other.
pub(in crate::report) fn named(count: usize) -> Vec<RGBColor> {
    let more = beside(&COLORS, count.saturating_sub(COLORS.len()));
    COLORS.into_iter().chain(more).take(count).collect()
}

fn beside(known: &[RGBColor], count: usize) -> Vec<RGBColor> {
    let mut candidates: Vec<(RGBColor, Seen, f64)> = Vec::new();
    let channel = || (0..=u8::MAX).step_by(CHANNEL_STEP);
    for color in channel().flat_map(|r| channel().flat_map(move |g| channel().map(move |b| RGBColor(r, g, b)))) {
        let seen = seen(color);
        let [lightness, a, b] = seen[0];
        if LIGHTNESS.contains(&lightness) && a.hypot(b) <= LARGEST_CHROMA {
            let nearest = known.iter().map(|&known| distance(&seen, &self::seen(known))).fold(f64::INFINITY, f64::min);
            candidates.push((color, seen, nearest));
        }
    }
    let mut colors = Vec::new();
    let mut before: Option<Seen> = None;
    while colors.len() < count {
        let score = |(_, seen, nearest): &(RGBColor, Seen, f64)| {
            before.map_or(*nearest, |before| nearest.min(distance(seen, &before) / 2.0))
        };
        let Some(&(color, chosen, _)) = candidates.iter().max_by(|a, b| score(a).total_cmp(&score(b))) else { break };
        for (_, seen, nearest) in &mut candidates {
            *nearest = nearest.min(distance(seen, &chosen));
        }
        colors.push(color);
        before = Some(chosen);
    }
    colors
}

/// Returns the distance between two colors for the kind of vision that sees the smallest difference. With full color vision the distance
/// counts half, since colors there differ in one more dimension.
fn distance(a: &Seen, b: &Seen) -> f64 {
    let [full, without_long, without_medium] = [0, 1, 2].map(|eye| euclidean(a[eye], b[eye]));
    (full / 2.0).min(without_long).min(without_medium)
}

fn euclidean(a: [f64; 3], b: [f64; 3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt()
}

fn seen(RGBColor(red, green, blue): RGBColor) -> Seen {
    let linear = [red, green, blue].map(|channel| {
        let encoded = f64::from(channel) / 255.0;
        if encoded <= 0.04045 { encoded / 12.92 } else { ((encoded + 0.055) / 1.055).powf(2.4) }
    });
    let without = |matrix| times(matrix, linear).map(|value: f64| value.clamp(0.0, 1.0));
    [linear, without(&PROTANOPIA), without(&DEUTERANOPIA)].map(oklab)
}

/// Converts linear RGB to OKLab. Ottosson 2020, A perceptual color space for image processing.
fn oklab(linear: [f64; 3]) -> [f64; 3] {
    const TO_CONES: [[f64; 3]; 3] = [
        [0.4122214708, 0.5363325363, 0.0514459929],
        [0.2119034982, 0.6806995451, 0.1073969566],
        [0.0883024619, 0.2817188376, 0.6299787005],
    ];
    const TO_LAB: [[f64; 3]; 3] = [
        [0.2104542553, 0.7936177850, -0.0040720468],
        [1.9779984951, -2.4285922050, 0.4505937099],
        [0.0259040371, 0.7827717662, -0.8086757660],
    ];
    times(&TO_LAB, times(&TO_CONES, linear).map(f64::cbrt))
}

fn times(matrix: &[[f64; 3]; 3], vector: [f64; 3]) -> [f64; 3] {
    matrix.map(|row| row.iter().zip(vector).map(|(m, v)| m * v).sum())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// sRGB's red, green and blue must have the OKLab values of CSS Color 4, to all its digits. A grey must look the same with any color
    /// vision.
    #[test]
    fn known_colors() {
        let known = [
            (RGBColor(255, 0, 0), [0.62796, 0.22486, 0.12585]),
            (RGBColor(0, 255, 0), [0.86644, -0.23389, 0.17950]),
            (RGBColor(0, 0, 255), [0.45201, -0.03246, -0.31153]),
        ];
        for (color, lab) in known {
            assert!(euclidean(seen(color)[0], lab) < 2e-5, "{:?}, not {lab:?}", seen(color)[0]);
        }
        for grey in [0, 119, 255].map(|value| seen(RGBColor(value, value, value))) {
            assert!(grey.iter().all(|eye| euclidean(*eye, [grey[0][0], 0.0, 0.0]) < 1e-4), "{grey:?}");
        }
        // A red and a green of the same lightness: far apart for most people, the same olive for one man in ten.
        let [red, green] = [RGBColor(0xa5, 0x60, 0x18), RGBColor(0x6f, 0x76, 0x00)].map(seen);
        let [full, _, without_medium] = [0, 1, 2].map(|eye| euclidean(red[eye], green[eye]));
        assert!(without_medium < full / 3.0, "{full} {without_medium}");
    }

    /// The smallest difference in OKLab that is visible side by side is about 0.02. Any two of forty colors must be at least 0.07 apart, or
    /// 0.035 with red–green blindness. Any two in succession must be at least 0.15 apart, or 0.08 with red–green blindness.
    #[test]
    fn forty_are_told_apart() {
        let colors = distinct(40);
        assert_eq!((colors.len(), &colors[..7]), (40, &distinct(7)[..]));
        let eyes: Vec<Seen> = colors.into_iter().map(seen).collect();
        for (place, one) in eyes.iter().enumerate() {
            for (before, other) in eyes[..place].iter().enumerate() {
                let (full, blind) = if before + 1 == place { (0.15, 0.08) } else { (0.07, 0.035) };
                for (eye, least) in [(0, full), (1, blind), (2, blind)] {
                    let apart = euclidean(one[eye], other[eye]);
                    assert!(apart >= least, "{before} and {place} are {apart} apart for eye {eye}");
                }
            }
        }
    }
}
