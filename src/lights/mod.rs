//! What makes lights: virtual ones, from what meshes send back.

pub mod indirect;
