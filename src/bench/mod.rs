//! Queries techniques, times them and compares their answers with the truth.

mod case;
mod error;
mod results;
mod run;
pub mod stress;
mod timing;

pub use case::built_techniques::BuiltTechniques;
pub use case::effort::{Effort, LOOKUPS};
pub use case::frames::{Frames, States, Traced};
pub use case::truth::Extent;
pub(crate) use case::truth::{Cached, Points, Truth, Wanted};
pub use case::{CasePictures, SceneCase, with_case};
pub use error::caster_error::{CLASSES as CASTER_CLASSES, CasterClass, CasterError};
pub use error::color::{COLORS, ColorError};
pub use error::error_metrics::{Answers, PartError, PointError, point_error};
pub use error::footprint::{FOOTPRINTS, FootprintError};
pub use error::light_ray::{LightRay, RayLine, RayPoints, telling_texel};
pub use error::picture_error::{difference_srgb8, picture_error, picture_flicker};
pub use error::seen::SeenError;
pub(crate) use error::seen::SeenTruth;
pub use error::spearman::spearman;
pub use results::cross_device::{Agreement, Column, Comparison, Disagreement, Line, ROUNDING, Times};
pub use results::regression::{Change, Figure, Margins, Verdict, change_of, changes, together};
pub use results::shards::{Shard, join};
pub use results::standard;
pub use results::submission::{SUBMISSION, Submission, answers_hash, noise};
pub use results::{
    DeviceFacts, FramesError, ImageError, PassCount, PassTiming, Results, Row, RowError, SCHEMA, Status,
};
pub use run::observer::{Observer, RowPictures};
pub use run::plan::{Plan, PlannedScene};
pub use run::run;
pub use timing::copy_bandwidth::copy_bytes_per_second;
pub use timing::cost::Unshadowed;
pub(crate) use timing::host_memory::host_bytes;
pub use timing::interlock::{Built, PATHS as BUILD_PATHS};
pub use timing::order_statistics::Timing;
pub(crate) use timing::passes::frame_ns;
pub use timing::raster_worth::{LAYERS, LayerWay, LayeredPictures, OPACITY, RasterWork, raster_worth};
pub use timing::stability::Stability;
pub use timing::stage_rates::{StageArithmetic, StageRates, compute_ns, marks, stage_rates};
pub use timing::timed_runs::{BuildTimes, LookupTimes, TimedBuilds, TimedRun};
