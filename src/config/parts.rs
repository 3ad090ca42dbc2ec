//! The optional parts of this program, which are features of its Cargo package, and the settings that ask for them.

use super::Config;
use gpu::DeviceChoice;
use store::{BlobPlace, DatabaseAddress};

/// The parts that a program was built with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Parts {
    pub gpu: bool,
    pub otel: bool,
    pub postgres: bool,
    pub s3: bool,
}

impl Parts {
    /// The parts of this program.
    pub const BUILT: Self = Self {
        gpu: cfg!(feature = "gpu"),
        otel: cfg!(feature = "otel"),
        postgres: cfg!(feature = "postgres"),
        s3: cfg!(feature = "s3"),
    };

    /// Every setting that asks for a part that is not there: the key, and why.
    pub fn lacking(self, config: &Config) -> Vec<(&'static str, String)> {
        let wants_gpu = config.compute.device == DeviceChoice::Gpu;
        let sends_traces = !config.telemetry.traces_endpoint.trim().is_empty();
        let uses_postgres = matches!(config.store.database, DatabaseAddress::Postgres(_));
        let asked = [
            ("compute.device", wants_gpu, self.gpu, "a GPU", "gpu"),
            ("telemetry.traces_endpoint", sends_traces, self.otel, "a collector of traces", "otel"),
            ("store.database", uses_postgres, self.postgres, "PostgreSQL", "postgres"),
            ("store.blobs", config.store.blobs == BlobPlace::S3, self.s3, "an S3 bucket", "s3"),
        ];
        let lacking = asked.into_iter().filter(|(_, is_asked, is_built, ..)| *is_asked && !is_built);
        let complaint = |what, feature| {
            format!("names {what}, and this program was built without it; build with `--features {feature}`")
        };
        lacking.map(|(key, _, _, what, feature)| (key, complaint(what, feature))).collect()
    }
}
