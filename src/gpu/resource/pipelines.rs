//! Pipelines, each made once per device and kept until it closes. A sweep opens the same shaders time and again, and a driver
//! that compiles on the processor takes longer to make a pipeline than to run it.

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

/// Shaders, by their names, and the pipeline's fixed state.
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

/// Primitives and targets.
#[derive(Clone, PartialEq, Eq, Hash)]
pub(in crate::gpu) enum DrawnTo {
    Targets,
    Patches {
        control: &'static str,
        evaluation: &'static str,
        lines: bool,
    },
    /// A pipeline fits all attachments of the same number of images.
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
pub(in crate::gpu) struct Key {
    state: State,
    /// The block of push constants.
    push: String,
    /// Specialization constants.
    constants: Vec<(u32, u32)>,
    /// The layout of each set.
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

/// A pipeline that is made, or is being made while the slot is locked.
type Slot = Arc<Mutex<Option<Pipeline>>>;

/// The pipelines of a device.
#[derive(Default)]
pub(in crate::gpu) struct Pipelines(Mutex<HashMap<Key, Slot>>);

impl Pipelines {
    /// The pipeline for `key`, made at the first call. Several threads make different pipelines at the same time, and
    /// each pipeline once.
    pub(in crate::gpu) fn get(&self, key: Key, make: impl FnOnce() -> Result<Pipeline>) -> Result<Pipeline> {
        let slot = lock(&self.0).entry(key).or_default().clone();
        let mut made = lock(&slot);
        match *made {
            Some(pipeline) => Ok(pipeline),
            None => Ok(*made.insert(make()?)),
        }
    }

    /// How many are made.
    pub(in crate::gpu) fn count(&self) -> usize {
        let all: Vec<Slot> = lock(&self.0).values().cloned().collect();
        all.iter().filter(|slot| lock(slot).is_some()).count()
    }

    /// Destroys all of them, as the device closes.
    pub(in crate::gpu) fn destroy(&self, device: &ash::Device) {
        let all = std::mem::take(&mut *lock(&self.0));
        for pipeline in all.into_values().filter_map(|slot| lock(&slot).take()) {
            // SAFETY: they are the device's, which is idle: no command uses them any more.
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

    /// Two threads each make a pipeline, and each waits until the other has begun. The test ends only if neither thread blocks the other. A
    /// pipeline that is made already is not made again.
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

    /// A pipeline that could not be made is tried again at the next call.
    #[test]
    fn a_failure_is_not_kept() {
        let pipelines = Pipelines::default();
        let fails = || Err(crate::Error::Refused("room".into()));
        assert!(pipelines.get(key("one"), fails).is_err() && pipelines.get(key("one"), || Ok(NONE)).is_ok());
    }
}
