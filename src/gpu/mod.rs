//! The only module with `unsafe` code: it wraps Vulkan and memory-maps files for upload. It knows nothing of techniques.
//!
//! Every handle has an owner that destroys it, owners are cheap to clone, and recorded commands keep their resources
//! alive until the device is done with them, so the functions here are safe to call in any order.

mod device;
mod profile;
mod record;
mod resource;
mod testing;

pub use device::context::{Adopt, Context, Options, devices};
pub use device::enabled::{Enabled, EnabledStructures};
pub use device::features::{DeviceKind, Features, Requirement};
#[cfg(feature = "view")]
pub(crate) use device::instance;
pub use device::limits::Limit;
pub use profile::times::PassTime;
pub(crate) use profile::times::follow;
pub use record::commands::Commands;
pub use resource::buffer::{Buffer, Memory};
pub use resource::image::Image;
pub use resource::read_back::ReadBack;
pub(crate) use testing::burden;
#[cfg(feature = "program")]
pub(crate) use testing::fault;
#[cfg(feature = "view")]
pub(crate) use testing::slow_truth;
pub use testing::validation::Messages;

/// Image formats, as Vulkan names them.
pub use ash::vk::Format;

// For the program and the tests.
#[doc(hidden)]
pub use self::{
    profile::calibration::Calibration,
    profile::counts::PassCounts,
    profile::executables::Executable,
    profile::tools::Tool,
    record::commands::{MAX_UPDATE_BYTES, Pass, Staged, groups},
    record::draw::Draw,
    record::ordered_attachments::OrderedAttachments,
    record::render::Target,
    resource::acceleration::{AccelerationStructure, BOX_BYTES},
    resource::bindings::{Bindings, Border, Resource},
    resource::constants::{Constant, ConstantValue, Constants},
    resource::image::ImageUse,
    resource::kernel::{Blend, Graphics, Kernel, Layered, Tessellated},
    resource::mapped::Mapped,
    resource::push::{Push, PushMember, push_struct},
    resource::spirv::{Shader, Spirv},
    testing::Testing,
    testing::fault::Fault,
    testing::validation::{ALLOWED, Allowed, is_gpu_assisted},
};

use crate::{Error, GpuCause, Less, WayOut};
use ash::vk;

/// Returns the error for a failed Vulkan call, with advice for the user chosen by the result code.
fn vk_error(operation: &'static str, name: &str, result: vk::Result) -> Error {
    let way_out = match result {
        vk::Result::ERROR_OUT_OF_DEVICE_MEMORY | vk::Result::ERROR_OUT_OF_HOST_MEMORY => {
            WayOut::Less(&[Less::Map, Less::Casters, Less::MoreMemory])
        }
        vk::Result::ERROR_INCOMPATIBLE_DRIVER => WayOut::Driver,
        _ => WayOut::OtherDevice,
    };
    Error::Gpu { operation, name: name.into(), cause: GpuCause::Vulkan(result), way_out }
}
