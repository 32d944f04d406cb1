//! Rows of the splats of a glTF file, placed by a node.

use crate::scene::files::gltf_accessor;
use crate::scene::files::gltf_document::GltfDocument;
use crate::scene::files::gltf_splats::{Color, Opacity, Source, Splats};
use crate::scene::files::splat_file::{Row, color_of};
use crate::scene::files::spz_file;
use glam::{DMat3, DMat4, DQuat, DVec3};
use gltf::accessor::{DataType, Dimensions};
use nalgebra::Matrix3;

type Checked<T> = Result<T, String>;

/// How far a node's axes may be from equal lengths and right angles to count as such, as a share.
const UNEVEN: f64 = 1e-9;

const UNSIGNED: [DataType; 3] = [DataType::F32, DataType::U8, DataType::U16];
const SIGNED: [DataType; 3] = [DataType::F32, DataType::I8, DataType::I16];

/// Reads the splats of a primitive and passes each, as the node places it, to `take` with its index.
///
/// # Errors
/// A message if an accessor is missing, damaged or of the wrong kind, or the SPZ file is damaged.
pub(super) fn load(
    file: &GltfDocument,
    splats: &Splats,
    to_world: DMat4,
    notes: &mut Vec<String>,
    mut take: impl FnMut(usize, &Row),
) -> Checked<()> {
    let place = Place::new(to_world);
    let mut take = |number: usize, row: Row| {
        let color = if splats.is_linear { row.color.map(to_display) } else { row.color };
        take(number, &place.placed(&Row { color, ..row }));
    };
    match splats.source {
        Source::Spz { view } => {
            let view = file.document.views().nth(view).ok_or_else(|| format!("there is no buffer view {view}"))?;
            let bytes = gltf_accessor::view_bytes(&file.buffers, &view).ok_or("its view reaches beyond its buffer")?;
            spz_file::load(bytes, notes, |number, row| take(number, *row))
        }
        Source::Accessors { position, rotation, scale, opacity, color } => {
            let positions = numbers::<3>(file, position, "POSITION", &gltf_accessor::NUMBERS)?;
            let rotations = numbers::<4>(file, rotation, "ROTATION", &SIGNED)?;
            let scales = numbers::<3>(file, scale, "SCALE", &UNSIGNED)?;
            let opacities = match opacity {
                Opacity::Alone(index) => numbers::<1>(file, index, "OPACITY", &UNSIGNED)?,
                Opacity::OfColor(index) => colors(file, index)?.into_iter().map(|[_, _, _, a]| [a]).collect(),
            };
            let colors = match color {
                Color::Harmonic(index) => {
                    numbers::<3>(file, index, "SH_DEGREE_0_COEF_0", &UNSIGNED)?.into_iter().map(color_of).collect()
                }
                Color::Plain(index) => {
                    colors(file, index)?.into_iter().map(|[r, g, b, _]| [r, g, b]).collect::<Vec<_>>()
                }
            };
            let counts = [positions.len(), rotations.len(), scales.len(), opacities.len(), colors.len()];
            if counts.iter().any(|count| *count != counts[0]) {
                return Err(format!("its attributes have {counts:?} splats"));
            }
            for (number, position) in positions.into_iter().enumerate() {
                let [opacity] = opacities[number];
                let (rotation, color) = (rotations[number], colors[number]);
                take(number, Row { position, deviations: scales[number], rotation, opacity, color });
            }
            Ok(())
        }
    }
}

/// Returns the numbers of the accessor with this index.
fn numbers<const N: usize>(
    file: &GltfDocument,
    index: usize,
    name: &str,
    types: &[DataType],
) -> Checked<Vec<[f64; N]>> {
    let accessor = file.document.accessors().nth(index).ok_or_else(|| format!("{name} has no accessor"))?;
    let dimensions = match N {
        1 => Dimensions::Scalar,
        3 => Dimensions::Vec3,
        _ => Dimensions::Vec4,
    };
    let elements = gltf_accessor::elements(file, &accessor, dimensions, types);
    let elements = elements.map_err(|cause| format!("{name} {cause}"))?;
    Ok(elements.iter().map(|element| gltf_accessor::numbers(&accessor, element)).collect())
}

/// Returns `COLOR_0`, whose alpha is 1 if it has none.
fn colors(file: &GltfDocument, index: usize) -> Checked<Vec<[f64; 4]>> {
    let has_alpha = file.document.accessors().nth(index).is_some_and(|of| of.dimensions() == Dimensions::Vec4);
    if has_alpha {
        return numbers(file, index, "COLOR_0", &UNSIGNED);
    }
    Ok(numbers::<3>(file, index, "COLOR_0", &UNSIGNED)?.into_iter().map(|[r, g, b]| [r, g, b, 1.0]).collect())
}

