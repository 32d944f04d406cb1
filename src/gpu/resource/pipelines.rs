//! Pipelines, each created once per device and kept until the device closes. A sweep requests the same shaders again
//! and again, and a driver that compiles on the CPU takes longer to create a pipeline than to run it.

use crate::Result;
use crate::gpu::{Bindings, Blend};
use ash::vk;
use std::collections::HashMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// A pipeline and its layout.
#[derive(Clone, Copy)]
pub(in crate::gpu) struct Pipeline {
    pub(in crate::gpu) handle: vk::Pipeline,
    pub(in crate::gpu) layout: vk::PipelineLayout,
}

/// Shaders, by name, and the pipeline's fixed state.
#[derive(Clone, PartialEq, Eq, Hash)]
pub(in crate::gpu) enum State {
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

/// Primitives and targets of a graphics pipeline.
#[derive(Clone, PartialEq, Eq, Hash)]
pub(in crate::gpu) enum DrawnTo {
    Targets,
    Patches {
        control: &'static str,
        evaluation: &'static str,
        lines: bool,
    },
    /// A pipeline fits all attachments with the same number of images.
    Ordered {
        images: usize,
    },
    Touched,
    Layers {
        geometry: Option<&'static str>,
        viewports: u32,
    },
}

/// Everything in which two pipelines can differ.
#[derive(Clone, PartialEq, Eq, Hash)]
pub(in crate::gpu) struct Key {
    state: State,
    /// Declaration of the push constant block.
    push: String,
    /// Specialization constants: id and value.
    constants: Vec<(u32, u32)>,
    /// Layout of each set.
    sets: Vec<Vec<vk::DescriptorType>>,
}

impl Key {
    pub(in crate::gpu) fn new(
        state: State,
        push: String,
        (ids, words): &(Vec<u32>, Vec<u32>),
        sets: &[&Bindings],
    ) -> Self {
        let constants = ids.iter().copied().zip(words.iter().copied()).collect();
        Self { state, push, constants, sets: sets.iter().map(|set| set.kinds().to_vec()).collect() }
    }
}

/// A pipeline, or none while it is being created and the slot is locked.
type Slot = Arc<Mutex<Option<Pipeline>>>;

/// The pipelines of a device.
#[derive(Default)]
pub(in crate::gpu) struct Pipelines(Mutex<HashMap<Key, Slot>>);

impl Pipelines {
    /// Returns the pipeline for `key`, creating it on the first call. Threads can create different pipelines at the
    /// same time, and each pipeline is created only once.
    pub(in crate::gpu) fn get(&self, key: Key, make: impl FnOnce() -> Result<Pipeline>) -> Result<Pipeline> {
        let slot = lock(&self.0).entry(key).or_default().clone();
        let mut made = lock(&slot);
        match *made {
            Some(pipeline) => Ok(pipeline),
            None => Ok(*made.insert(make()?)),
        }
    }

    /// Returns the number of pipelines created.
    pub(in crate::gpu) fn count(&self) -> usize {
        let all: Vec<Slot> = lock(&self.0).values().cloned().collect();
        all.iter().filter(|slot| lock(slot).is_some()).count()
    }

    /// Destroys all pipelines when the device closes.
    pub(in crate::gpu) fn destroy(&self, device: &ash::Device) {
        let all = std::mem::take(&mut *lock(&self.0));
        for pipeline in all.into_values().filter_map(|slot| lock(&slot).take()) {
            // SAFETY: the pipelines belong to the device, which is idle, so no command uses them.
            unsafe {
                device.destroy_pipeline(pipeline.handle, None);
                device.destroy_pipeline_layout(pipeline.layout, None);
            }
        }
    }
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Barrier;

    fn key(shader: &'static str) -> Key {
        let state = State::Compute { shader, flags: vk::PipelineShaderStageCreateFlags::empty() };
        Key { state, push: String::new(), constants: Vec::new(), sets: Vec::new() }
    }

    const NONE: Pipeline = Pipeline { handle: vk::Pipeline::null(), layout: vk::PipelineLayout::null() };

    /// Two threads create a pipeline each, and each waits until the other has begun. The test finishes only if neither thread blocks the
    /// other. A pipeline that exists must not be created again.
    #[test]
    fn several_are_made_at_once_and_each_but_once() {
        let (pipelines, both) = (Pipelines::default(), Barrier::new(2));
        std::thread::scope(|threads| {
            for shader in ["one", "other"] {
                let (pipelines, both) = (&pipelines, &both);
                threads.spawn(move || {
                    let make = || {
                        both.wait();
                        Ok(NONE)
                    };
                    pipelines.get(key(shader), make).map(|_| ()).expect("made");
                });
            }
        });
        let again = |shader| pipelines.get(key(shader), || panic!("{shader} is made again")).is_ok();
        assert!(again("one") && again("other"));
    }

    /// A pipeline that could not be created is tried again on the next call.
    #[test]
    fn a_failure_is_not_kept() {
        let pipelines = Pipelines::default();
        let fails = || Err(crate::Error::Refused("room".into()));
        assert!(pipelines.get(key("one"), fails).is_err() && pipelines.get(key("one"), || Ok(NONE)).is_ok());
    }
}
