//! What every call of a port carries.

use std::sync::Arc;

use runtime::{Cpu, Died, Interrupt};

use super::ledger::{Ledger, NoBudget};
use super::{Port, ProviderError};

/// One call: how to compute, when to stop, who keeps the books. None of it may change the answer.
#[derive(Clone)]
pub struct Call {
    pub cpu: Cpu,
    /// Polled at least every 50 ms.
    pub interrupt: Interrupt,
    /// Of what calls over the network cost.
    pub ledger: Arc<dyn Ledger>,
}

impl Call {
    /// A call outside any job: nothing may be spent.
    pub fn without_budget(cpu: Cpu, interrupt: Interrupt) -> Self {
        Self { cpu, interrupt, ledger: Arc::new(NoBudget) }
    }

    /// Runs an embedded adapter's computation on the pool.
    pub async fn compute<T, W>(&self, port: Port, work: W) -> Result<T, ProviderError>
    where
        T: Send + 'static,
        W: FnOnce(&Interrupt) -> Result<T, ProviderError> + Send + 'static,
    {
        self.interrupt.check()?;
        let interrupt = self.interrupt.clone();
        match self.cpu.run(move || work(&interrupt)).await {
            Ok(answer) => answer,
            Err(Died(reason)) => Err(ProviderError::Died { port, reason }),
        }
    }
}
