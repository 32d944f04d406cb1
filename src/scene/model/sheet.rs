//! See-through triangles as casters. A sheet absorbs its light in one step, where a ray crosses the triangle. The caster holds a sphere
//! around the triangle, the triangle's number, and its greatest optical depth; corners and alpha are read from the meshes.

use super::splat::EXPONENT;
use crate::scene::{Alpha, Caster, MAX_OPTICAL_DEPTH, Mesh, Scene};
use glam::DVec3;

/// The exponent bits of 2^102 in a caster's axis mark a sheet. Twin: SHEET_MARK.
const MARK: u32 = 0x7280_0000;

/// Keeps the lower half of a triangle's number from being a denormal. Twin: SHEET_NUMBER.
const NUMBER: u32 = 0x3F80_0000;

/// Enlarges the sphere by more than its centre and radius are rounded by.
const MARGIN: f64 = 1e-6;

impl Caster {
    /// Creates the caster of a see-through triangle; `number`: of the triangle, among all meshes'; `most`: its greatest optical depth.
    fn sheet(number: u32, corners: [DVec3; 3], most: f32) -> Self {
        let (centre, radius) = sphere(corners);
        let farthest = corners.iter().fold(0.0, |far: f64, corner| far.max(corner.abs().max_element()));
        Self {
            position: centre.as_vec3().into(),
            radius: (radius + MARGIN * (radius + farthest)) as f32,
            axis: [f32::from_bits(MARK | number >> 16), f32::from_bits(NUMBER | number & 0xFFFF), most],
            density: most,
        }
    }

    /// Returns whether the caster is a see-through triangle.
    pub fn is_sheet(&self) -> bool {
        self.axis[0].to_bits() & EXPONENT == MARK
    }

    /// Returns the number of a sheet's triangle, counted over all meshes.
    pub fn sheet_triangle(&self) -> u32 {
        (self.axis[0].to_bits() & 0xFFFF) << 16 | self.axis[1].to_bits() & 0xFFFF
    }
}

/// Returns a sphere around a triangle, with its centre in the triangle's plane.
fn sphere([a, b, c]: [DVec3; 3]) -> (DVec3, f64) {
    // The longest side is the diameter, unless the third corner lies outside that sphere.
    let sides = [[a, b, c], [b, c, a], [c, a, b]];
    let length = |side: &[DVec3; 3]| side[0].distance_squared(side[1]);
    let [from, to, third] = sides.into_iter().max_by(|x, y| length(x).total_cmp(&length(y))).unwrap_or(sides[0]);
    let middle = 0.5 * (from + to);
    let radius = 0.5 * from.distance(to);
    if middle.distance(third) <= radius {
        return (middle, radius);
    }
    // The centre of the circle through all corners.
    let (ab, ac) = (b - a, c - a);
    let normal = ab.cross(ac);
    let centre = a
        + (ac.length_squared() * normal.cross(ab) + ab.length_squared() * ac.cross(normal))
            / (2.0 * normal.length_squared());
    (centre, [a, b, c].iter().fold(0.0, |radius: f64, corner| radius.max(centre.distance(*corner))))
}

/// Returns the greatest optical depth of a see-through triangle: that of its greatest factor and of the whole texture's greatest alpha,
/// which is `texels`.
fn most(alpha: &Alpha, triangle: &[u32; 3], texels: f64) -> f32 {
    let factor = |i: &u32| alpha.factors.get(*i as usize).copied().unwrap_or(1.0);
    let factor: f64 = triangle.iter().map(factor).fold(0.0, f32::max).into();
    (-(-(factor * texels).min(1.0)).ln_1p()).min(MAX_OPTICAL_DEPTH.into()) as f32
}

