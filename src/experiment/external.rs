//! An external solver: a command that gets a problem and a folder, is killed when its time is over, and is evaluated by
//! the files it has written.
//!
//! ```text
//! COMMAND PROBLEM.npz OUT [--max-iterations=N] [--time-limit=SECONDS] [--threads=N] [--key=value ...]
//! ```
//!
//! It runs in the folder of the experiment file. If the command fails, this is the outcome of its run, not an error.

use std::fs::{self, File};
use std::io::{Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use super::instance::Instance;
use super::plan::Planned;
use super::spec::External;
use crate::certificate::DUAL_STEPS;
use crate::error::{Error, Result};
use crate::exchange::{End, Iterates, certify};
use crate::rounding::Rounding;
use crate::run::{Status, Stop};
use crate::solve::{Observer, Request, Solution};
use crate::solver::Method;

/// Time between checks whether a command has ended.
const POLL_INTERVAL: Duration = Duration::from_millis(20);

/// Bytes at the end of `stderr.txt` in which the last line is searched.
const STDERR_TAIL: u64 = 4096;

/// Characters of that line that are reported.
const MAX_REASON_CHARS: usize = 200;

/// Variables from which numerical libraries take their number of threads.
const THREAD_VARIABLES: [&str; 4] =
    ["OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS"];

pub struct Attempt<'a> {
    pub run: &'a Planned<'a>,
    pub external: &'a External,
    pub instance: &'a Instance,
    /// The folder of the experiment file.
    pub folder: &'a Path,
    /// The folder in which the run is made; the standard error of the command stays there as `stderr.txt`.
    pub claimed: &'a Path,
    pub stop: &'a Stop,
}

/// How the command ended.
enum CommandEnd {
    Ended(ExitStatus),
    OutOfTime,
    Interrupted,
    NotStarted(std::io::Error),
}

impl Attempt<'_> {
    /// Runs the command and scores its iterates.
    ///
    /// # Errors
    /// Files of the program cannot be written.
    pub fn make(&self, observe: Observer<'_>) -> Result<Solution> {
        let Attempt { run, instance, claimed, stop, .. } = self;
        let cell = run.instance;
        let problem = instance.exchanged(cell)?;
        let scratch = claimed.join("exchange");
        let io = |path: &Path, error| Error::io(path, error);
        fs::create_dir(&scratch).map_err(|error| io(&scratch, error))?;
        // The command runs in another folder.
        let scratch = fs::canonicalize(&scratch).map_err(|error| io(&scratch, error))?;
        let (npz, out) = (scratch.join("problem.npz"), scratch.join("out"));
        problem.write(&npz)?;
        fs::create_dir(&out).map_err(|error| io(&out, error))?;
        let stderr = claimed.join("stderr.txt");
        let log = File::create(&stderr).map_err(|error| io(&stderr, error))?;
        let command_end = match self.spawn(&npz, &out, log) {
            Err(error) => CommandEnd::NotStarted(error),
            Ok(child) => wait(child, self.external.limit, observe)
                .map_err(|error| io(Path::new(&self.external.command), error))?,
        };
        let request = Request {
            lambda: instance.lambda,
            relaxation: cell.relaxation,
            mass: cell.mass,
            method: Method::default(),
            stop: (*stop).clone(),
            coarse_to_fine: false,
            keep_dual: false,
            rounding: Rounding::Argmax,
            label_gap: None,
        };
        // Messages about its files are kept with the run: they have the path that the user knows, not that of the machine.
        let iterates = Iterates::of(&claimed.join("exchange").join("out"));
        let end = self.end(command_end, &iterates, &stderr);
        let solution = certify(&problem, &iterates, DUAL_STEPS, &request, end, observe)?;
        // The next claim of this run removes a leftover.
        if let Err(error) = fs::remove_dir_all(&scratch) {
            tracing::warn!("{}: {error}", scratch.display());
        }
        Ok(solution)
    }

    fn spawn(&self, npz: &Path, out: &Path, log: File) -> std::io::Result<Child> {
        let Attempt { run, external, folder, stop, .. } = self;
        let folder =
            fs::canonicalize(if folder.as_os_str().is_empty() { Path::new(".") } else { folder })?;
        let mut words = external.command.split_whitespace();
        let program = PathBuf::from(words.next().expect("it is not empty"));
        // A bare name is looked up on the path, as in a shell.
        let program = if program.components().count() > 1 { folder.join(program) } else { program };
        let mut command = Command::new(program);
        command.args(words).arg(npz).arg(out).current_dir(folder);
        if let Some(iterations) = stop.iterations {
            command.arg(format!("--max-iterations={iterations}"));
        }
        if let Some(time) = stop.time {
            command.arg(format!("--time-limit={}", time.as_secs_f64()));
        }
        if let Some(threads) = run.solver.threads {
            command.arg(format!("--threads={threads}"));
            command.envs(THREAD_VARIABLES.map(|variable| (variable, threads.to_string())));
        }
        for (key, value) in run.solver.options.pairs() {
            command.arg(format!("--{key}={value}"));
        }
        command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(log);
        #[cfg(unix)]
        std::os::unix::process::CommandExt::process_group(&mut command, 0);
        command.spawn()
    }

    /// How the run ended.
    fn end(&self, command_end: CommandEnd, iterates: &Iterates, stderr: &Path) -> End {
        let mut warnings = Vec::new();
        let mut fail = |why: String| {
            warnings.push(why);
            Status::Failed
        };
        let (iteration, seconds) =
            iterates.all.last().map_or((0, 0.0), |last| (last.iteration, last.seconds));
        let mut status = match command_end {
            CommandEnd::NotStarted(error) => {
                fail(format!("{} cannot be started: {error}", self.external.command))
            }
            CommandEnd::Ended(exit) if !exit.success() => fail(match last_line(stderr) {
                Ok(last) if last.is_empty() => exit.to_string(),
                Ok(last) => format!("{exit}: {last}"),
                Err(error) => format!("{exit}; {}: {error}", stderr.display()),
            }),
            CommandEnd::OutOfTime => {
                warnings.push(format!(
                    "the command was stopped after {:.0} s, including reading and compiling",
                    self.external.limit.as_secs_f64()
                ));
                Status::TimeLimit
            }
            CommandEnd::Interrupted => Status::Interrupted,
            CommandEnd::Ended(_) if self.stop.iterations.is_some_and(|most| iteration >= most) => {
                Status::IterationLimit
            }
            CommandEnd::Ended(_)
                if self.stop.time.is_some_and(|limit| seconds >= limit.as_secs_f64()) =>
            {
                Status::TimeLimit
            }
            CommandEnd::Ended(_) => Status::Ended,
        };
        if let Some(error) = &iterates.broken
            && status != Status::Interrupted
        {
            warnings.push(error.to_string());
            // A command that was stopped early may not have reached its first line.
            if status != Status::TimeLimit {
                status = Status::Failed;
            }
        }
        let mut options = self.run.solver.options.pairs().clone();
        options.insert("command".into(), self.external.command.clone());
        End { solver: "external".into(), options, status, warnings }
    }
}

