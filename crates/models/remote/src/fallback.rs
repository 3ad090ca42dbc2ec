//! Fallback between several providers of one port: the first that can answers.

use std::sync::Arc;

use serde_json::json;

use imaging::Mask;
use ports::{
    Adapter, Answer, Call, Completion, CompletionRequest, GeneratedReference, ImageGenerator, Instruction,
    InstructionReader, Judgement, MeshGenerator, ProviderError, RawMesh, RawTable, RecognitionHints,
    ReconstructionRequest, ReferenceImage, SceneAnalyst, Segmentation, Segmenter, TableRequest, TaskQuestion,
    TopBoxes, TopCheck, TopVerdict, TopViewImage, TopViewRequest, Upright, UprightQuestion,
};
use scene::appraisal::{ModelResponse, ProposedTask, Rating};
use scene::request::RequestOptions;
use scene::{EditProgram, Recognition, SceneDescription, TaskProgram};

/// Providers of the port `P` (`dyn SceneAnalyst`), the preferred one first.
pub struct FallbackChain<P: ?Sized> {
    first: Arc<P>,
    others: Vec<Arc<P>>,
}

impl<P: ?Sized> FallbackChain<P> {
    pub fn new(first: Arc<P>, others: Vec<Arc<P>>) -> Self {
        Self { first, others }
    }

    /// Asks the providers in order. Where none answers, returns the most informative failure: `Unsupported` is returned
    /// only if every provider lacks the capability.
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
                    let is_informative = !matches!(failure, ProviderError::Unsupported { .. });
                    if !is_informative || !error.another_may_answer() {
                        failure = error;
                    }
                }
            }
        }
        Err(failure)
    }

    /// The joint identity of all providers, since any of them may answer.
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

impl SceneAnalyst for FallbackChain<dyn SceneAnalyst> {
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
        reference: ReferenceImage,
        seed: u64,
        options: RequestOptions,
        hints: Option<Arc<RecognitionHints>>,
    ) -> Answer<'a, Recognition> {
        Box::pin(self.ask(move |analyst| {
            analyst.recognize(call, reference.clone(), seed, options.clone(), hints.clone())
        }))
    }

    fn adapter_with_hints(&self) -> Adapter {
        self.all(SceneAnalyst::adapter_with_hints)
    }

    fn upright<'a>(&'a self, call: &'a Call, question: UprightQuestion) -> Answer<'a, Upright> {
        Box::pin(self.ask(move |analyst| analyst.upright(call, question.clone())))
    }

    fn check_top_view<'a>(&'a self, call: &'a Call, question: TopCheck) -> Answer<'a, TopVerdict> {
        Box::pin(self.ask(move |analyst| analyst.check_top_view(call, question.clone())))
    }

    fn judge<'a>(&'a self, call: &'a Call, question: Judgement) -> Answer<'a, ModelResponse<Vec<Rating>>> {
        Box::pin(self.ask(move |analyst| analyst.judge(call, question.clone())))
    }

    fn propose_tasks<'a>(
        &'a self,
        call: &'a Call,
        question: TaskQuestion,
    ) -> Answer<'a, ModelResponse<Vec<ProposedTask>>> {
        Box::pin(self.ask(move |analyst| analyst.propose_tasks(call, question.clone())))
    }
}

impl InstructionReader for FallbackChain<dyn InstructionReader> {
    fn read_edit<'a>(&'a self, call: &'a Call, instruction: Instruction) -> Answer<'a, EditProgram> {
        Box::pin(self.ask(move |reader| reader.read_edit(call, instruction.clone())))
    }

    fn read_task<'a>(&'a self, call: &'a Call, instruction: Instruction) -> Answer<'a, TaskProgram> {
        Box::pin(self.ask(move |reader| reader.read_task(call, instruction.clone())))
    }
}

impl ImageGenerator for FallbackChain<dyn ImageGenerator> {
    fn adapter(&self) -> Adapter {
        self.all(ImageGenerator::adapter)
    }

