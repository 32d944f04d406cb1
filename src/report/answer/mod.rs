//! Picks the rows to recommend: Pareto fronts, the best row within limits, and screening after a first look.

pub(super) mod pareto;
pub(super) mod recommend;
pub(super) mod screening;
pub(super) mod selection;
