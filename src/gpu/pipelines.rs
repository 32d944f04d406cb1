//! Pipelines, each made once per device and kept until it closes. A sweep opens the same shaders time and again, and a driver
//! that compiles on the processor takes longer to make a pipeline than to run it.

use super::{Bindings, Blend};
use crate::Result;
use ash::vk;
use std::collections::HashMap;
use std::sync::{Mutex, PoisonError};

/// A pipeline and its layout.
#[derive(Clone, Copy)]
pub(super) struct Pipeline {
    pub(super) handle: vk::Pipeline,
    pub(super) layout: vk::PipelineLayout,
}

/// Shaders, by their names, and the state of what is fixed about them.
#[derive(Clone, PartialEq, Eq, Hash)]
pub(super) enum State {
    Compute {
        shader: &'static str,
        flags: vk::PipelineShaderStageCreateFlags,
    },
    Graphics {
        vertex: &'static str,
        fragment: &'static str,
        colors: Vec<(vk::Format, Blend)>,
        depth: Option<vk::Format>,
        target: DrawnTo,
    },
}

/// What is drawn, and to what.
#[derive(Clone, PartialEq, Eq, Hash)]
pub(super) enum DrawnTo {
    Targets,
    Patches {
        control: &'static str,
        evaluation: &'static str,
        lines: bool,
    },
    /// Attachments of as many images are compatible.
    Ordered {
        images: usize,
    },
    Touched,
    Layers {
        geometry: Option<&'static str>,
        viewports: u32,
    },
}

/// All that two pipelines may differ in.
#[derive(Clone, PartialEq, Eq, Hash)]
pub(super) struct Key {
    state: State,
    /// The block that is pushed.
    push: String,
    /// Specialization constants.
    constants: Vec<(u32, u32)>,
    /// What each set holds.
    sets: Vec<Vec<vk::DescriptorType>>,
}

impl Key {
    pub(super) fn new(state: State, push: String, (ids, words): &(Vec<u32>, Vec<u32>), sets: &[&Bindings]) -> Self {
        let constants = ids.iter().copied().zip(words.iter().copied()).collect();
        Self { state, push, constants, sets: sets.iter().map(|set| set.kinds().to_vec()).collect() }
    }
}

/// Those of a device.
#[derive(Default)]
pub(super) struct Pipelines(Mutex<HashMap<Key, Pipeline>>);

impl Pipelines {
    /// The pipeline of that key; made where there is none yet.
    pub(super) fn get(&self, key: Key, make: impl FnOnce() -> Result<Pipeline>) -> Result<Pipeline> {
        let mut all = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(pipeline) = all.get(&key) {
            return Ok(*pipeline);
        }
        let pipeline = make()?;
        all.insert(key, pipeline);
        Ok(pipeline)
    }

    /// Destroys all of them, as the device closes.
    pub(super) fn destroy(&self, device: &ash::Device) {
        for (_, pipeline) in self.0.lock().unwrap_or_else(PoisonError::into_inner).drain() {
            // SAFETY: they are the device's, which is idle: what used them is gone.
            unsafe {
                device.destroy_pipeline(pipeline.handle, None);
                device.destroy_pipeline_layout(pipeline.layout, None);
            }
        }
    }
}
