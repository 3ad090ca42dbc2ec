//! The context of a port call.

use std::sync::Arc;

use runtime::{CancelFlag, ComputationFailed, CpuPool};

use super::ledger::{Ledger, MicroUsd, Purse};
use super::{Port, ProviderError};

/// The context of one call: CPU pool, cancellation and ledger. It must not affect the answer.
#[derive(Clone)]
pub struct Call {
    pub cpu: CpuPool,
    /// Polled at least every 50 ms.
    pub cancel: CancelFlag,
    /// The ledger of the costs of network calls.
    pub ledger: Arc<dyn Ledger>,
}

impl Call {
    /// A call outside any job, without a budget.
    pub fn without_budget(cpu: CpuPool, cancel: CancelFlag) -> Self {
        Self { cpu, cancel, ledger: Arc::new(Purse::new(MicroUsd::ZERO)) }
    }

    /// Runs a computation on the pool.
    ///
    /// # Errors
    ///
    /// The error of `work`, a cancelled job, and [`ProviderError::Died`] after a panic.
    pub async fn compute<T, W>(&self, port: Port, work: W) -> Result<T, ProviderError>
    where
        T: Send + 'static,
        W: FnOnce(&CancelFlag) -> Result<T, ProviderError> + Send + 'static,
    {
        self.cancel.check()?;
        let cancel = self.cancel.clone();
        match self.cpu.run(move || work(&cancel)).await {
            Ok(answer) => answer,
            Err(ComputationFailed(reason)) => Err(ProviderError::Died { port, reason }),
        }
    }
}
