//! `gobo view`: a window with techniques side by side. It uses the core as any engine does, with a device of its own,
//! frames in flight, and passes that are only recorded.

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
    /// The scenes to choose from.
    pub scenes: Vec<String>,
    /// The picture's size, pixels; the panel is beside it.
    pub size: [u32; 2],
    /// The script that takes the place of keys and mouse.
    pub script: Option<PathBuf>,
    /// The device's index, or part of its name.
    pub device: Option<String>,
    /// Whether to run under the validation layer.
    pub validation: bool,
    /// The list to which leaks are added.
    pub messages: Messages,
}

/// Opens a window that shows `state`, and returns when the window is closed.
///
/// # Errors
/// [`Error::Gpu`] where there is no display or device, or that is lost; [`Error::Input`] where the scene or the script cannot be used;
/// [`Error::Output`] where a picture cannot be written.
pub fn open(options: Options, state: State) -> Result<()> {
    let script = options.script.as_deref().map(Script::read).transpose()?;
    // Errors in the scene are found before a window is opened.
    state.change().of(&state.load()?.scene)?;
    let events = EventLoop::new().map_err(no_display)?;
    let said = HostMessages::default();
    let mut view = View::new(options, state, script, said.clone());
    events.run_app(&mut view).map_err(no_display)?;
    let outcome = view.close();
    // The device is closed by now, and the layer may have sent messages about that.
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
    // The place in winit that reports the error is left out.
    let said = cause.split_once(".rs:").and_then(|(_, line)| line.split_once(": ")).map_or(&*cause, |(_, said)| said);
    Error::Gpu {
        operation: "open",
        name: "a window".into(),
        cause: said.trim_end_matches('.').into(),
        way_out: "run it where there is a display, or under xvfb-run".into(),
    }
}
