//! The only module with `unsafe`: it wraps Vulkan, and maps files that go to the device. It knows no technique.
//!
//! Every handle lives in an owner that destroys it, owners are cheap to clone, and a recorded command keeps what it
//! uses alive until the device is done with it, so the functions here are safe to call in any order.

mod acceleration;
mod bindings;
mod buffer;
mod calibration;
mod commands;
mod constants;
mod context;
mod counts;
mod device;
mod draw;
mod enabled;
mod executables;
pub(crate) mod fault;
mod features;
mod frames;
mod image;
pub(crate) mod instance;
mod kernel;
mod limits;
mod lowest;
mod mapped;
mod ordered_attachments;
mod pending;
mod pipelines;
mod push;
mod read_back;
mod recorder;
mod render;
mod spirv;
mod submit;
mod testing;
mod times;
mod tools;
mod validation;

pub use acceleration::{AccelerationStructure, BOX_BYTES};
pub use bindings::{Bindings, Border, Resource};
pub use buffer::{Buffer, Memory};
pub use calibration::Calibration;
pub use commands::{Commands, MAX_UPDATE_BYTES, Pass, Staged, groups};
pub use constants::{Constant, ConstantValue, Constants};
pub use context::{Adopt, Context, Options, devices};
pub use counts::PassCounts;
pub use draw::Draw;
pub use enabled::{Enabled, EnabledStructures};
pub use executables::Executable;
#[doc(hidden)]
pub use fault::Fault;
pub use features::{DeviceKind, Features, Requirement};
pub use image::{Image, ImageUse};
pub use kernel::{Blend, Graphics, Kernel, Layered, Tessellated};
pub use limits::Limit;
pub use mapped::Mapped;
pub use ordered_attachments::OrderedAttachments;
pub use push::{Push, PushMember, push_struct};
pub use read_back::ReadBack;
pub use render::Target;
pub use spirv::{Shader, Spirv};
#[doc(hidden)]
pub use testing::Testing;
pub(crate) use testing::burden;
#[cfg(feature = "view")]
pub(crate) use testing::slow_truth;
pub use times::PassTime;
pub(crate) use times::follow;
pub use tools::Tool;
pub use validation::{ALLOWED, Allowed, Messages, is_gpu_assisted};

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
