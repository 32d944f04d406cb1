//! Splats from PLY files, in the format of Kerbl et al. 2023 (*3D Gaussian Splatting for Real-Time Radiance Field Rendering*), or
//! compressed by PlayCanvas.
//!
//! Kerbl's format: element `vertex` with `x y z`, `scale_0..2` (logarithms of deviations), `rot_0..3` (w, x, y, z, of any length),
//! `opacity` (before a logistic function) and `f_dc_0..2` (color as a spherical harmonic). PlayCanvas' format: element `chunk`, each with
//! the bounds of 256 splats, and element `vertex` with four words. The first word is the position and the second the scale, as numbers of
//! 11, 10 and 11 bits between the chunk's bounds. The third holds the three smaller components of the quaternion, 10 bits each. The fourth
//! is color and opacity, 8 bits each.

use crate::Result;
use crate::scene::files::input;
use crate::scene::files::ply::{self, PlyFile};
use crate::scene::files::splat_file::{self, Row, color_of, opacity_of};
use ply_rs_bw::ply::{Property, PropertyAccess, PropertyAccessResult};
use std::path::Path;

/// Properties of a PLY file of splats: `OPEN` for the first format; `PACKED`, and `BOUNDS` of chunks, for the second.
const OPEN: [&str; 18] = [
    "x",
    "y",
    "z",
    "scale_0",
    "scale_1",
    "rot_0",
    "rot_1",
    "rot_2",
    "rot_3",
    "opacity",
    "scale_2",
    "filter_3D",
    "f_dc_0",
    "f_dc_1",
    "f_dc_2",
    "red",
    "green",
    "blue",
];
/// Number of these that each file has. Flat splats (Huang et al. 2024, *2D Gaussian Splatting*) have no third scale, only Mip-Splatting
/// (Yu et al. 2024) has a filter, and colors may be bytes.
const LEAST_OPEN: usize = 10;
/// Where colors are, as harmonics and as bytes.
const HARMONICS: usize = 12;
const BYTES: usize = 15;
/// The comment of files from renderers that blend splats as Mip-Splatting does.
const MIP: &str = "SplatRenderMode: mip";
const PACKED: [&str; 4] = ["packed_position", "packed_rotation", "packed_scale", "packed_color"];
const BOUNDS: [&str; 18] = [
    "min_x",
    "min_y",
    "min_z",
    "max_x",
    "max_y",
    "max_z",
    "min_scale_x",
    "min_scale_y",
    "min_scale_z",
    "max_scale_x",
    "max_scale_y",
    "max_scale_z",
    "min_r",
    "min_g",
    "min_b",
    "max_r",
    "max_g",
    "max_b",
];
/// Number of bounds excluding colors. Older files lack color bounds; their colors range from 0 to 1.
const LEAST_BOUNDS: usize = 12;

/// Number of splats per chunk.
const CHUNK: usize = 256;

/// Returns whether a PLY file contains splats.
pub(in crate::scene) fn is_of_splats(file: &PlyFile) -> bool {
    file.has_scalar("vertex", PACKED[0]) || file.has_scalar("vertex", "rot_0") && file.has_scalar("vertex", "scale_0")
}

/// Numbers of a row, each at the index of its name in one of the lists above.
struct Numbers {
    of: [f64; 32],
}

impl PropertyAccess for Numbers {
    fn new() -> Self {
        Self { of: [0.0; 32] }
    }

    fn set_property(&mut self, name: &str, value: Property) -> PropertyAccessResult {
        let known = [&OPEN[..], &PACKED, &BOUNDS].into_iter().find_map(|names| names.iter().position(|n| *n == name));
        match (known, ply::scalar(&value)) {
            (Some(place), Some(value)) => self.of[place] = value,
            (None, _) => return PropertyAccessResult::Ignored,
            _ => {}
        }
        PropertyAccessResult::Set
    }
}

