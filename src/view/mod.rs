//! `gobo view`: a window with techniques side by side. It uses the core as any engine would: on a device of its own, with frames in flight,
//! only recording passes.

mod camera;
mod chart;
mod curve;
mod files;
#[allow(unsafe_code)]
mod host;
mod lit;
mod pace;
mod panel;
mod present;
mod rays;
mod script;
mod stage;
mod state;
mod truth;
mod window;

pub use state::{Side, State};

use crate::gpu::Messages;
use crate::{Error, Result};
use host::HostMessages;
use script::Script;
use std::path::PathBuf;
use std::sync::PoisonError;
use window::View;
use winit::event_loop::EventLoop;

/// Options of a window.
pub struct Options {
    /// Scenes to choose from.
    pub scenes: Vec<String>,
    /// Size of the picture, in pixels; the panel is beside it.
    pub size: [u32; 2],
    /// Script that replaces keys and mouse.
    pub script: Option<PathBuf>,
    /// Index of the device, or part of its name.
    pub device: Option<String>,
    /// Whether to run with the validation layer.
    pub validation: bool,
    /// List that leaks are added to.
    pub messages: Messages,
}

/// Opens a window that shows `state`, and returns when the window is closed.
///
/// # Errors
/// [`Error::Gpu`] if there is no display or device, or the device is lost; [`Error::Input`] if the scene or the script is unusable;
/// [`Error::Output`] if a picture cannot be written.
pub fn open(options: Options, state: State) -> Result<()> {
    let script = options.script.as_deref().map(Script::read).transpose()?;
    // Reports errors in the scene before opening a window.
    state.change().of(&state.load()?.scene)?;
    let events = EventLoop::new().map_err(no_display)?;
    let said = HostMessages::default();
    let mut view = View::new(options, state, script, said.clone());
    events.run_app(&mut view).map_err(no_display)?;
    let outcome = view.close();
    // The device is closed by now, and the layer may have reported messages about closing.
    let all = said.lock().unwrap_or_else(PoisonError::into_inner).clone();
    outcome.and(match all.first() {
        None => Ok(()),
        Some(first) => Err(Error::Gpu {
            operation: "show",
            name: format!("{} messages of the validation layer", all.len()),
            cause: first.replace('\n', " ").into(),
            way_out: "report this as a bug, with the driver's version".into(),
        }),
    })
}

fn no_display(cause: impl ToString) -> Error {
    let cause = cause.to_string().replace('\n', " ");
    // Omits the place in winit that reports the error.
    let said = cause.split_once(".rs:").and_then(|(_, line)| line.split_once(": ")).map_or(&*cause, |(_, said)| said);
    Error::Gpu {
        operation: "open",
        name: "a window".into(),
        cause: said.trim_end_matches('.').into(),
        way_out: "run it where there is a display, or under xvfb-run".into(),
    }
}
