//! Runs the worker process: one that hangs is ended, one that dies becomes a row, and the run goes on with a new one.

use super::Sweep;
use super::results::{Outcome, Stressed};
use super::round::{Failure, Round};
use super::serve::{Job, Reply, no_answer};
use crate::measure::DeviceFacts;
use crate::technique::Spec;
use crate::{Error, Result};
use std::ffi::OsString;
use std::io::{BufRead, BufReader, Write};
use std::process::{Child, ChildStdin, Command, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::thread::JoinHandle;
use std::time::Duration;

/// The end that asks.
pub struct Worker {
    /// How it is started: the program and its arguments.
    command: Vec<OsString>,
    /// How long a row may take.
    limit: Duration,
    /// Its device, and whether that is a software one.
    pub device: (DeviceFacts, bool),
    /// How many processes there were: more than one where some hung or died.
    pub processes: u32,
    running: Running,
}

/// A process, what it says, and the last line that it complains in, once it has ended.
struct Running {
    child: Child,
    jobs: ChildStdin,
    replies: Receiver<String>,
    complaint: Option<JoinHandle<String>>,
}

/// How long a process may take to start and to find the truth of a scene: so many limits, or so long where that is short.
const PREPARING: (u32, Duration) = (4, Duration::from_secs(60));

fn preparing(limit: Duration) -> Duration {
    (limit * PREPARING.0).max(PREPARING.1)
}

impl Worker {
    /// Starts `command`, which is to run [`serve`](fn@super::serve); a row that takes longer than `limit` is none.
    ///
    /// # Errors
    /// [`Error::Gpu`] where it does not start or finds no device.
    pub fn start(command: Vec<OsString>, limit: Duration) -> Result<Self> {
        let (running, device) = Running::start(&command, limit)?;
        Ok(Self { command, limit, device, processes: 1, running })
    }

    /// A row for each spec, in their order, each given to `each` as it comes.
    ///
    /// # Errors
    /// Those of [`Worker::start`], where a new process is needed and does not start.
    pub fn ask(&mut self, sweep: &Sweep, value: f64, specs: &[Spec], mut each: impl FnMut(Stressed)) -> Result<()> {
        let mut left = specs;
        while !left.is_empty() {
            let techniques = left.iter().map(Spec::to_string).collect();
            let (name, given) = (sweep.name.clone(), sweep.given.clone());
            self.running.send(&Job::Value { sweep: name, given, value, techniques });
            let mut ended = match self.running.reply(preparing(self.limit)) {
                Ok(_) => None,
                // All of them would find the same.
                Err(ended) => Some((left.len(), ended)),
            };
            while ended.is_none() && !left.is_empty() {
                match self.running.reply(self.limit) {
                    Ok(Reply::Row(row)) => {
                        each(*row);
                        left = &left[1..];
                    }
                    Ok(_) => {}
                    Err(reason) => ended = Some((1, reason)),
                }
            }
            let Some((lost, (outcome, reason))) = ended else { continue };
            let (lost, rest) = left.split_at(lost.min(left.len()));
            for spec in lost {
                each(no_answer(&sweep.name, value, spec, outcome, reason.clone()));
            }
            left = rest;
            self.restart()?;
        }
        Ok(())
    }

    /// A round of a soak; of one that does not end only the failure, with the technique that was asked last.
    ///
    /// # Errors
    /// Those of [`Worker::start`], where a new process is needed and does not start.
    pub fn round(&mut self, seed: u64) -> Result<Round> {
        self.running.send(&Job::Round(seed));
        let mut technique = String::new();
        loop {
            match self.running.reply(self.limit) {
                Ok(Reply::Round(round)) => return Ok(*round),
                Ok(Reply::Asking(next)) => technique = next,
                Ok(_) => {}
                Err((_, broken)) => {
                    self.restart()?;
                    let failures = vec![Failure { seed, technique, broken }];
                    return Ok(Round { seed, failures, ..Round::default() });
                }
            }
        }
    }

    /// Closes the device and opens it again. What the process held meanwhile, and what was said, leaks too, or how it ended.
    ///
    /// # Errors
    /// As [`Worker::round`].
    pub fn reopen(&mut self) -> Result<(Option<u64>, Vec<String>)> {
        self.running.send(&Job::Reopen);
        loop {
            match self.running.reply(self.limit) {
                Ok(Reply::Closed(bytes, messages)) => return Ok((bytes, messages)),
                Ok(_) => {}
                Err((_, reason)) => {
                    self.restart()?;
                    return Ok((None, vec![reason]));
                }
            }
        }
    }

    /// What it holds on the device is wanted by the next, so that it ends first.
    fn restart(&mut self) -> Result<()> {
        let _ = self.running.child.kill().and_then(|()| self.running.child.wait());
        self.running = Running::start(&self.command, self.limit)?.0;
        self.processes += 1;
        Ok(())
    }
}

impl Running {
    fn start(command: &[OsString], limit: Duration) -> Result<(Self, (DeviceFacts, bool))> {
        let fail = |cause: String| Error::Gpu {
            operation: "start",
            name: "the process that asks".into(),
            cause,
            way_out: "run `gobo devices`, or raise --limit".into(),
        };
        let (program, arguments) = command.split_first().ok_or_else(|| fail("there is no program".into()))?;
        let mut child = Command::new(program)
            .args(arguments)
            // For the C library: memory in several heaps grows for minutes, which would look like a leak.
            .env("MALLOC_ARENA_MAX", "1")
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .map_err(|cause| fail(cause.to_string()))?;
        let (Some(jobs), Some(stdout), Some(stderr)) = (child.stdin.take(), child.stdout.take(), child.stderr.take())
        else {
            return Err(fail("it has no pipes".into()));
        };
        let (sender, replies) = channel();
        std::thread::spawn(move || {
            for line in BufReader::new(stdout).lines().map_while(std::result::Result::ok) {
                if sender.send(line).is_err() {
                    break;
                }
            }
        });
        let complaint = std::thread::spawn(move || {
            let lines = BufReader::new(stderr).split(b'\n').map_while(std::result::Result::ok);
            let lines = lines.map(|line| String::from_utf8_lossy(&line).trim().to_owned());
            lines.filter(|line| !line.is_empty()).last().unwrap_or_default()
        });
        let mut running = Self { child, jobs, replies, complaint: Some(complaint) };
        match running.reply(preparing(limit)) {
            Ok(Reply::Device(facts, is_software)) => Ok((running, (facts, is_software))),
            Ok(_) => Err(fail("it does not name its device".into())),
            Err((_, reason)) => Err(fail(reason)),
        }
    }

    /// Where it cannot be sent the process has ended, which shows as it is asked.
    fn send(&mut self, job: &Job) {
        if let Ok(text) = serde_json::to_string(job) {
            let _ = writeln!(self.jobs, "{text}").and_then(|()| self.jobs.flush());
        }
    }

    /// The next thing that it says, or how it ended.
    fn reply(&mut self, limit: Duration) -> std::result::Result<Reply, (Outcome, String)> {
        match self.replies.recv_timeout(limit) {
            Ok(line) => serde_json::from_str(&line).map_err(|cause| (Outcome::Failed, format!("{cause}: {line}"))),
            Err(RecvTimeoutError::Timeout) => {
                Err((Outcome::NoAnswer, format!("no answer within {} s", limit.as_secs_f64())))
            }
            Err(RecvTimeoutError::Disconnected) => {
                let status = self.child.wait().map_or_else(|cause| cause.to_string(), |status| status.to_string());
                // All of it: the other thread ends where its pipe does.
                let last = self.complaint.take().and_then(|heard| heard.join().ok()).unwrap_or_default();
                Err((Outcome::Failed, format!("the process ended ({status}) {last}").trim_end().to_owned()))
            }
        }
    }
}

impl Drop for Running {
    /// A process that hangs in a driver reacts to nothing else.
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::consume::parse;

    /// A process that does what a shell script says once it has named a device.
    fn rows(script: &str, specs: &str) -> Vec<Stressed> {
        let device = serde_json::to_string(&Reply::Device(DeviceFacts::default(), true)).expect("JSON");
        let script = format!("echo '{device}'; read job; echo '\"Ready\"'; {script}");
        let command = ["sh", "-c", &script].map(OsString::from).to_vec();
        let mut worker = Worker::start(command, Duration::from_millis(200)).expect("a shell");
        let mut rows = Vec::new();
        let sweep = Sweep::named("few").expect("a case").remove(0);
        worker.ask(&sweep, 1.0, &parse(specs).expect("specs"), |row| rows.push(row)).expect("it starts again");
        rows
    }

    /// Each technique has its row, however its process ends, and a new one is asked for the next.
    #[test]
    fn what_hangs_and_what_dies_are_rows() {
        let specs = "avsm:nodes=4|8|16";
        let names: Vec<_> = parse(specs).expect("specs").iter().map(Spec::short).collect();
        let died = rows("exec 1>&-; echo first >&2; sleep 0.05; echo it is lost >&2; echo >&2; exit 7", specs);
        let hung = rows("exec sleep 60", specs);
        for (rows, outcome, words) in
            [(died, Outcome::Failed, "exit status: 7) it is lost"), (hung, Outcome::NoAnswer, "no answer within 0.2 s")]
        {
            assert_eq!(rows.iter().map(|row| row.technique.clone()).collect::<Vec<_>>(), names);
            assert!(rows.iter().all(|row| row.outcome == outcome && row.reason.contains(words)), "{rows:?}");
        }
    }
}