/// Reads rows of either kind and passes each to `take` with its index.
///
/// # Errors
/// [`Error::Input`](crate::Error::Input) if the file is unreadable or truncated, a property is missing, or there are too few chunks for the
/// splats.
pub(in crate::scene) fn load(path: &Path, notes: &mut Vec<String>, mut take: impl FnMut(usize, &Row)) -> Result<()> {
    let file = ply::open(path)?;
    if file.has_comment(MIP) {
        notes.push(format!("{}: {}", input::file_name(path), splat_file::ANTIALIASED));
    }
    if !file.has_scalar("vertex", PACKED[0]) {
        file.require_scalars("vertex", &OPEN[..LEAST_OPEN])?;
        let [is_thick, is_filtered] = [LEAST_OPEN, LEAST_OPEN + 1].map(|i| file.has_scalar("vertex", OPEN[i]));
        let [has_harmonics, has_bytes] = [HARMONICS, BYTES].map(|i| file.has_scalar("vertex", OPEN[i]));
        if is_filtered {
            notes.push(format!("{}: each splat is widened by its filter_3D", input::file_name(path)));
        }
        return file.read_rows(&["vertex"], |element, number, row: Numbers| {
            let mut of = row.of;
            if !is_thick {
                of[LEAST_OPEN] = f64::NEG_INFINITY;
            }
            if element == "vertex" {
                take(number, &open_row(&of, has_harmonics, has_bytes));
            }
            Ok(())
        });
    }
    file.require_scalars("vertex", &PACKED)?;
    file.require_scalars("chunk", &BOUNDS[..LEAST_BOUNDS])?;
    let has_colors = file.has_scalar("chunk", BOUNDS[LEAST_BOUNDS]);
    let mut chunks: Vec<[f64; 18]> = Vec::new();
    let lacking = file
        .error("splats stand before their chunks, or there are fewer than one for each 256", "write the file again");
    let mut lacking = Some(lacking);
    file.read_rows(&["chunk", "vertex"], |element, number, row: Numbers| {
        if element == "chunk" {
            let mut bounds: [f64; 18] = std::array::from_fn(|i| row.of[i]);
            if !has_colors {
                bounds[LEAST_BOUNDS..].copy_from_slice(&[0.0, 0.0, 0.0, 1.0, 1.0, 1.0]);
            }
            chunks.push(bounds);
        }
        if element != "vertex" {
            return Ok(());
        }
        match (chunks.get(number / CHUNK), lacking.take_if(|_| number / CHUNK >= chunks.len())) {
            (Some(bounds), _) => take(number, &packed_row(&row.of, bounds)),
            (None, Some(error)) => return Err(error),
            (None, None) => {}
        }
        Ok(())
    })
}

/// Decodes a row. Without any color it is grey.
fn open_row(n: &[f64; 32], has_harmonics: bool, has_bytes: bool) -> Row {
    let (deviations, filter) = ([n[3], n[4], n[10]].map(f64::exp), n[11]);
    // A splat that is widened keeps what it absorbs in all.
    let widened = deviations.map(|deviation| deviation.hypot(filter));
    let kept = if filter == 0.0 { 1.0 } else { deviations.iter().product::<f64>() / widened.iter().product::<f64>() };
    Row {
        position: [n[0], n[1], n[2]],
        deviations: widened,
        rotation: [n[6], n[7], n[8], n[5]],
        opacity: kept / (1.0 + (-n[9]).exp()),
        color: match (has_harmonics, has_bytes) {
            (false, true) => [n[15], n[16], n[17]].map(|byte| byte / 255.0),
            _ => color_of([n[12], n[13], n[14]]),
        },
    }
}

fn packed_row(n: &[f64; 32], bounds: &[f64; 18]) -> Row {
    let [position, turn, scale, color] = [0, 1, 2, 3].map(|i| n[i] as u32);
    let between = |share: f64, low: usize, high: usize| bounds[low] + share * (bounds[high] - bounds[low]);
    let three = |word: u32, first: usize| {
        let shares =
            [f64::from(word >> 21) / 2047.0, f64::from(word >> 11 & 1023) / 1023.0, f64::from(word & 2047) / 2047.0];
        [0, 1, 2].map(|i| between(shares[i], first + i, first + 3 + i))
    };
    let share = |i: u32| f64::from(color >> (24 - 8 * i) & 255) / 255.0;
    Row {
        position: three(position, 0),
        deviations: three(scale, 6).map(f64::exp),
        rotation: smallest_three(turn),
        opacity: opacity_of(f64::from(color & 255)),
        color: [0, 1, 2].map(|i| between(share(i), 12 + i as usize, 15 + i as usize)),
    }
}

/// Decodes a quaternion. The top bits select the component of greatest magnitude among w, x, y, z; the other three follow in this order,
/// each as 10 bits that span −1/√2 to 1/√2.
fn smallest_three(word: u32) -> [f64; 4] {
    let number = |shift: u32| (f64::from(word >> shift & 1023) / 1023.0 - 0.5) * 2.0_f64.sqrt();
    let others = [number(20), number(10), number(0)];
    let greatest = (1.0 - others.iter().map(|x| x * x).sum::<f64>()).max(0.0).sqrt();
    let mut left = others.into_iter();
    let mut wxyz = [greatest; 4];
    for (i, place) in wxyz.iter_mut().enumerate() {
        if i != (word >> 30) as usize {
            *place = left.next().unwrap_or_default();
        }
    }
    [wxyz[1], wxyz[2], wxyz[3], wxyz[0]]
}
