//! Loads scenes and their parts from files: one module per format.

pub(super) mod animation;
mod blosc;
pub(super) mod contents;
pub(super) mod data_file;
pub(super) mod default_view;
pub(super) mod dense_file;
pub(super) mod file;
pub(super) mod gltf_document;
pub(super) mod gltf_file;
pub(super) mod gltf_stage;
pub(super) mod hair_file;
pub(super) mod input;
pub(super) mod load;
pub(super) mod mesh_file;
pub(super) mod nrrd_file;
pub(super) mod particle_file;
pub(super) mod placement;
pub(super) mod ply;
pub(super) mod splat_file;
pub(super) mod splat_ply;
pub(super) mod spz_file;
pub(super) mod stage;
pub(super) mod strand_file;
pub(super) mod tressfx_file;
mod vdb_file;
pub(super) mod volume_file;
