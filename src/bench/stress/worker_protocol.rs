//! The worker's side: a process that queries techniques on behalf of another process.
//!
//! The processes exchange lines of JSON. The reply to a [`Job::Value`] is [`Reply::Ready`], then a row per technique. The reply to a
//! [`Job::Round`] is [`Reply::Asking`] before each technique, then the round.

use super::case_truth::Subject;
use super::results::{CaseResult, Outcome};
use super::round::{Round, round};
use super::{Sweep, ask};
use crate::bench::{DeviceFacts, host_bytes};
use crate::gpu::Context;
use crate::shading::parse;
use crate::technique::{Name, Spec};
use crate::{Error, Result};
use serde::{Deserialize, Serialize};
use std::io::Write;

/// A worker's task.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub enum Job {
    /// Queries techniques at one value of a sweep.
    Value {
        /// Name of the sweep, [`Sweep::name`].
        sweep: String,
        /// Name of the given scene, [`Sweep::given`].
        given: Option<String>,
        /// The value of the setting that is swept.
        value: f64,
        /// Specs of the techniques to query.
        techniques: Vec<String>,
    },
    /// Runs the soak round with this seed.
    Round(u64),
    /// Closes the device, with everything on it, and reopens it.
    Reopen,
}

/// A worker's message.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub enum Reply {
    /// The first reply: the worker's device, and whether it is a software device.
    Device(DeviceFacts, bool),
    /// The scene of a job and its truth have been computed.
    Ready,
    /// One technique of the job has been queried.
    Row(Box<CaseResult>),
    /// This technique of a round is about to be queried.
    Asking(String),
    /// A round has finished, with this result.
    Round(Box<Round>),
    /// The device was closed: the process's memory then, in bytes, and the messages reported on closing, such as leaks.
    Closed(Option<u64>, Vec<String>),
}

/// Serves jobs until there are no more. `open` opens the device.
///
/// # Errors
/// Fails if `open` does; [`Error::Input`] for a line that is not a job; [`Error::Output`] if the other process no longer reads.
pub fn serve(open: impl Fn() -> Result<Context>) -> Result<()> {
    // A panic's message is printed as one line, since the parent reports the last line of stderr.
    std::panic::set_hook(Box::new(|panic| eprintln!("{}", panic.to_string().replace(char::is_control, " "))));
    let mut context = open()?;
    let (facts, is_software) = (DeviceFacts::of(context.features()), context.features().is_software());
    say(&Reply::Device(facts, is_software))?;
    // The sweeps of the last scene, kept so that each file is read only once.
    let mut sweeps: (String, Vec<Sweep>) = Default::default();
    for line in std::io::stdin().lines() {
        let wrong = |cause: String| Error::input("stress --worker", cause, "leave --worker to the program itself");
        let line = line.map_err(|cause| wrong(cause.to_string()))?;
        match serde_json::from_str(&line).map_err(|cause| wrong(cause.to_string()))? {
            Job::Value { sweep, given, value, techniques } => {
                let name = given.unwrap_or_else(|| sweep.clone());
                if sweeps.0 != name {
                    sweeps = (name.clone(), Sweep::named(&name)?.0);
                }
                let sweep = sweeps.1.iter().find(|known| known.name == sweep).ok_or_else(|| wrong(sweep.clone()))?;
                answer(&context, sweep, value, &techniques)?;
            }
            Job::Round(seed) => {
                let of = round(&context, seed, |spec| say(&Reply::Asking(spec.to_string())))?;
                say(&Reply::Round(Box::new(of)))?;
            }
            Job::Reopen => {
                let messages = context.messages().clone();
                let before = messages.all().len();
                drop(context);
                say(&Reply::Closed(host_bytes(), messages.all().split_off(before)))?;
                context = open()?;
            }
        }
    }
    Ok(())
}

/// Sends a row for each technique at a value of a sweep.
fn answer(context: &Context, sweep: &Sweep, value: f64, techniques: &[String]) -> Result<()> {
    let scene = sweep.scene(value);
    let subject = Subject::new(&scene);
    subject.find_truth();
    say(&Reply::Ready)?;
    for text in techniques {
        for mut spec in parse(text)? {
            let short = spec.short();
            let side = sweep.texels.map(|texels| texels(value).to_string());
            if let Some(side) = &side {
                spec.set(Name::SIZE, side);
            }
            let row = match side.filter(|side| spec.text(Name::SIZE) != *side) {
                // A size that the technique does not support is refused, not replaced.
                Some(side) => {
                    let reason = format!("refused: has no maps of {side} texels per side");
                    no_answer(&sweep.name, value, &spec, Outcome::Refused, reason)
                }
                None => ask(context, &subject, (&sweep.name, value), &spec),
            };
            say(&Reply::Row(Box::new(CaseResult { technique: short, ..row })))?;
        }
    }
    Ok(())
}

/// Returns a row without figures.
pub(super) fn no_answer(case: &str, value: f64, spec: &Spec, outcome: Outcome, reason: String) -> CaseResult {
    let (technique, path) = (spec.short(), spec.text(Name::PATH).into());
    CaseResult { case: case.into(), value, technique, path, outcome, reason, figures: None }
}

fn say(reply: &Reply) -> Result<()> {
    let told = || -> std::io::Result<()> {
        let mut out = std::io::stdout().lock();
        writeln!(out, "{}", serde_json::to_string(reply)?)?;
        out.flush()
    };
    told().map_err(|cause| Error::output("stdout".as_ref(), cause))
}
