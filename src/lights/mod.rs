//! Virtual lights, made from the light that meshes reflect.

pub mod indirect;
