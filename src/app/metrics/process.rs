//! Resources of the machine that the process uses, by the names that Prometheus' client libraries use. It is read on
//! demand, from the system's clock and limits, and on Linux from `/proc`.

use std::fs;
use std::sync::OnceLock;
use std::time::{SystemTime, UNIX_EPOCH};

use rustix::process::{Resource, getrlimit};
use rustix::time::{ClockId, clock_gettime};

/// Sets the metrics of the process. The first call counts as its start.
pub fn collect() {
    static START_S: OnceLock<f64> = OnceLock::new();
    let start_s = START_S.get_or_init(|| {
        SystemTime::now().duration_since(UNIX_EPOCH).map_or(0.0, |since| since.as_secs_f64())
    });
    metrics::gauge!("process_start_time_seconds").set(*start_s);
    let used = clock_gettime(ClockId::ProcessCPUTime);
    metrics::counter!("process_cpu_seconds_total").absolute(used.tv_sec.unsigned_abs());
    if let Some(max) = getrlimit(Resource::Nofile).current {
        metrics::gauge!("process_max_fds").set(max as f64);
    }
    if let Ok(open) = fs::read_dir("/proc/self/fd") {
        // One of them is that of the folder.
        metrics::gauge!("process_open_fds").set(open.count().saturating_sub(1) as f64);
    }
    let Ok(status) = fs::read_to_string("/proc/self/status") else { return };
    let field = |name: &str| {
        let rest = status.lines().find_map(|line| line.strip_prefix(name)?.strip_prefix(':'))?;
        rest.split_whitespace().next()?.parse::<f64>().ok()
    };
    for (name, value) in [
        ("process_resident_memory_bytes", field("VmRSS").map(|kib| kib * 1024.0)),
        ("process_virtual_memory_bytes", field("VmSize").map(|kib| kib * 1024.0)),
        ("process_threads", field("Threads")),
    ] {
        if let Some(value) = value {
            metrics::gauge!(name).set(value);
        }
    }
}