/// Converts a linear color channel to sRGB, in which other formats have colors.
fn to_display(linear: f64) -> f64 {
    if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
}

/// A node's place in the world.
struct Place {
    to_world: DMat4,
    axes: DMat3,
    /// The turn and the scale, if axes are at right angles and of one length.
    even: Option<(DQuat, f64)>,
}

impl Place {
    fn new(to_world: DMat4) -> Self {
        let axes = DMat3::from_mat4(to_world);
        let scale = axes.x_axis.length();
        let [x, y, z] = [axes.x_axis, axes.y_axis, axes.z_axis].map(|axis| axis / scale);
        let near = |a: f64, b: f64| (a - b).abs() < UNEVEN;
        let is_even = near(y.length(), 1.0)
            && near(z.length(), 1.0)
            && near(x.dot(y), 0.0)
            && near(y.dot(z), 0.0)
            && near(z.dot(x), 0.0);
        // A splat is the same from the opposite side, and so a mirror is a turn.
        let turn = DMat3::from_cols(x, y, z) * axes.determinant().signum();
        Self { to_world, axes, even: is_even.then(|| (DQuat::from_mat3(&turn), scale)) }
    }

    fn placed(&self, row: &Row) -> Row {
        let position = self.to_world.transform_point3(row.position.into()).to_array();
        let rotation = DQuat::from_array(row.rotation);
        if let Some((turn, scale)) = self.even {
            let rotation = (turn * rotation).to_array();
            return Row { position, deviations: row.deviations.map(|d| d * scale), rotation, ..*row };
        }
        // Deviations that are none stay so.
        if !row.deviations.iter().all(|deviation| *deviation >= 0.0 && deviation.is_finite()) {
            return Row { position, ..*row };
        }
        // The axes of the ellipsoid that a skewed one becomes.
        let Some(unit) = Some(rotation.normalize()).filter(|unit| unit.is_finite()) else { return *row };
        let skewed = self.axes * DMat3::from_quat(unit) * DMat3::from_diagonal(DVec3::from_array(row.deviations));
        let found = Matrix3::from_column_slice(&skewed.to_cols_array()).svd(true, false);
        let Some(mut axes) = found.u else { return *row };
        if axes.determinant() < 0.0 {
            axes = -axes;
        }
        let columns: [f64; 9] = std::array::from_fn(|i| axes.as_slice()[i]);
        let rotation = DQuat::from_mat3(&DMat3::from_cols_array(&columns)).to_array();
        Row { position, deviations: std::array::from_fn(|i| found.singular_values[i]), rotation, ..*row }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The covariance of a splat, which is all of its shape.
    fn covariance(row: &Row) -> DMat3 {
        let half = DMat3::from_quat(DQuat::from_array(row.rotation).normalize())
            * DMat3::from_diagonal(DVec3::from_array(row.deviations));
        half * half.transpose()
    }

    /// A node turns, mirrors, stretches and skews a splat as it does space.
    #[test]
    fn nodes_place_splats() {
        let row = Row {
            position: [1.0, 2.0, 3.0],
            deviations: [0.5, 0.25, 0.125],
            rotation: [0.1, 0.7, -0.3, 0.6],
            opacity: 0.5,
            color: [0.5; 3],
        };
        let turn = DQuat::from_axis_angle(DVec3::new(1.0, 2.0, 3.0).normalize(), 1.0);
        let at = |scale: DVec3| DMat4::from_scale_rotation_translation(scale, turn, DVec3::new(4.0, 5.0, 6.0));
        let skew = DMat4::from_mat3(DMat3::from_cols(DVec3::X, DVec3::new(0.5, 2.0, 0.0), DVec3::Z));
        let all =
            [at(DVec3::splat(3.0)), at(DVec3::splat(-2.0)), at(DVec3::new(1.0, -2.0, 3.0)), at(DVec3::ONE) * skew];
        for to_world in all {
            let (place, axes) = (Place::new(to_world), DMat3::from_mat4(to_world));
            let found = place.placed(&row);
            let expected = axes * covariance(&row) * axes.transpose();
            assert!(covariance(&found).abs_diff_eq(expected, 1e-9), "{} for {expected}", covariance(&found));
            let position = to_world.transform_point3(DVec3::from_array(row.position));
            assert!((DVec3::from_array(found.position) - position).length() < 1e-12);
        }
        assert!(Place::new(at(DVec3::splat(-2.0))).even.is_some() && Place::new(skew).even.is_none());
    }
}
