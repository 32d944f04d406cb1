//! Runs a worker process, which queries the techniques. If the process hangs, it is killed. If it hangs or dies, the row reports this, and
//! the run continues with a new process.

use super::Sweep;
use super::results::{CaseResult, Outcome};
use super::round::{Failure, Round};
use super::worker_protocol::{Job, Reply, no_answer};
use crate::bench::DeviceFacts;
use crate::technique::Spec;
use crate::{Error, Result};
use std::ffi::OsString;
use std::io::{BufRead, BufReader, Write};
use std::process::{Child, ChildStdin, Command, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::thread::JoinHandle;
use std::time::Duration;

/// The parent's side: starts the process, sends it jobs and reads its replies.
pub struct Worker {
    /// The program to start, with its arguments.
    command: Vec<OsString>,
    /// Time limit per row.
    limit: Duration,
    /// The process's device, and whether it is a software device.
    pub device: (DeviceFacts, bool),
    /// Number of processes started so far: more than one if some hung or died.
    pub processes: u32,
    running: Running,
}

/// A running process and its replies; `complaint` returns the last line of its stderr once it has ended.
struct Running {
    child: Child,
    jobs: ChildStdin,
    replies: Receiver<String>,
    complaint: Option<JoinHandle<String>>,
}

/// Time limit for starting a process and for computing a scene's truth: a multiple of the limit per row, but at least this duration.
const PREPARING: (u32, Duration) = (4, Duration::from_secs(60));

fn preparing(limit: Duration) -> Duration {
    (limit * PREPARING.0).max(PREPARING.1)
}

impl Worker {
    /// Starts `command`, which must run [`serve`](fn@super::serve). A row that takes longer than `limit` counts as not answered.
    ///
    /// # Errors
    /// [`Error::Gpu`] if the process does not start or finds no device.
    pub fn start(command: Vec<OsString>, limit: Duration) -> Result<Self> {
        let (running, device) = Running::start(&command, limit)?;
        Ok(Self { command, limit, device, processes: 1, running })
    }

    /// Requests a row per spec, in order, and passes each row to `each` as it arrives.
    ///
    /// # Errors
    /// Fails if a new process is needed and [`Worker::start`] fails.
    pub fn ask(&mut self, sweep: &Sweep, value: f64, specs: &[Spec], mut each: impl FnMut(CaseResult)) -> Result<()> {
        let mut left = specs;
        while !left.is_empty() {
            let techniques = left.iter().map(Spec::to_string).collect();
            let (name, given) = (sweep.name.clone(), sweep.given.clone());
            self.running.send(&Job::Value { sweep: name, given, value, techniques });
            let mut ended = match self.running.reply(preparing(self.limit)) {
                Ok(_) => None,
                // The scene or its truth failed, so all techniques of the job would end the same way.
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

    /// Runs a round of a soak. If the process hangs or dies, the result contains only that failure, with the technique queried last.
    ///
    /// # Errors
    /// Fails if a new process is needed and [`Worker::start`] fails.
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

    /// Closes the device and opens it again. Returns the process's memory in between, in bytes, and the messages reported on closing, such
    /// as leaks; or how the process ended.
    ///
    /// # Errors
    /// See [`Worker::round`].
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

    /// Ends the process before starting the next one, which needs its device memory.
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
            cause: cause.into(),
            way_out: "run `gobo devices`, or raise --limit".into(),
        };
        let (program, arguments) = command.split_first().ok_or_else(|| fail("there is no program".into()))?;
        let mut child = Command::new(program)
            .args(arguments)
            // One heap in the C library: memory in several heaps grows for minutes, which would look like a leak.
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

    /// Sends a job. A failure means that the process has ended, which [`Running::reply`] then reports.
    fn send(&mut self, job: &Job) {
        if let Ok(text) = serde_json::to_string(job) {
            let _ = writeln!(self.jobs, "{text}").and_then(|()| self.jobs.flush());
        }
    }

    /// Returns the process's next reply, or how it ended.
    fn reply(&mut self, limit: Duration) -> std::result::Result<Reply, (Outcome, String)> {
        match self.replies.recv_timeout(limit) {
            Ok(line) => serde_json::from_str(&line).map_err(|cause| (Outcome::Failed, format!("{cause}: {line}"))),
            Err(RecvTimeoutError::Timeout) => {
                Err((Outcome::NoAnswer, format!("no answer within {} s", limit.as_secs_f64())))
            }
            Err(RecvTimeoutError::Disconnected) => {
                let status = self.child.wait().map_or_else(|cause| cause.to_string(), |status| status.to_string());
                // The thread that reads stderr ends with its pipe, so joining it returns the last line.
                let last = self.complaint.take().and_then(|heard| heard.join().ok()).unwrap_or_default();
                Err((Outcome::Failed, format!("the process ended ({status}) {last}").trim_end().to_owned()))
            }
        }
    }
}

impl Drop for Running {
    /// Kills the process, since one that hangs in a driver reacts to nothing else.
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shading::parse;

    /// Returns the rows from a process that runs a shell script after it has named a device.
    fn rows(script: &str, specs: &str) -> Vec<CaseResult> {
        let device = serde_json::to_string(&Reply::Device(DeviceFacts::default(), true)).expect("JSON");
        let script = format!("echo '{device}'; read job; echo '\"Ready\"'; {script}");
        let command = ["sh", "-c", &script].map(OsString::from).to_vec();
        let mut worker = Worker::start(command, Duration::from_millis(200)).expect("a shell");
        let mut rows = Vec::new();
        let sweep = Sweep::named("few").expect("a case").0.remove(0);
        worker.ask(&sweep, 1.0, &parse(specs).expect("specs"), |row| rows.push(row)).expect("it starts again");
        rows
    }

    /// Runs workers that die and workers that hang. Every technique must get its row, with the reason, and the next technique a new
    /// process.
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
