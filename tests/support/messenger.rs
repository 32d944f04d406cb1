//! A debug messenger for instances that a test creates itself.

use ash::{ext, vk};
use std::ffi::{CStr, c_void};
use std::sync::{Arc, Mutex, PoisonError};

/// Warnings and errors of the validation layer. Clones share one list, which may outlive the device, because the layer also reports during
/// destruction.
#[derive(Clone, Default)]
pub struct Said(Arc<Mutex<Vec<String>>>);

impl Said {
    pub fn all(&self) -> Vec<String> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Returns the create info for a messenger that appends to this list, or for messages during instance creation and destruction. The
    /// list must outlive both.
    pub fn info(&self) -> vk::DebugUtilsMessengerCreateInfoEXT<'static> {
        vk::DebugUtilsMessengerCreateInfoEXT::default()
            .message_severity(
                vk::DebugUtilsMessageSeverityFlagsEXT::WARNING | vk::DebugUtilsMessageSeverityFlagsEXT::ERROR,
            )
            .message_type(vk::DebugUtilsMessageTypeFlagsEXT::VALIDATION)
            .pfn_user_callback(Some(on_message))
            .user_data(Arc::as_ptr(&self.0).cast_mut().cast())
    }
}

unsafe extern "system" fn on_message(
    _: vk::DebugUtilsMessageSeverityFlagsEXT,
    _: vk::DebugUtilsMessageTypeFlagsEXT,
    data: *const vk::DebugUtilsMessengerCallbackDataEXT<'_>,
    said: *mut c_void,
) -> vk::Bool32 {
    // SAFETY: the layer passes a string that outlives this call; the list outlives the messenger.
    let (message, said) = unsafe { (CStr::from_ptr((*data).p_message), &*said.cast::<Mutex<Vec<String>>>()) };
    // No `expect`: a panic must not unwind through the layer.
    said.lock().unwrap_or_else(PoisonError::into_inner).push(message.to_string_lossy().into_owned());
    vk::FALSE
}

/// Appends messages to a list until dropped, which must happen before its instance is destroyed.
pub struct Messenger {
    loader: ext::debug_utils::Instance,
    handle: vk::DebugUtilsMessengerEXT,
    /// Keeps the list alive while the layer may append to it.
    _said: Said,
}

impl Messenger {
    /// Creates the messenger; the instance must have `VK_EXT_debug_utils` enabled.
    pub fn new(entry: &ash::Entry, instance: &ash::Instance, said: &Said) -> Self {
        let loader = ext::debug_utils::Instance::new(entry, instance);
        // SAFETY: `_said` keeps the list alive longer than the messenger.
        let handle = unsafe { loader.create_debug_utils_messenger(&said.info(), None) }.expect("a messenger");
        Self { loader, handle, _said: said.clone() }
    }
}

impl Drop for Messenger {
    fn drop(&mut self) {
        // SAFETY: the instance still exists.
        unsafe { self.loader.destroy_debug_utils_messenger(self.handle, None) };
    }
}
