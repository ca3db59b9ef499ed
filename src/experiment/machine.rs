//! Where and by what a run was made.

use std::time::{Duration, Instant};

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use sysinfo::{CpuRefreshKind, MemoryRefreshKind, ProcessesToUpdate, RefreshKind, System};

use super::data::hex;

/// The program as it was built.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Program {
    pub version: String,
    /// Of the sources, or "unknown" outside a repository.
    pub commit: String,
    /// Whether the sources had changes that were not committed.
    pub dirty: bool,
    /// SHA-256 of Cargo.lock.
    pub lock: String,
    pub rustc: String,
    pub target: String,
    /// What the compiler was allowed to use everywhere; more is found when the program runs.
    pub target_features: String,
}

/// The machine.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Machine {
    pub cpu: String,
    pub cores: usize,
    pub memory_gib: f64,
    /// A hash of its name: the same for runs of one host, and no more.
    pub host: String,
    /// Vector instructions that the fused engine takes.
    pub vectors: String,
}

/// From so many cores on that others keep busy, timings are not to be trusted.
pub const LOADED: f64 = 0.25;

/// Between two looks at the load, or it would be noise.
const INTERVAL: Duration = Duration::from_millis(1000);

/// Watches what other processes take of the machine.
pub struct LoadWatch {
    system: System,
    looked: Instant,
    others: f64,
}

impl Machine {
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
        let mut watch = LoadWatch { system: System::new(), looked: Instant::now(), others: 0.0 };
        watch.refresh();
        watch
    }

    fn refresh(&mut self) {
        self.system.refresh_cpu_usage();
        if let Ok(pid) = sysinfo::get_current_pid() {
            self.system.refresh_processes(ProcessesToUpdate::Some(&[pid]), true);
        }
        self.looked = Instant::now();
    }

    /// How many cores others kept busy since the last look that was long enough ago.
    pub fn others(&mut self) -> f64 {
        if self.looked.elapsed() >= INTERVAL {
            self.refresh();
            let all = f64::from(self.system.global_cpu_usage()) * self.system.cpus().len() as f64;
            let pid = sysinfo::get_current_pid().ok();
            let own = pid
                .and_then(|pid| self.system.process(pid))
                .map_or(0.0, |process| f64::from(process.cpu_usage()));
            self.others = ((all - own) / 100.0).max(0.0);
        }
        self.others
    }

    /// The load average of the last minute.
    pub fn average() -> f64 {
        System::load_average().one
    }
}

impl Default for LoadWatch {
    fn default() -> Self {
        LoadWatch::new()
    }
}
