//! Twin of glsl/technique/ism/map.glsl.

/// A vector.
pub type V3 = [f32; 3];

/// Returns the dot product, summed in order.
pub fn dot(a: V3, b: V3) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Returns the difference of two vectors, component by component.
pub fn minus(a: V3, b: V3) -> V3 {
    [0, 1, 2].map(|i| a[i] - b[i])
}

/// Twin: Axes.
#[derive(Clone, Copy, Debug)]
pub struct Axes {
    /// Right axis, of unit length.
    pub right: V3,
    /// Up axis, of unit length.
    pub up: V3,
    /// The light's normal.
    pub forward: V3,
}

impl Axes {
    /// Twin: axes_of.
    pub fn of(forward: V3) -> Self {
        let [x, y, z] = forward;
        let side = if z >= 0.0 { 1.0 } else { -1.0 };
        let a = -1.0 / (side + z);
        let b = x * y * a;
        Self { right: [1.0 + side * x * x * a, side * b, -side * x], up: [b, side + y * y * a, -y], forward }
    }

    /// Twin: into_axes.
    pub fn into_axes(&self, v: V3) -> V3 {
        [self.right, self.up, self.forward].map(|axis| dot(axis, v))
    }
}

/// A map's distances on all levels, finest first; infinite in empty texels. Twins: ISM_SIZE, ISM_LEVELS.
#[derive(Clone, Debug, PartialEq)]
pub struct Levels {
    /// Number of texels per side of the finest level.
    pub size: u32,
    /// Distances, level after level, in rows of texels.
    pub levels: Vec<Vec<f32>>,
}

impl Levels {
    /// Creates empty levels, down to 4 texels per side.
    pub fn new(size: u32) -> Self {
        let sides = std::iter::successors(Some(size), |side| Some(side / 2)).take_while(|side| *side >= 4);
        Self { size, levels: sides.map(|side| vec![f32::INFINITY; (side * side) as usize]).collect() }
    }

    /// Returns the number of texels per side of a level.
    pub fn side(&self, level: usize) -> i32 {
        (self.size >> level) as i32
    }

    /// Returns the distance in a texel.
    pub fn get(&self, level: usize, [x, y]: [i32; 2]) -> f32 {
        self.levels[level][(y * self.side(level) + x) as usize]
    }

    /// Sets the distance in a texel.
    pub fn set(&mut self, level: usize, [x, y]: [i32; 2], distance: f32) {
        let at = (y * self.side(level) + x) as usize;
        self.levels[level][at] = distance;
    }
}

/// Twin: map_way.
pub fn map_way([x, y]: [f32; 2]) -> V3 {
    [2.0 * x, 2.0 * y, 1.0 - (x * x + y * y)]
}

/// Twin: texel_place.
pub fn texel_place(side: i32, texel: [i32; 2]) -> [f32; 2] {
    texel.map(|t| (t as f32 + 0.5) * (2.0 / side as f32) - 1.0)
}
