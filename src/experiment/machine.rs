//! The machine and the program that made a run.

use std::time::{Duration, Instant};

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use sysinfo::{
    CpuRefreshKind, MemoryRefreshKind, ProcessRefreshKind, ProcessesToUpdate, RefreshKind, System,
};

use super::folders::hex;

/// The program as it was built.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Program {
    /// The version in Cargo.toml.
    pub version: String,
    /// The full hash of the sources' commit, or `unknown` outside a repository.
    pub commit: String,
    /// Whether the sources had changes that were not committed.
    pub dirty: bool,
    /// SHA-256 of Cargo.lock.
    pub lock: String,
    /// What `rustc --version` prints.
    pub rustc: String,
    /// The target triple.
    pub target: String,
    /// Instructions that the compiler may use everywhere; others are detected at run time.
    pub target_features: String,
}

/// The machine.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Machine {
    /// The brand of the processor, or `unknown`.
    pub cpu: String,
    /// Logical processors that the process may use.
    pub cores: usize,
    /// Main memory in GiB, to one decimal.
    pub memory_gib: f64,
    /// A hash of its name, which only tells whether two runs are from one host.
    pub host: String,
    /// Vector instructions that the fused engine uses.
    pub vectors: String,
}

/// Timings are not trusted if other processes keep more cores busy than this.
pub const TOLERATED_LOAD: f64 = 0.25;

/// Time between measurements of the load, which would be too noisy over a shorter time.
const LOAD_INTERVAL: Duration = Duration::from_millis(1000);

/// Measures the load of the machine by other processes.
pub struct LoadWatch {
    /// One for all processors and one for this process, since each refresh would disturb the other measurement.
    all: System,
    own: System,
    own_time: f64,
    measured: Instant,
    others: f64,
}

impl Machine {
    /// The machine that the process runs on.
    pub fn this() -> Self {
        let system = System::new_with_specifics(
            RefreshKind::nothing()
                .with_cpu(CpuRefreshKind::nothing())
                .with_memory(MemoryRefreshKind::nothing().with_ram()),
        );
        let cpu = system.cpus().first().map_or("unknown", |cpu| cpu.brand()).trim().to_owned();
        let name = System::host_name().unwrap_or_default();
        Machine {
            cpu: if cpu.is_empty() { "unknown".into() } else { cpu },
            cores: std::thread::available_parallelism().map_or(1, usize::from),
            memory_gib: (system.total_memory() as f64 / f64::from(1 << 30) * 10.0).round() / 10.0,
            host: hex(&Sha256::digest(name)[..4]),
            vectors: format!("{:?}", pulp::Arch::new()).split('(').next().unwrap_or("").to_owned(),
        }
    }
}

impl LoadWatch {
    pub fn new() -> Self {
        let mut all = System::new();
        all.refresh_cpu_usage();
        let mut own = System::new();
        let own_time = own_time(&mut own);
        LoadWatch { all, own, own_time, measured: Instant::now(), others: 0.0 }
    }

    /// Number of cores that other processes kept busy, measured at most once per [`LOAD_INTERVAL`].
    pub fn others(&mut self) -> f64 {
        let elapsed = self.measured.elapsed();
        if elapsed >= LOAD_INTERVAL {
            self.all.refresh_cpu_usage();
            let own_time = own_time(&mut self.own);
            let busy =
                f64::from(self.all.global_cpu_usage()) / 100.0 * self.all.cpus().len() as f64;
            let own = (own_time - self.own_time) / elapsed.as_secs_f64();
            (self.own_time, self.measured) = (own_time, Instant::now());
            self.others = (busy - own).max(0.0);
        }
        self.others
    }

    /// The load average of the last minute.
    pub fn average() -> f64 {
        System::load_average().one
    }
}

/// Processor time of this process and of the commands that it ran, in seconds.
fn own_time(system: &mut System) -> f64 {
    let Ok(pid) = sysinfo::get_current_pid() else { return 0.0 };
    let kind = ProcessRefreshKind::nothing().with_cpu();
    system.refresh_processes_specifics(ProcessesToUpdate::Some(&[pid]), true, kind);
    let own =
        system.process(pid).map_or(0.0, |process| process.accumulated_cpu_time() as f64 / 1e3);
    own + children_time()
}

/// Processor time of the children that have ended.
#[cfg(target_os = "linux")]
fn children_time() -> f64 {
    // SAFETY: zeros are a valid value of these plain numbers, and the call writes nothing else.
    let usage = unsafe {
        let mut usage: libc::rusage = std::mem::zeroed();
        libc::getrusage(libc::RUSAGE_CHILDREN, &raw mut usage);
        usage
    };
    let seconds = |time: libc::timeval| time.tv_sec as f64 + 1e-6 * time.tv_usec as f64;
    seconds(usage.ru_utime) + seconds(usage.ru_stime)
}

#[cfg(not(target_os = "linux"))]
fn children_time() -> f64 {
    0.0
}

impl Default for LoadWatch {
    fn default() -> Self {
        LoadWatch::new()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn work_of_this_process_does_not_count_as_load_by_others() {
        let mut system = System::new();
        let before = own_time(&mut system);
        let begin = Instant::now();
        let mut sum = 0_u64;
        while begin.elapsed() < Duration::from_millis(300) {
            sum = sum.wrapping_mul(31).wrapping_add(begin.elapsed().as_nanos() as u64);
        }
        let spent = own_time(&mut system) - before;
        assert!(spent > 0.05, "{spent} s of processor time, {sum}");
        assert!(LoadWatch::new().others() >= 0.0);
    }

    #[test]
    fn the_machine_has_processors_and_memory() {
        let machine = Machine::this();
        assert!(machine.cores >= 1 && machine.memory_gib > 0.0);
        assert_eq!(machine, Machine::this());
    }
}
