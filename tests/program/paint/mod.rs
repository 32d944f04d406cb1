//! What each painting command paints, by its content.

mod curve;
