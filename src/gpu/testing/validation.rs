//! Messages of the validation layer, collected so that tests can fail on them.

use crate::gpu::testing::testing;
use ash::vk;
use std::ffi::{CStr, c_void};
use std::sync::{Arc, Mutex, PoisonError};

/// A validation message that is known to be wrong or harmless.
#[derive(Clone, Copy, Debug)]
pub struct Allowed {
    /// The message's id.
    pub id: &'static str,
    /// Text that the message must contain, so that the entry hides no other message.
    pub contains: &'static str,
    /// Why the message may be ignored.
    pub reason: &'static str,
    /// Where the message is discussed.
    pub link: &'static str,
}

/// Every message that is ignored.
pub const ALLOWED: [Allowed; 2] = [
    Allowed {
        id: "VALIDATION-SETTINGS",
        contains: "Both GPU Assisted Validation and Normal Core Check Validation are enabled",
        reason: "it is slow, and only some tests run so",
        link: "https://github.com/KhronosGroup/Vulkan-ValidationLayers/blob/main/docs/gpu_validation.md",
    },
    Allowed {
        id: "WARNING-GPU-Assisted-Validation",
        contains: "Internal Warning: Forcing ",
        reason: "GPU-assisted validation switches on for itself what its own shaders need",
        link: "https://github.com/KhronosGroup/Vulkan-ValidationLayers/blob/main/docs/gpu_validation.md",
    },
];

/// Warnings and errors of the validation layer. Clones share one list, which outlives the context.
#[derive(Clone, Debug, Default)]
pub struct Messages(Arc<Mutex<Vec<String>>>);

impl Messages {
    /// Returns all messages so far that are not in [`ALLOWED`].
    pub fn all(&self) -> Vec<String> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Adds a message, unless it is allowed.
    pub(in crate::gpu) fn push(&self, id: &str, text: &str) {
        if !ALLOWED.iter().any(|a| a.id == id && text.contains(a.contains)) {
            self.0.lock().unwrap_or_else(PoisonError::into_inner).push(format!("{id}: {text}"));
        }
    }

    /// Returns the pointer for the messenger, valid while any clone lives.
    pub(in crate::gpu) fn user_data(&self) -> *mut c_void {
        Arc::as_ptr(&self.0).cast_mut().cast()
    }
}

/// Returns whether tests want the layer to add checks to shaders, so that an out-of-bounds buffer access is reported.
pub fn is_gpu_assisted() -> bool {
    testing().checks_in_shaders
}

/// Returns the messenger's settings. `messages` must outlive the instance.
pub(in crate::gpu) fn messenger_info(messages: &Messages) -> vk::DebugUtilsMessengerCreateInfoEXT<'static> {
    vk::DebugUtilsMessengerCreateInfoEXT {
        p_user_data: messages.user_data(),
        ..vk::DebugUtilsMessengerCreateInfoEXT::default()
            .message_severity(
                vk::DebugUtilsMessageSeverityFlagsEXT::WARNING | vk::DebugUtilsMessageSeverityFlagsEXT::ERROR,
            )
            .message_type(vk::DebugUtilsMessageTypeFlagsEXT::VALIDATION)
            .pfn_user_callback(Some(on_message))
    }
}

/// Callback for the layer, which calls it from any thread.
unsafe extern "system" fn on_message(
    _severity: vk::DebugUtilsMessageSeverityFlagsEXT,
    _kind: vk::DebugUtilsMessageTypeFlagsEXT,
    data: *const vk::DebugUtilsMessengerCallbackDataEXT<'_>,
    user: *mut c_void,
) -> vk::Bool32 {
    let text = |p: *const std::ffi::c_char| {
        if p.is_null() {
            String::new()
        } else {
            // SAFETY: the layer passes NUL-terminated strings that live for the duration of this call.
            unsafe { CStr::from_ptr(p) }.to_string_lossy().into_owned()
        }
    };
    // SAFETY: the layer passes a valid structure; `user` is the list of `messenger_info`, kept alive by the context.
    let (data, list) = unsafe { (&*data, &*user.cast::<Mutex<Vec<String>>>()) };
    let (id, message) = (text(data.p_message_id_name), text(data.p_message));
    if !ALLOWED.iter().any(|a| a.id == id && message.contains(a.contains)) {
        list.lock().unwrap_or_else(PoisonError::into_inner).push(format!("{id}: {message}"));
    }
    vk::FALSE
}
