//! Several providers of one port, in an order of preference: the first that can answers.

use std::sync::Arc;

use serde_json::json;

use super::{Adapter, Answer, Call, ProviderError, Reference, SceneAnalyst, UprightQuestion};
use crate::align::canonicalize::CanonicalPose;
use crate::scene::request::RequestOptions;
use crate::scene::{Recognition, SceneDescription};

/// Analysts, the preferred one first.
pub struct PreferredAnalyst {
    first: Arc<dyn SceneAnalyst>,
    others: Vec<Arc<dyn SceneAnalyst>>,
}

impl PreferredAnalyst {
    /// One analyst is itself.
    pub fn of(first: Arc<dyn SceneAnalyst>, others: Vec<Arc<dyn SceneAnalyst>>) -> Arc<dyn SceneAnalyst> {
        if others.is_empty() { first } else { Arc::new(Self { first, others }) }
    }

    /// Asks one after the other. When none answers, the failure that tells most is returned: that somebody cannot do
    /// it at all says nothing about what those who can are going through.
    async fn ask<'a, T>(
        &'a self,
        question: impl Fn(&'a dyn SceneAnalyst) -> Answer<'a, T>,
    ) -> Result<T, ProviderError> {
        let mut failure = match question(self.first.as_ref()).await {
            Ok(answer) => return Ok(answer),
            Err(error) => error,
        };
        for analyst in &self.others {
            if !failure.another_may_answer() {
                return Err(failure);
            }
            tracing::info!(reason = %failure, next = analyst.adapter().name, "asking the next provider");
            match question(analyst.as_ref()).await {
                Ok(answer) => return Ok(answer),
                Err(ProviderError::Unsupported { .. }) => {}
                Err(error) => {
                    let told = !matches!(failure, ProviderError::Unsupported { .. });
                    if !told || !error.another_may_answer() {
                        failure = error;
                    }
                }
            }
        }
        Err(failure)
    }
}

impl SceneAnalyst for PreferredAnalyst {
    /// Whichever of them answers, the key names them all.
    fn adapter(&self) -> Adapter {
        let all: Vec<Adapter> =
            std::iter::once(&self.first).chain(&self.others).map(|analyst| analyst.adapter()).collect();
        let join = |part: fn(&Adapter) -> &str| all.iter().map(part).collect::<Vec<_>>().join(", else ");
        Adapter {
            name: join(|adapter| &adapter.name),
            model: join(|adapter| &adapter.model),
            settings: json!(all),
        }
    }

    fn describe<'a>(
        &'a self,
        call: &'a Call,
        text: String,
        seed: u64,
        options: RequestOptions,
    ) -> Answer<'a, SceneDescription> {
        Box::pin(self.ask(move |analyst| analyst.describe(call, text.clone(), seed, options.clone())))
    }

    fn recognize<'a>(
        &'a self,
        call: &'a Call,
        reference: Reference,
        seed: u64,
        options: RequestOptions,
    ) -> Answer<'a, Recognition> {
        Box::pin(self.ask(move |analyst| analyst.recognize(call, reference.clone(), seed, options.clone())))
    }

    fn upright<'a>(&'a self, call: &'a Call, question: UprightQuestion) -> Answer<'a, CanonicalPose> {
        Box::pin(self.ask(move |analyst| analyst.upright(call, question.clone())))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Interrupt;
    use crate::provider::{Cpu, Port};

    type Fail = fn() -> ProviderError;

    /// Fails with what it was made with.
    struct Failing(&'static str, Fail);

    impl SceneAnalyst for Failing {
        fn adapter(&self) -> Adapter {
            Adapter::new(self.0, "1", &())
        }

        fn describe<'a>(
            &'a self,
            _: &'a Call,
            _: String,
            _: u64,
            _: RequestOptions,
        ) -> Answer<'a, SceneDescription> {
            Box::pin(async { Err((self.1)()) })
        }

        fn recognize<'a>(
            &'a self,
            _: &'a Call,
            _: Reference,
            _: u64,
            _: RequestOptions,
        ) -> Answer<'a, Recognition> {
            Box::pin(async { Err((self.1)()) })
        }

        fn upright<'a>(&'a self, _: &'a Call, _: UprightQuestion) -> Answer<'a, CanonicalPose> {
            Box::pin(async { Err((self.1)()) })
        }
    }

    fn cannot() -> ProviderError {
        ProviderError::Unsupported { port: Port::Analyst, adapter: "x".into(), reason: "it cannot".into() }
    }

    fn down() -> ProviderError {
        ProviderError::Transient {
            port: Port::Analyst,
            code: "provider_timeout",
            reason: "it is down".into(),
        }
    }

    fn refuses() -> ProviderError {
        ProviderError::Refused { port: Port::Analyst, code: "answer_refused", reason: "it will not".into() }
    }

    async fn asked(providers: &[(&'static str, Fail)]) -> String {
        let made =
            |(name, fail): &(&'static str, Fail)| Arc::new(Failing(name, *fail)) as Arc<dyn SceneAnalyst>;
        let analyst = PreferredAnalyst::of(made(&providers[0]), providers[1..].iter().map(made).collect());
        let call = Call::without_budget(Cpu::new(1).expect("a pool"), Interrupt::default());
        let answer = analyst.describe(&call, "a desk".into(), 1, RequestOptions::default()).await;
        answer.expect_err("all fail").to_string()
    }

    #[tokio::test]
    async fn the_failure_that_tells_most_is_returned() {
        assert!(asked(&[("a", down), ("b", cannot)]).await.contains("down"));
        assert!(asked(&[("a", cannot), ("b", down)]).await.contains("down"));
        assert!(asked(&[("a", cannot), ("b", cannot)]).await.contains("cannot"));
        assert!(asked(&[("a", down), ("b", refuses)]).await.contains("will not"));
    }

    #[tokio::test]
    async fn a_refusal_is_not_shopped_around() {
        assert!(asked(&[("a", refuses), ("b", down)]).await.contains("will not"));
    }

    #[test]
    fn the_key_names_everybody() {
        let analyst = PreferredAnalyst::of(Arc::new(Failing("a", down)), vec![Arc::new(Failing("b", down))]);
        assert_eq!(analyst.adapter().name, "a, else b");
        assert_eq!(PreferredAnalyst::of(Arc::new(Failing("a", down)), vec![]).adapter().name, "a");
    }
}
