//! The curve under the pointer, as plotted in the panel.

use super::rays::PickedRay;
use crate::bench::RayPoints;
use egui::{Color32, Pos2, Rect, Shape, Stroke, Ui, pos2, vec2};

/// Colors of A and B: Okabe and Ito 2008, as in plots written to files.
const COLORS: [Color32; 2] = [Color32::from_rgb(0x56, 0xb4, 0xe9), Color32::from_rgb(0xe6, 0x9f, 0x00)];

/// Plots the curve: the truth, each technique's line with its nodes as dots, and a vertical line at the depth of the visible point.
pub fn plot(ui: &mut Ui, found: &PickedRay) {
    let size = vec2(ui.available_width(), 150.0);
    let (place, _) = ui.allocate_exact_size(size, egui::Sense::hover());
    let painter = ui.painter().with_clip_rect(place);
    painter.rect_filled(place, 0.0, ui.visuals().extreme_bg_color);
    let range = found.ray.range();
    let at = |point: &(f64, f64)| point_of(place, &range, *point);
    let grey = ui.visuals().weak_text_color();
    let seen = at(&(found.depth, 0.0)).x;
    painter.vline(seen, place.y_range(), Stroke::new(1.0, grey));
    let line = |points: &RayPoints, width: f32, color: Color32| {
        Shape::line(points.iter().map(at).collect(), Stroke::new(width, color))
    };
    let (truth, color_of_truth) = (&found.ray.truth, ui.visuals().strong_text_color());
    painter.add(line(truth, 3.0, color_of_truth));
    for (i, said) in found.ray.lines.iter().enumerate() {
        let color = COLORS[i.min(1)];
        painter.add(line(&said.points, 1.5, color));
        for node in &said.nodes {
            painter.circle_filled(at(node), 3.0, color);
        }
    }
    let (is, said) = found.there();
    ui.colored_label(color_of_truth, format!("true, at what is seen {is:.4}"));
    for (i, (name, said)) in found.names.iter().zip(said).enumerate() {
        let nodes = match found.ray.lines[i].nodes.len() {
            0 => String::new(),
            nodes => format!(", {nodes} nodes"),
        };
        ui.colored_label(COLORS[i.min(1)], format!("{name} {said:.4}{nodes}"));
    }
    let [x, y] = found.texel;
    let color = if found.is_red { " in red" } else { "" };
    ui.label(format!("light 0{color}, texel {x},{y}: {} segments", found.ray.segments));
}

/// Returns the plot position of (depth, transmittance).
fn point_of(place: Rect, range: &std::ops::Range<f64>, (depth, through): (f64, f64)) -> Pos2 {
    let across = (depth - range.start) / (range.end - range.start).max(1e-9);
    let (across, up) = (across as f32, (through / 1.02) as f32);
    pos2(place.left() + across * place.width(), place.bottom() - up * place.height())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Transmittance 0 must be at the bottom and 1 slightly below the top, and the range must span the full width.
    #[test]
    fn corners_are_corners() {
        let place = Rect::from_min_max(pos2(10.0, 20.0), pos2(110.0, 122.0));
        let at = |depth, through| point_of(place, &(0.25..0.75), (depth, through));
        assert_eq!(
            (at(0.25, 0.0), at(0.75, 0.0), at(0.5, 0.0)),
            (pos2(10.0, 122.0), pos2(110.0, 122.0), pos2(60.0, 122.0))
        );
        assert!((at(0.25, 1.0).y - 22.0).abs() < 1e-3);
    }
}