fn of_mesh(mesh: &Mesh, first: usize) -> impl Iterator<Item = Caster> + '_ {
    let alpha = mesh.alpha.as_ref().filter(|_| mesh.is_see_through());
    let texture = alpha.and_then(|alpha| alpha.texture.as_ref());
    let texels = texture.map_or(1.0, |texture| f64::from(texture.texels.iter().copied().max().unwrap_or(0)) / 255.0);
    let corner = |i: &u32| mesh.positions.get(*i as usize).map_or(DVec3::ZERO, |p| DVec3::from(p.map(f64::from)));
    alpha.into_iter().flat_map(move |alpha| {
        mesh.triangles.iter().enumerate().map(move |(i, triangle)| {
            Caster::sheet((first + i) as u32, triangle.each_ref().map(corner), most(alpha, triangle, texels))
        })
    })
}

/// Returns a caster for each see-through triangle.
pub(in crate::scene) fn sheets(meshes: &[Mesh]) -> impl Iterator<Item = Caster> + '_ {
    let firsts = meshes.iter().scan(0, |next, mesh| {
        let first = *next;
        *next += mesh.triangles.len();
        Some(first)
    });
    meshes.iter().zip(firsts).flat_map(|(mesh, first)| of_mesh(mesh, first))
}

impl Scene {
    /// Returns the number of see-through triangles; as casters they come between the splats and the cells of volumes.
    pub fn sheet_count(&self) -> usize {
        self.meshes.iter().filter(|mesh| mesh.is_see_through()).map(|mesh| mesh.triangles.len()).sum()
    }

    /// Returns the index of the first sheet among the casters.
    pub(crate) fn first_sheet(&self) -> usize {
        self.particles.len() + self.strands.len() + self.splats.len()
    }

    /// Returns the index of the first volume cell among the casters.
    pub(crate) fn first_cell(&self) -> usize {
        self.first_sheet() + self.sheet_count()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::AlphaMode;
    use crate::scene::tests::mesh;
    use proptest::prelude::*;

    proptest! {
        /// A sheet's sphere contains its corners, is no larger than the longest side allows, and the caster says which triangle it is.
        #[test]
        fn a_sheet_holds_its_triangle(
            corners in prop::array::uniform3(prop::array::uniform3(-3.0f32..3.0)),
            far in prop::sample::select(vec![0.0f32, 50.0, 6.378e6]),
            number in any::<u32>(),
        ) {
            let corners = corners.map(|corner| DVec3::from(corner.map(|at| f64::from(at + far))));
            let caster = Caster::sheet(number, corners, 0.5);
            prop_assert!(caster.is_sheet() && !caster.is_strand() && !caster.is_splat_or_cell());
            prop_assert_eq!(caster.sheet_triangle(), number);
            let radius = f64::from(caster.radius);
            for corner in corners {
                prop_assert!(corner.distance(caster.start()) <= radius);
            }
            let longest = (0..3).map(|i| corners[i].distance(corners[(i + 1) % 3])).fold(0.0, f64::max);
            // The circle through the corners of an equilateral triangle is the widest.
            prop_assert!(radius <= longest * (1.0 / 3.0_f64.sqrt() + 1e-5) + 2e-6 * f64::from(far) + 1e-5, "{radius} {longest}");
        }
    }

    /// Sheets keep the numbers that their triangles have among all meshes, and the greatest optical depth of each.
    #[test]
    fn sheets_are_numbered_over_all_meshes() {
        let corners = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]];
        let opaque = mesh(corners.clone(), vec![[0, 1, 2]]);
        let mut glass = mesh(corners, vec![[0, 1, 2], [1, 2, 3]]);
        glass.alpha =
            Some(Alpha { factors: vec![0.5, 0.2, 0.1, 1.0], ..Alpha::constant(AlphaMode::SeeThrough, 0.0, 4) });
        let all: Vec<_> = sheets(&[opaque.clone(), glass, opaque]).collect();
        assert_eq!(all.iter().map(Caster::sheet_triangle).collect::<Vec<_>>(), [1, 2]);
        assert_eq!(all.iter().map(|caster| caster.density).collect::<Vec<_>>(), [2.0_f32.ln(), 80.0]);
    }
}
