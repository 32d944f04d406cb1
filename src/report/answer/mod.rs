//! Which rows answer: fronts, the best within limits, what a first look leaves.

pub(super) mod pareto;
pub(super) mod recommend;
pub(super) mod screening;
pub(super) mod selection;