    fn reference<'a>(
        &'a self,
        call: &'a Call,
        description: Arc<SceneDescription>,
        seed: u64,
    ) -> Answer<'a, GeneratedReference> {
        Box::pin(self.ask(move |image_generator| image_generator.reference(call, description.clone(), seed)))
    }

    fn reference_of_objects<'a>(
        &'a self,
        call: &'a Call,
        description: Arc<SceneDescription>,
        seed: u64,
    ) -> Answer<'a, GeneratedReference> {
        let ask = move |image_generator: &'a dyn ImageGenerator| {
            image_generator.reference_of_objects(call, description.clone(), seed)
        };
        Box::pin(self.ask(ask))
    }

    fn complete<'a>(&'a self, call: &'a Call, request: CompletionRequest) -> Answer<'a, Completion> {
        Box::pin(self.ask(move |image_generator| image_generator.complete(call, request.clone())))
    }

    fn top_view<'a>(&'a self, call: &'a Call, request: TopViewRequest) -> Answer<'a, TopViewImage> {
        Box::pin(self.ask(move |image_generator| image_generator.top_view(call, request.clone())))
    }
}

impl Segmenter for FallbackChain<dyn Segmenter> {
    fn adapter(&self) -> Adapter {
        self.all(Segmenter::adapter)
    }

    fn segment<'a>(
        &'a self,
        call: &'a Call,
        reference: ReferenceImage,
        recognition: Arc<Recognition>,
    ) -> Answer<'a, Segmentation> {
        Box::pin(self.ask(move |segmenter| segmenter.segment(call, reference.clone(), recognition.clone())))
    }

    fn table<'a>(&'a self, call: &'a Call, reference: ReferenceImage) -> Answer<'a, Option<Mask>> {
        Box::pin(self.ask(move |segmenter| segmenter.table(call, reference.clone())))
    }

    fn top_boxes<'a>(
        &'a self,
        call: &'a Call,
        top: TopViewImage,
        recognition: Arc<Recognition>,
    ) -> Answer<'a, TopBoxes> {
        Box::pin(self.ask(move |segmenter| segmenter.top_boxes(call, top.clone(), recognition.clone())))
    }
}

impl MeshGenerator for FallbackChain<dyn MeshGenerator> {
    fn adapter(&self) -> Adapter {
        self.all(MeshGenerator::adapter)
    }

    fn reconstruct<'a>(&'a self, call: &'a Call, request: ReconstructionRequest) -> Answer<'a, RawMesh> {
        Box::pin(self.ask(move |generator| generator.reconstruct(call, request.clone())))
    }

    fn table<'a>(&'a self, call: &'a Call, request: TableRequest) -> Answer<'a, RawTable> {
        Box::pin(self.ask(move |generator| generator.table(call, request.clone())))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ports::Port;
    use runtime::CancelFlag;
    use runtime::CpuPool;

    type Fail = fn() -> ProviderError;

    /// Fails with the given error.
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
            _: ReferenceImage,
            _: u64,
            _: RequestOptions,
            _: Option<Arc<RecognitionHints>>,
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
        let analyst = FallbackChain::new(made(&providers[0]), providers[1..].iter().map(made).collect());
        let call = Call::without_budget(CpuPool::new(1).expect("a pool"), CancelFlag::default());
        let answer = analyst.describe(&call, "a desk".into(), 1, RequestOptions::default()).await;
        answer.expect_err("all fail").to_string()
    }

    #[tokio::test]
    async fn chain_prefers_informative_failures() {
        assert!(asked(&[("a", down), ("b", cannot)]).await.contains("down"));
        assert!(asked(&[("a", cannot), ("b", down)]).await.contains("down"));
        assert!(asked(&[("a", cannot), ("b", cannot)]).await.contains("cannot"));
        assert!(asked(&[("a", down), ("b", refuses)]).await.contains("will not"));
    }

    #[tokio::test]
    async fn chain_stops_at_a_refusal() {
        assert!(asked(&[("a", refuses), ("b", down)]).await.contains("will not"));
    }

    #[test]
    fn identity_names_every_provider() {
        let failing = |name| Arc::new(Failing(name, down)) as Arc<dyn SceneAnalyst>;
        let analyst = FallbackChain::new(failing("a"), vec![failing("b")]);
        assert_eq!(analyst.adapter().name, "a, else b");
        assert_eq!(FallbackChain::new(failing("a"), vec![]).adapter(), failing("a").adapter());
    }
}
