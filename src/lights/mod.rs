//! Virtual lights, created from the light that meshes reflect.

pub mod indirect;
