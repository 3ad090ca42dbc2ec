//! Several providers of one port, in an order of preference: the first that can answers.

use std::sync::Arc;

use serde_json::json;

use imaging::Mask;
use ports::{
    Adapter, Answer, Call, Completion, CompletionRequest, Judgement, MeshGenerator, Painter, Painting,
    ProviderError, RawMesh, RawTable, ReconstructionRequest, Reference, SceneAnalyst, Segmentation,
    Segmenter, TaskQuestion, TopBoxes, TopCheck, TopPicture, TopVerdict, TopViewRequest, Upright,
    UprightQuestion,
};
use scene::appraisal::{Opinion, ProposedTask, Rating};
use scene::request::RequestOptions;
use scene::{Recognition, RecognizedTable, SceneDescription};

/// Providers of the port `P` (`dyn SceneAnalyst`), the preferred one first.
pub struct Preferred<P: ?Sized> {
    first: Arc<P>,
    others: Vec<Arc<P>>,
}

impl<P: ?Sized> Preferred<P> {
    pub fn new(first: Arc<P>, others: Vec<Arc<P>>) -> Self {
        Self { first, others }
    }

    /// Asks one after the other. When none answers, the failure that tells most is returned: that somebody cannot do
    /// it at all says nothing about what those who can are going through.
    async fn ask<'a, T>(&'a self, question: impl Fn(&'a P) -> Answer<'a, T>) -> Result<T, ProviderError> {
        let mut failure = match question(self.first.as_ref()).await {
            Ok(answer) => return Ok(answer),
            Err(error) => error,
        };
        for provider in &self.others {
            if !failure.another_may_answer() {
                return Err(failure);
            }
            tracing::info!(reason = %failure, "asking the next provider");
            match question(provider.as_ref()).await {
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

    /// Whichever of them answers, the key names them all.
    fn all(&self, adapter: impl Fn(&P) -> Adapter) -> Adapter {
        let all: Vec<Adapter> =
            std::iter::once(&self.first).chain(&self.others).map(|provider| adapter(provider)).collect();
        if let [only] = all.as_slice() {
            return only.clone();
        }
        let join = |part: fn(&Adapter) -> &str| all.iter().map(part).collect::<Vec<_>>().join(", else ");
        Adapter {
            name: join(|adapter| &adapter.name),
            model: join(|adapter| &adapter.model),
            settings: json!(all),
        }
    }
}

impl SceneAnalyst for Preferred<dyn SceneAnalyst> {
    fn adapter(&self) -> Adapter {
        self.all(SceneAnalyst::adapter)
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

    fn upright<'a>(&'a self, call: &'a Call, question: UprightQuestion) -> Answer<'a, Upright> {
        Box::pin(self.ask(move |analyst| analyst.upright(call, question.clone())))
    }

    fn check_top_view<'a>(&'a self, call: &'a Call, question: TopCheck) -> Answer<'a, TopVerdict> {
        Box::pin(self.ask(move |analyst| analyst.check_top_view(call, question.clone())))
    }

    fn judge<'a>(&'a self, call: &'a Call, question: Judgement) -> Answer<'a, Opinion<Vec<Rating>>> {
        Box::pin(self.ask(move |analyst| analyst.judge(call, question.clone())))
    }

    fn propose_tasks<'a>(
        &'a self,
        call: &'a Call,
        question: TaskQuestion,
    ) -> Answer<'a, Opinion<Vec<ProposedTask>>> {
        Box::pin(self.ask(move |analyst| analyst.propose_tasks(call, question.clone())))
    }
}

impl Painter for Preferred<dyn Painter> {
    fn adapter(&self) -> Adapter {
        self.all(Painter::adapter)
    }

    fn reference<'a>(
        &'a self,
        call: &'a Call,
        description: Arc<SceneDescription>,
        seed: u64,
    ) -> Answer<'a, Painting> {
        Box::pin(self.ask(move |painter| painter.reference(call, description.clone(), seed)))
    }

    fn complete<'a>(&'a self, call: &'a Call, request: CompletionRequest) -> Answer<'a, Completion> {
        Box::pin(self.ask(move |painter| painter.complete(call, request.clone())))
    }

    fn top_view<'a>(&'a self, call: &'a Call, request: TopViewRequest) -> Answer<'a, TopPicture> {
        Box::pin(self.ask(move |painter| painter.top_view(call, request.clone())))
    }
}

impl Segmenter for Preferred<dyn Segmenter> {
    fn adapter(&self) -> Adapter {
        self.all(Segmenter::adapter)
    }

    fn segment<'a>(
        &'a self,
        call: &'a Call,
        reference: Reference,
        recognition: Arc<Recognition>,
    ) -> Answer<'a, Segmentation> {
        Box::pin(self.ask(move |segmenter| segmenter.segment(call, reference.clone(), recognition.clone())))
    }

    fn table<'a>(&'a self, call: &'a Call, reference: Reference) -> Answer<'a, Option<Mask>> {
        Box::pin(self.ask(move |segmenter| segmenter.table(call, reference.clone())))
    }

    fn top_boxes<'a>(
        &'a self,
        call: &'a Call,
        top: TopPicture,
        recognition: Arc<Recognition>,
    ) -> Answer<'a, TopBoxes> {
        Box::pin(self.ask(move |segmenter| segmenter.top_boxes(call, top.clone(), recognition.clone())))
    }
}

impl MeshGenerator for Preferred<dyn MeshGenerator> {
    fn adapter(&self) -> Adapter {
        self.all(MeshGenerator::adapter)
    }

    fn reconstruct<'a>(&'a self, call: &'a Call, request: ReconstructionRequest) -> Answer<'a, RawMesh> {
        Box::pin(self.ask(move |generator| generator.reconstruct(call, request.clone())))
    }

    fn table<'a>(&'a self, call: &'a Call, table: RecognizedTable) -> Answer<'a, RawTable> {
        Box::pin(self.ask(move |generator| generator.table(call, table.clone())))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ports::Port;
    use runtime::Cpu;
    use runtime::Interrupt;

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

        fn upright<'a>(&'a self, _: &'a Call, _: UprightQuestion) -> Answer<'a, Upright> {
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
        let analyst = Preferred::new(made(&providers[0]), providers[1..].iter().map(made).collect());
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
        let failing = |name| Arc::new(Failing(name, down)) as Arc<dyn SceneAnalyst>;
        let analyst = Preferred::new(failing("a"), vec![failing("b")]);
        assert_eq!(analyst.adapter().name, "a, else b");
        assert_eq!(Preferred::new(failing("a"), vec![]).adapter(), failing("a").adapter());
    }
}
