//! A driver's reports about the programs that it compiled from shaders: registers, spills, memory, lanes. The occupancy follows from these.

use crate::gpu::{Context, Features};
use ash::{khr, vk};
use std::ffi::CStr;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};

/// A program that the driver made of a stage of a pipeline.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "program", derive(serde::Serialize, serde::Deserialize))]
pub struct Executable {
    /// The pipeline: the name of its compute or fragment shader.
    pub pipeline: String,
    /// The driver's name for it.
    pub name: String,
    /// Threads per subgroup.
    pub subgroup_size: u32,
    /// The driver's figures, in its own words and order.
    pub figures: Vec<(String, f64)>,
}

/// The programs of a device's pipelines, where its driver reports them (VK_KHR_pipeline_executable_properties).
pub(in crate::gpu) struct Executables {
    functions: Option<khr::pipeline_executable_properties::Device>,
    is_wanted: AtomicBool,
    told: Mutex<Vec<Executable>>,
}

impl Executables {
    pub(in crate::gpu) fn new(instance: &ash::Instance, device: &ash::Device, features: &Features) -> Self {
        let functions = features
            .pipeline_executable_info
            .then(|| khr::pipeline_executable_properties::Device::new(instance, device));
        Self { functions, is_wanted: AtomicBool::new(false), told: Mutex::default() }
    }

    fn functions(&self) -> Option<&khr::pipeline_executable_properties::Device> {
        self.functions.as_ref().filter(|_| self.is_wanted.load(Ordering::Relaxed))
    }

    /// Flags that a pipeline is created with.
    pub(in crate::gpu) fn flags(&self) -> vk::PipelineCreateFlags {
        match self.functions() {
            Some(_) => vk::PipelineCreateFlags::CAPTURE_STATISTICS_KHR,
            None => vk::PipelineCreateFlags::empty(),
        }
    }

    /// Keeps the driver's report about a pipeline that was created with [`Executables::flags`]. Figures that it does not report are left
    /// out.
    pub(in crate::gpu) fn ask(&self, pipeline: vk::Pipeline, name: &str) {
        let Some(functions) = self.functions() else { return };
        let info = vk::PipelineInfoKHR::default().pipeline(pipeline);
        // SAFETY: the pipeline is of the device whose functions these are, which was opened with pipelineExecutableInfo.
        let programs = unsafe { functions.get_pipeline_executable_properties(&info) }.unwrap_or_default();
        for (index, program) in (0..).zip(&programs) {
            let info = vk::PipelineExecutableInfoKHR::default().pipeline(pipeline).executable_index(index);
            // SAFETY: as above; the pipeline was created to capture statistics, and has that many programs.
            let figures = unsafe { functions.get_pipeline_executable_statistics(&info) }.unwrap_or_default();
            let executable = Executable {
                pipeline: name.into(),
                name: words(program.name_as_c_str()),
                subgroup_size: program.subgroup_size,
                figures: figures.iter().map(|figure| (words(figure.name_as_c_str()), value(figure))).collect(),
            };
            self.told.lock().unwrap_or_else(PoisonError::into_inner).push(executable);
        }
    }
}

/// A driver's text; empty where the text has no terminating zero.
fn words<E>(text: Result<&CStr, E>) -> String {
    text.map(|text| text.to_string_lossy().into_owned()).unwrap_or_default()
}

fn value(figure: &vk::PipelineExecutableStatisticKHR) -> f64 {
    // SAFETY: the format says which of the union's values it is; all of them are plain numbers.
    unsafe {
        match figure.format {
            vk::PipelineExecutableStatisticFormatKHR::BOOL32 => f64::from(u8::from(figure.value.b32 != 0)),
            vk::PipelineExecutableStatisticFormatKHR::INT64 => figure.value.i64 as f64,
            vk::PipelineExecutableStatisticFormatKHR::FLOAT64 => figure.value.f64,
            _ => figure.value.u64 as f64,
        }
    }
}

impl Context {
    /// Sets whether the driver is asked about the programs of each pipeline made from now on
    /// ([`Features::pipeline_executable_info`]). By default it is not: some drivers then compile differently, and more
    /// slowly.
    pub fn ask_of_executables(&self, is_wanted: bool) {
        self.device().executables().is_wanted.store(is_wanted, Ordering::Relaxed);
    }

    /// The driver's reports, in the order in which the pipelines were made.
    pub fn executables(&self) -> Vec<Executable> {
        self.device().executables().told.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_are_read_as_the_driver_says() {
        let figure = |format, value| vk::PipelineExecutableStatisticKHR::default().format(format).value(value);
        use vk::{PipelineExecutableStatisticFormatKHR as Format, PipelineExecutableStatisticValueKHR as Value};
        assert_eq!(value(&figure(Format::UINT64, Value { u64: 40 })), 40.0);
        assert_eq!(value(&figure(Format::INT64, Value { i64: -3 })), -3.0);
        assert_eq!(value(&figure(Format::FLOAT64, Value { f64: 0.5 })), 0.5);
        assert_eq!(value(&figure(Format::BOOL32, Value { b32: vk::TRUE })), 1.0);
    }
}