fn wait(mut child: Child, limit: Duration, observe: Observer<'_>) -> std::io::Result<CommandEnd> {
    let begin = Instant::now();
    loop {
        if has_ended(&mut child)? {
            return end_group(&mut child).map(CommandEnd::Ended);
        }
        let late = begin.elapsed() >= limit;
        if late || observe(None).is_break() {
            end_group(&mut child)?;
            return Ok(if late { CommandEnd::OutOfTime } else { CommandEnd::Interrupted });
        }
        sleep(POLL_INTERVAL);
    }
}

/// Whether the command has ended. It is not reaped yet, so that its process number is not reused.
#[cfg(target_os = "linux")]
fn has_ended(child: &mut Child) -> std::io::Result<bool> {
    let flags = libc::WEXITED | libc::WNOHANG | libc::WNOWAIT;
    // SAFETY: zeros are a valid value of these plain numbers, and the call writes nothing else.
    let (result, information) = unsafe {
        let mut information: libc::siginfo_t = std::mem::zeroed();
        (libc::waitid(libc::P_PID, child.id(), &raw mut information, flags), information)
    };
    if result != 0 {
        return Err(std::io::Error::last_os_error());
    }
    // SAFETY: the field is there after `waitid`, and zero if nothing has ended.
    Ok(unsafe { information.si_pid() } != 0)
}

#[cfg(not(target_os = "linux"))]
fn has_ended(child: &mut Child) -> std::io::Result<bool> {
    Ok(child.try_wait()?.is_some())
}

/// Kills the command and every process it started, which would disturb later runs.
fn end_group(child: &mut Child) -> std::io::Result<ExitStatus> {
    #[cfg(target_os = "linux")]
    {
        let group = i32::try_from(child.id()).expect("process numbers are small");
        // SAFETY: no memory is involved. The group is the child's own, made by `process_group(0)`, and still exists,
        // since the child has not been reaped.
        unsafe { libc::kill(-group, libc::SIGKILL) };
    }
    child.kill()?;
    child.wait()
}

/// The last line that is not blank.
fn last_line(path: &Path) -> std::io::Result<String> {
    let mut file = File::open(path)?;
    let length = file.metadata()?.len();
    file.seek(SeekFrom::Start(length.saturating_sub(STDERR_TAIL)))?;
    let mut bytes = Vec::new();
    file.read_to_end(&mut bytes)?;
    let text = String::from_utf8_lossy(&bytes);
    let last = text.split(['\n', '\r']).rev().map(str::trim).find(|line| !line.is_empty());
    let plain = last.unwrap_or("").chars().filter(|c| !c.is_control());
    Ok(plain.take(MAX_REASON_CHARS).collect())
}
