//! Driver reports on the programs compiled from shaders: registers, spills, memory, lanes. Occupancy follows from these.

use crate::gpu::{Context, Features};
use ash::{khr, vk};
use std::ffi::CStr;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};

/// A program that the driver compiled for one stage of a pipeline.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "program", derive(serde::Serialize, serde::Deserialize))]
pub struct Executable {
    /// Name of the pipeline's compute or fragment shader.
    pub pipeline: String,
    /// The driver's name for the program.
    pub name: String,
    /// Number of threads per subgroup.
    pub subgroup_size: u32,
    /// The driver's statistics, with its own names and order.
    pub figures: Vec<(String, f64)>,
}

/// Reports on the programs of a device's pipelines, if the driver provides them (VK_KHR_pipeline_executable_properties).
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

    /// Returns the flags to create a pipeline with.
    pub(in crate::gpu) fn flags(&self) -> vk::PipelineCreateFlags {
        match self.functions() {
            Some(_) => vk::PipelineCreateFlags::CAPTURE_STATISTICS_KHR,
            None => vk::PipelineCreateFlags::empty(),
        }
    }

    /// Stores the driver's report on a pipeline that was created with [`Executables::flags`]. Statistics that the driver does not report
    /// are omitted.
    pub(in crate::gpu) fn ask(&self, pipeline: vk::Pipeline, name: &str) {
        let Some(functions) = self.functions() else { return };
        let info = vk::PipelineInfoKHR::default().pipeline(pipeline);
        // SAFETY: the functions belong to the pipeline's device, which was opened with pipelineExecutableInfo.
        let programs = unsafe { functions.get_pipeline_executable_properties(&info) }.unwrap_or_default();
        for (index, program) in (0..).zip(&programs) {
            let info = vk::PipelineExecutableInfoKHR::default().pipeline(pipeline).executable_index(index);
            // SAFETY: as above; the pipeline was created to capture statistics, and has at least `index + 1` programs.
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

/// Converts a driver's text; empty if the text has no terminating zero.
fn words<E>(text: Result<&CStr, E>) -> String {
    text.map(|text| text.to_string_lossy().into_owned()).unwrap_or_default()
}

fn value(figure: &vk::PipelineExecutableStatisticKHR) -> f64 {
    // SAFETY: `format` names the valid member of the union, and every member is a plain number.
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
    /// Sets whether the driver reports on the programs of each pipeline created from now on
    /// ([`Features::pipeline_executable_info`]). Off by default, because it makes some drivers compile differently, and
    /// more slowly.
    pub fn ask_of_executables(&self, is_wanted: bool) {
        self.device().executables().is_wanted.store(is_wanted, Ordering::Relaxed);
    }

    /// Returns the driver's reports, in the order in which the pipelines were created.
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
