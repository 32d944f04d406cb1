//! The only module with `unsafe`: it wraps Vulkan, and maps files that go to the device. It knows no technique.
//!
//! Every handle lives in an owner that destroys it, owners are cheap to clone, and a recorded command keeps what it
//! uses alive until the device is done with it, so the functions here are safe to call in any order.

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
pub use profile::calibration::Calibration;
pub use profile::counts::PassCounts;
pub use profile::executables::Executable;
pub use profile::times::PassTime;
pub(crate) use profile::times::follow;
pub use profile::tools::Tool;
pub use record::commands::{Commands, MAX_UPDATE_BYTES, Pass, Staged, groups};
pub use record::draw::Draw;
pub use record::ordered_attachments::OrderedAttachments;
pub use record::render::Target;
pub use resource::acceleration::{AccelerationStructure, BOX_BYTES};
pub use resource::bindings::{Bindings, Border, Resource};
pub use resource::buffer::{Buffer, Memory};
pub use resource::constants::{Constant, ConstantValue, Constants};
pub use resource::image::{Image, ImageUse};
pub use resource::kernel::{Blend, Graphics, Kernel, Layered, Tessellated};
pub use resource::mapped::Mapped;
pub use resource::push::{Push, PushMember, push_struct};
pub use resource::read_back::ReadBack;
pub use resource::spirv::{Shader, Spirv};
#[doc(hidden)]
pub use testing::Testing;
pub(crate) use testing::burden;
#[cfg(feature = "program")]
pub(crate) use testing::fault;
#[doc(hidden)]
pub use testing::fault::Fault;
#[cfg(feature = "view")]
pub(crate) use testing::slow_truth;
pub use testing::validation::{ALLOWED, Allowed, Messages, is_gpu_assisted};

/// Image formats, as Vulkan names them.
pub use ash::vk::Format;

use crate::{Error, GpuCause, Less, WayOut};
use ash::vk;

/// The error for a failed Vulkan call, with the way out that its code suggests.
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
