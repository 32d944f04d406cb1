//! Asks techniques, times them and compares their answers with the truth.

mod asked;
mod beside;
mod caster_error;
mod change;
mod color;
mod compare;
mod copy;
mod error_metrics;
mod flicker;
mod footprint;
mod frames;
mod host_memory;
mod interlock;
mod light_ray;
mod passes;
mod picture_error;
mod points;
mod prepare;
mod rank;
mod repeats;
mod results;
mod shards;
pub mod standard;
mod standing;
mod steadiness;
mod submission;
mod timed;
mod timing;
mod truth;
mod turning;

pub use beside::{Agreement, Beside, Column, Disagreement, Line, ROUNDING, Times};
pub use caster_error::{CLASSES as CASTER_CLASSES, CasterClass, CasterError};
pub use change::{Change, Figure, Margins, Verdict, change_of, changes, together};
pub use color::{COLORS, ColorError};
pub use compare::{Case, Drawn, Effort, LOOKUPS, with_case};
pub use copy::copy_bytes_per_second;
pub use error_metrics::{Answers, PartError, PointError, point_error};
pub use footprint::{FOOTPRINTS, FootprintError};
pub use frames::{Frames, States, Traced};
pub(crate) use host_memory::host_bytes;
pub use interlock::{Built, PATHS as BUILD_PATHS};
pub use light_ray::{LightRay, RayLine, RayPoints, telling_texel};
pub(crate) use passes::frame_ns;
pub use picture_error::{difference_srgb8, picture_error, picture_flicker};
pub use rank::spearman;
pub use results::{
    DeviceFacts, FramesError, ImageError, PassCount, PassTiming, Results, Row, RowError, SCHEMA, Status, built_from,
};
pub use shards::{Shard, join};
pub use standing::Standing;
pub use steadiness::Steadiness;
pub use submission::{SUBMISSION, Submission, answers_hash, noise};
pub use timed::{BuildTimes, LookupTimes, Ran, TimedBuilds};
pub use timing::Timing;
pub use truth::Extent;
pub(crate) use truth::{Cached, Points, Truth, Wanted};
