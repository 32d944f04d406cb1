//! Recording commands, renders and draws, and submitting them.

pub(super) mod commands;
pub(super) mod draw;
pub(super) mod frames;
pub(super) mod ordered_attachments;
pub(super) mod pending;
pub(super) mod recorder;
pub(super) mod render;
pub(super) mod submit;
