//! A messenger of the validation layer for instances that a test opens itself.

use ash::{ext, vk};
use std::ffi::{CStr, c_void};
use std::sync::{Arc, Mutex, PoisonError};

/// Warnings and errors of the validation layer. Clones share one list, which may outlive the device: the layer also speaks while that is
/// closed.
#[derive(Clone, Default)]
pub struct Said(Arc<Mutex<Vec<String>>>);

impl Said {
    pub fn all(&self) -> Vec<String> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// For a messenger that adds to this list, or for an instance as it is made and destroyed. The list must outlive both.
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
    // SAFETY: the layer hands over a string that lives as long as this call; the list outlives the messenger.
    let (message, said) = unsafe { (CStr::from_ptr((*data).p_message), &*said.cast::<Mutex<Vec<String>>>()) };
    // A panic could not leave the layer.
    said.lock().unwrap_or_else(PoisonError::into_inner).push(message.to_string_lossy().into_owned());
    vk::FALSE
}

/// Adds to a list until it is dropped, which has to be before its instance is destroyed.
pub struct Messenger {
    loader: ext::debug_utils::Instance,
    handle: vk::DebugUtilsMessengerEXT,
    /// Kept as long as the layer may add to it.
    _said: Said,
}

impl Messenger {
    /// The instance was opened with `VK_EXT_debug_utils`.
    pub fn new(entry: &ash::Entry, instance: &ash::Instance, said: &Said) -> Self {
        let loader = ext::debug_utils::Instance::new(entry, instance);
        // SAFETY: the list is kept longer than the messenger.
        let handle = unsafe { loader.create_debug_utils_messenger(&said.info(), None) }.expect("a messenger");
        Self { loader, handle, _said: said.clone() }
    }
}

impl Drop for Messenger {
    fn drop(&mut self) {
        // SAFETY: the instance is still there.
        unsafe { self.loader.destroy_debug_utils_messenger(self.handle, None) };
    }
}
