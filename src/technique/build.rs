//! The only build loop: record, submit, settle, and start over if a buffer grew.

use super::{BuildStatus, Spec, Technique};
use crate::gpu::{self, Buffer, Context, PassTime};
use crate::world::{Generations, World};
use crate::{Error, Result};
use std::time::Instant;

/// A technique opened for a world, with the world's state at the last build.
pub struct Opened<T: Technique + ?Sized = dyn Technique> {
    context: Context,
    /// The technique.
    pub technique: Box<T>,
    /// Whether builds of an unchanged world are skipped.
    skip: bool,
    /// The world's generations at the last build.
    built: Option<Generations>,
    /// Whether a build ended in an error and left only part of its results on the device.
    broken: bool,
    /// For tests that need slow builds: an extra buffer, and how many times each build fills it.
    burden: Option<(Buffer, u64)>,
}

/// Timings of a build.
#[derive(Clone, Debug, PartialEq)]
pub struct Built {
    /// Device time of each pass of the build, excluding attempts that ran out of buffer space. Empty if there was nothing to do or the
    /// device has no timestamps.
    pub passes: Vec<PassTime>,
    /// Device time of all submissions, including attempts that ran out of buffer space.
    pub device_ns: Option<f64>,
    /// Host time in nanoseconds: recording, submitting, waiting and settling.
    pub host_ns: f64,
}

/// Opens the technique that `spec` names.
///
/// # Errors
/// [`Error::Refused`] if the device lacks what the technique needs, or the scene has no caster that the technique sees; [`Error::Gpu`] if
/// memory runs out.
pub fn open(context: &Context, world: &World, spec: &Spec) -> Result<Opened> {
    let entry = spec.entry;
    if !entry.casts.any_of(world.kinds()) {
        return Err(entry.casts_from_nothing(world.name()));
    }
    Ok(Opened::new(context, (entry.open)(context, world, spec)?, spec.skips()))
}

impl<T: Technique + ?Sized> Opened<T> {
    /// Wraps an opened technique. `skip`: whether builds of an unchanged world are skipped.
    pub fn new(context: &Context, technique: Box<T>, skip: bool) -> Self {
        Self { context: context.clone(), technique, skip, built: None, broken: false, burden: None }
    }

    /// Builds for the current state of the world. Skips passes whose inputs have not changed since the last build; with `skip=off`, runs
    /// all passes. If a buffer is too small, records and submits the build again.
    ///
    /// # Errors
    /// [`Error::Gpu`] if memory runs out, the device is lost, or an earlier build ended in an error. After any error, the technique must be
    /// opened again.
    pub fn build(&mut self, world: &World) -> Result<Built> {
        if !self.skip {
            return self.rebuild(world);
        }
        let parts = self.technique.made_of();
        if self.built.as_ref().is_some_and(|built| built.agree(world.generations(), parts)) {
            return Ok(Built { passes: Vec::new(), device_ns: None, host_ns: 0.0 });
        }
        self.record(world)
    }

    /// Rebuilds everything for the current state of the world, except views and sort orders that are still valid ([`Technique::forget`]).
    ///
    /// # Errors
    /// Same as [`Opened::build`].
    pub fn rebuild(&mut self, world: &World) -> Result<Built> {
        self.technique.forget();
        self.record(world)
    }

    fn record(&mut self, world: &World) -> Result<Built> {
        if self.broken {
            return Err(Error::Gpu {
                operation: "build",
                name: self.technique.answer().folder.name.into(),
                cause: "an earlier build of it ended in an error".into(),
                way_out: "open it anew".into(),
            });
        }
        if self.burden.is_none() {
            self.burden = gpu::burden(&self.context)?;
        }
        (self.built, self.broken) = (None, true);
        let start = Instant::now();
        let (mut passes, mut device_ns) = (Vec::new(), None);
        loop {
            let mut frame = 0;
            let submitted = self.context.try_submit(|commands| {
                frame = commands.frame();
                self.technique.record(commands, world)?;
                if let Some((burden, times)) = &self.burden {
                    (0..*times).for_each(|_| commands.pass("test.burden", |pass| pass.fill(burden, 0)));
                }
                Ok(())
            })?;
            if let (Some(first), Some(last)) = (submitted.first(), submitted.last()) {
                device_ns = Some(device_ns.unwrap_or(0.0) + last.end_ns - first.start_ns);
            }
            gpu::follow(&mut passes, submitted);
            match self.technique.settle(frame)? {
                BuildStatus::Continue => {}
                // Passes of an attempt that ran out of buffer space do not count as part of the build.
                BuildStatus::Retry => passes.clear(),
                BuildStatus::Done => {
                    (self.built, self.broken) = (Some(world.generations().clone()), false);
                    return Ok(Built { passes, device_ns, host_ns: start.elapsed().as_nanos() as f64 });
                }
            }
        }
    }
}
