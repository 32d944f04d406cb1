//! Twin of glsl/shading/packed_normal.glsl: normals packed to decide whether two pixels see the same surface.

/// Value of 1 in a packed normal. Normals of one surface have a dot product of at least `SAME_NORMAL` in these units.
pub const NORMAL_UNIT: i32 = 511;
const SAME_NORMAL: i32 = 235_009;

/// Twin: pack_normal.
pub fn pack_normal(normal: [f32; 3]) -> u32 {
    let [x, y, z] = normal.map(|c| (c * 511.0 + 511.5).floor().clamp(0.0, 1022.0) as u32);
    x | y << 10 | z << 20
}

/// Twin: unpack_normal.
pub fn unpack_normal(packed: u32) -> [i32; 3] {
    [0, 10, 20].map(|shift| (packed >> shift & 1023) as i32 - NORMAL_UNIT)
}

/// Twin: same_normal.
pub fn same_normal(a: u32, b: u32) -> bool {
    let (a, b) = (unpack_normal(a), unpack_normal(b));
    (0..3).map(|i| a[i] * b[i]).sum::<i32>() >= SAME_NORMAL
}

/// Twin: along_normal.
pub fn along_normal(packed: u32, vector: [f32; 3]) -> f32 {
    let normal = unpack_normal(packed).map(|c| c as f32);
    normal[0] * vector[0] + normal[1] * vector[1] + normal[2] * vector[2]
}
