//! A rolling chart of pass times, frame by frame.

use crate::gpu::PassTime;
use std::collections::{BTreeMap, VecDeque};

/// Number of frames kept.
const FRAMES: usize = 120;

/// Colors of passes: Okabe and Ito 2008, distinguishable with any color vision.
const COLORS: [[u8; 3]; 7] =
    [[230, 159, 0], [86, 180, 233], [0, 158, 115], [240, 228, 66], [0, 114, 178], [213, 94, 0], [204, 121, 167]];

/// Nanoseconds of each pass, for the last frames that had any passes.
#[derive(Default)]
pub struct Chart(VecDeque<BTreeMap<String, f64>>);

impl Chart {
    /// Adds the passes of a completed frame.
    pub fn add(&mut self, passes: &[PassTime]) {
        if passes.is_empty() {
            return;
        }
        let mut all = BTreeMap::new();
        for pass in passes {
            *all.entry(pass.name.clone()).or_insert(0.0) += pass.end_ns - pass.start_ns;
        }
        self.0.push_back(all);
        if self.0.len() > FRAMES {
            self.0.pop_front();
        }
    }

    /// Returns the name and latest time of each pass, sorted by the sum over all frames, largest first.
    fn passes(&self) -> Vec<(String, Option<f64>)> {
        let mut sums: BTreeMap<&str, f64> = BTreeMap::new();
        for (name, ns) in self.0.iter().flatten() {
            *sums.entry(name).or_insert(0.0) += ns;
        }
        let mut all: Vec<_> = sums.into_iter().collect();
        all.sort_by(|a, b| b.1.total_cmp(&a.1));
        let newest = |name: &str| self.0.iter().rev().find_map(|frame| frame.get(name).copied());
        all.into_iter().map(|(name, _)| (name.to_owned(), newest(name))).collect()
    }

    /// Draws the chart.
    pub fn show(&self, ui: &mut egui::Ui) {
        let passes = self.passes();
        let most = self.0.iter().map(|frame| frame.values().sum::<f64>()).fold(1.0, f64::max);
        let size = egui::vec2(ui.available_width(), 70.0);
        let (place, _) = ui.allocate_exact_size(size, egui::Sense::hover());
        ui.painter().rect_filled(place, 0.0, ui.visuals().extreme_bg_color);
        let width = place.width() / FRAMES as f32;
        let color = |i: usize| {
            let [r, g, b] = COLORS[i.min(COLORS.len() - 1)];
            egui::Color32::from_rgb(r, g, b)
        };
        for (i, frame) in self.0.iter().enumerate() {
            let left = place.left() + width * i as f32;
            let mut bottom = place.bottom();
            for (pass, (name, _)) in passes.iter().enumerate() {
                let Some(ns) = frame.get(name) else { continue };
                let top = bottom - place.height() * (ns / most) as f32;
                let bar = egui::Rect::from_min_max(egui::pos2(left, top), egui::pos2(left + width, bottom));
                ui.painter().rect_filled(bar, 0.0, color(pass));
                bottom = top;
            }
        }
        ui.label(format!("highest frame {:.2} ms", most / 1e6));
        for (i, (name, ns)) in passes.iter().enumerate().take(10) {
            let Some(ns) = ns else { continue };
            ui.colored_label(color(i), format!("{name} {:.3} ms", ns / 1e6));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_rolls() {
        let mut chart = Chart::default();
        let pass = |name: &str, ns: f64| PassTime {
            name: name.into(),
            start_ns: 10.0,
            end_ns: 10.0 + ns,
            raster: false,
            began: 0,
            counts: None,
        };
        chart.add(&[]);
        assert!(chart.0.is_empty(), "frames without passes do not count");
        for _ in 0..FRAMES {
            chart.add(&[pass("a", 1.0), pass("b", 5.0), pass("a", 2.0)]);
        }
        chart.add(&[pass("a", 7.0)]);
        assert_eq!(chart.0.len(), FRAMES);
        assert_eq!(chart.passes(), [("b".into(), Some(5.0)), ("a".into(), Some(7.0))]);
    }
}
