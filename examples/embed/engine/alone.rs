//! Frames of shadows alone, of a scene of the program's: nothing is moved, drawn or asked. What Gobo takes of an engine's frame.

use super::frames::{FRAMES_IN_FLIGHT, Frames};
use super::{Choice, Gpu, How, Result, Shadows, Steps, step};
use gobo::scene::Scene;
use std::time::Instant;

/// Gobo goes before the device that it is open on: fields are dropped in this order.
pub struct Alone {
    shadows: Shadows,
    frames: Frames,
    /// The next that is recorded.
    frame: u64,
    steps: Steps,
    gpu: Gpu,
}

/// What a frame takes, milliseconds.
pub struct Times {
    /// Gobo's part on the host: settling, recording, writing the set.
    pub recording_ms: f64,
    /// The renderer's: handing it over.
    pub submission_ms: f64,
    /// On the device, of the frame before the last; none without timestamps.
    pub device_ms: Option<f64>,
}

impl Alone {
    pub fn open(how: &How, choice: &Choice, scene: &Scene) -> Result<Self> {
        let mut steps = Steps::new();
        let mut gpu = step(&mut steps, "instance and device", || Gpu::open(choice))?;
        let frames = Frames::new(&mut gpu)?;
        let shadows = Shadows::of_scene(&mut gpu, how, scene, &mut steps)?;
        Ok(Self { shadows, frames, frame: 0, steps, gpu })
    }

    pub fn gpu(&self) -> &Gpu {
        &self.gpu
    }

    /// What opening took the host, step by step.
    pub fn steps(&self) -> &Steps {
        &self.steps
    }

    /// Records and submits a frame in which all casters have moved.
    pub fn frame(&mut self) -> Result<Times> {
        let frame = self.frame;
        let commands = self.frames.begin(frame)?;
        let device_ms = self.frames.times(frame)?.map(|[_, shadows_ns, _]| shadows_ns / 1e6);
        self.frames.stamp(frame, 0);
        self.frames.stamp(frame, 1);
        let start = Instant::now();
        if let Some(over) = frame.checked_sub(FRAMES_IN_FLIGHT.into()) {
            self.shadows.settle(over)?;
        }
        self.shadows.record(commands, frame)?;
        let recorded = start.elapsed();
        self.frames.stamp(frame, 2);
        self.frames.stamp(frame, 3);
        let start = Instant::now();
        self.frames.submit(frame, true)?;
        self.frame += 1;
        let [recording_ms, submission_ms] = [recorded, start.elapsed()].map(|time| time.as_secs_f64() * 1e3);
        Ok(Times { recording_ms, submission_ms, device_ms })
    }

    /// Waits until all frames are over.
    pub fn wait(&self) -> Result<()> {
        self.frames.wait(self.frame - 1)
    }
}

impl Drop for Alone {
    fn drop(&mut self) {
        // SAFETY: nothing is submitted any more. Gobo is closed when no frame runs.
        let _ = unsafe { self.gpu.device.device_wait_idle() };
    }
}
