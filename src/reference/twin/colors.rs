//! CPU twin of glsl/world/colors.glsl.

/// Returns the visibility in one color, from the visibility returned by the look-up, the visibility past meshes alone, and the color's
/// extinction. Twin: `color_left`.
pub fn color_left(visibility: f32, meshes: f32, extinction: f32) -> f32 {
    if extinction == 1.0 || meshes.is_nan() || meshes <= 0.0 {
        return visibility;
    }
    if extinction > 0.0 { meshes * (visibility / meshes).clamp(0.0, 1.0).powf(extinction) } else { meshes }
}
