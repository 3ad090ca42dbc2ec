//! Remote models, if any: their endpoints are made once, when the program starts, so that all jobs share rate limiters,
//! circuit breakers and connections. Without any, nothing here touches the network or reads certificates.

use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use crate::config::{ConfigError, ConfigErrors, Resolved};
use embedded::instruction_reader::EnglishReader;
use http_client::cassette::{Cassette, CassetteError};
use http_client::circuit_breaker::CircuitBreaker;
use http_client::rate_limit::RateLimiters;
use http_client::{AddressPolicy, HttpClient, Secret};
use ports::{ImageGenerator, InstructionReader, MeshGenerator, Port, Ports, SceneAnalyst, Segmenter};
use remote::ark;
use remote::ark::ArkImageGenerator;
use remote::chat;
use remote::chat::ChatAnalyst;
use remote::endpoint::Auth;
use remote::fallback::FallbackChain;
use remote::hunyuan3d;
use remote::images;
use remote::images::OpenAiImageGenerator;
use remote::mesh::VendorMeshGenerator;
use remote::replicate;
use remote::settings::{
    AnalystProvider, ArkSettings, EndpointSettings, Hunyuan3dSettings, ImageGeneratorProvider, MeshProvider,
    SegmenterProvider, TransportMode,
};
use remote::sidecar;
use remote::sidecar::SidecarSegmenter;
use remote::tencent;
use remote::{
    ChatSettings, Endpoint, ImagesSettings, ProviderSettings, ReplicateSettings, SidecarSettings,
    TencentSettings,
};

/// The remote providers of the configuration, each port's in its order; `None` stands for the embedded one.
#[derive(Clone)]
pub struct Remote {
    analysts: Vec<Option<Arc<dyn SceneAnalyst>>>,
    /// The analysts, as readers of instructions.
    readers: Vec<Option<Arc<dyn InstructionReader>>>,
    painters: Vec<Option<Arc<dyn ImageGenerator>>>,
    segmenters: Vec<Option<Arc<dyn Segmenter>>>,
    mesh_generators: Vec<Option<Arc<dyn MeshGenerator>>>,
}

impl Remote {
    /// Makes them, with the keys they need.
    pub fn load(resolved: &Resolved) -> Result<Self, ConfigErrors> {
        Self::with_keys(resolved, |variable| std::env::var(variable).ok())
    }

    /// The same; `variable` reads an environment variable.
    fn with_keys(
        resolved: &Resolved,
        variable: impl Fn(&str) -> Option<String>,
    ) -> Result<Self, ConfigErrors> {
        let settings = &resolved.config.providers;
        let mut endpoints = Endpoints::new(resolved, variable);
        let chats = each(&settings.analyst, |provider| analyst(provider, settings, &mut endpoints))?;
        let analysts = chats.iter().cloned().map(|chat| chat.map(|chat| chat as Arc<dyn SceneAnalyst>));
        let readers = chats.iter().cloned().map(|chat| chat.map(|chat| chat as Arc<dyn InstructionReader>));
        Ok(Self {
            analysts: analysts.collect(),
            readers: readers.collect(),
            painters: each(&settings.image_generator, |provider| {
                image_generator(provider, settings, &mut endpoints)
            })?,
            segmenters: each(&settings.segmenter, |provider| segmenter(provider, settings, &mut endpoints))?,
            mesh_generators: each(&settings.mesh_generator, |provider| {
                mesh_generator(provider, settings, &mut endpoints)
            })?,
        })
    }

    /// The reader of instructions with the providers in their order; `None` where the embedded one reads alone.
    pub fn reader(&self) -> Option<Arc<dyn InstructionReader>> {
        let embedded: Arc<dyn InstructionReader> = Arc::new(EnglishReader);
        preferred(&self.readers, &embedded).map(|readers| Arc::new(readers) as Arc<dyn InstructionReader>)
    }

    /// The ports with the providers in their order, the embedded one where it stands.
    pub fn answer(&self, ports: Ports) -> Ports {
        let Ports { mut analyst, mut image_generator, mut segmenter, mut mesh_generator, .. } = ports.clone();
        if let Some(preferred) = preferred(&self.analysts, &analyst) {
            analyst = Arc::new(preferred);
        }
        if let Some(preferred) = preferred(&self.painters, &image_generator) {
            image_generator = Arc::new(preferred);
        }
        if let Some(preferred) = preferred(&self.segmenters, &segmenter) {
            segmenter = Arc::new(preferred);
        }
        if let Some(preferred) = preferred(&self.mesh_generators, &mesh_generator) {
            mesh_generator = Arc::new(preferred);
        }
        Ports { analyst, image_generator, segmenter, mesh_generator, ..ports }
    }
}

/// Adapter of each provider of a port; `None` for the embedded one.
type Made<P> = Result<Option<Arc<P>>, ConfigErrors>;

fn each<T: Copy, P: ?Sized>(
    order: &[T],
    made: impl FnMut(T) -> Made<P>,
) -> Result<Vec<Option<Arc<P>>>, ConfigErrors> {
    order.iter().copied().map(made).collect()
}

fn analyst<V: Fn(&str) -> Option<String>>(
    provider: AnalystProvider,
    settings: &ProviderSettings,
    endpoints: &mut Endpoints<'_, V>,
) -> Made<ChatAnalyst> {
    let (section, chat) = match provider {
        AnalystProvider::Embedded => return Ok(None),
        AnalystProvider::Chat => ("providers.chat", &settings.chat),
        AnalystProvider::SecondChat => ("providers.second_chat", &settings.second_chat),
    };
    let ChatSettings { model, endpoint, idempotency_header, .. } = chat;
    let vendor = Vendor::new(section, Port::Analyst, chat::NAME, model, endpoint);
    let endpoint = endpoints.made(&Vendor { idempotency_header, ..vendor })?;
    Ok(Some(Arc::new(ChatAnalyst { settings: chat.clone(), endpoint })))
}

fn image_generator<V: Fn(&str) -> Option<String>>(
    provider: ImageGeneratorProvider,
    settings: &ProviderSettings,
    endpoints: &mut Endpoints<'_, V>,
) -> Made<dyn ImageGenerator> {
    let port = Port::ImageGenerator;
    Ok(match provider {
        ImageGeneratorProvider::Embedded => None,
        ImageGeneratorProvider::OpenaiImages => {
            let settings = settings.openai_images.clone();
            let ImagesSettings { model, endpoint, .. } = &settings;
            let section = "providers.openai_images";
            let vendor = Vendor::new(section, port, images::NAME, model, endpoint);
            Some(Arc::new(OpenAiImageGenerator { endpoint: endpoints.made(&vendor)?, settings }))
        }
        ImageGeneratorProvider::Ark => {
            let settings = settings.ark.clone();
            let ArkSettings { model, endpoint, .. } = &settings;
            let section = "providers.ark";
            let vendor = Vendor::new(section, port, ark::NAME, model, endpoint);
            Some(Arc::new(ArkImageGenerator { endpoint: endpoints.made(&vendor)?, settings }))
        }
    })
}

fn segmenter<V: Fn(&str) -> Option<String>>(
    provider: SegmenterProvider,
    settings: &ProviderSettings,
    endpoints: &mut Endpoints<'_, V>,
) -> Made<dyn Segmenter> {
    let SegmenterProvider::Sidecar = provider else { return Ok(None) };
    let settings = settings.segmenter_sidecar.clone();
    let SidecarSettings { model, endpoint, .. } = &settings;
    let (section, port) = ("providers.segmenter_sidecar", Port::Segmenter);
    let vendor = Vendor::new(section, port, sidecar::NAME, model, endpoint);
    Ok(Some(Arc::new(SidecarSegmenter { endpoint: endpoints.made(&vendor)?, settings })))
}

fn mesh_generator<V: Fn(&str) -> Option<String>>(
    provider: MeshProvider,
    settings: &ProviderSettings,
    endpoints: &mut Endpoints<'_, V>,
) -> Made<dyn MeshGenerator> {
    let port = Port::MeshGenerator;
    Ok(match provider {
        MeshProvider::Embedded => None,
        MeshProvider::Replicate => {
            let settings = settings.replicate.clone();
            let ReplicateSettings { version, endpoint, .. } = &settings;
            let section = "providers.replicate";
            replicate::wire::prediction(&settings, "", 0)
                .map_err(|error| wrong(endpoints.resolved, section, "inputs", error.to_string()))?;
            let name = replicate::NAME;
            let vendor = Vendor::new(section, port, name, version, endpoint);
            let endpoint = endpoints.made(&vendor)?;
            Some(Arc::new(VendorMeshGenerator::new(settings, endpoint)))
        }
        MeshProvider::Hunyuan3d => {
            let settings = settings.hunyuan3d.clone();
            let Hunyuan3dSettings { model, endpoint, .. } = &settings;
            let (section, name) = ("providers.hunyuan3d", hunyuan3d::NAME);
            let vendor = Vendor::new(section, port, name, model, endpoint);
            let endpoint = endpoints.made(&vendor)?;
            Some(Arc::new(VendorMeshGenerator::new(settings, endpoint)))
        }
        MeshProvider::Tencent => {
            let settings = settings.tencent.clone();
            let TencentSettings { model, endpoint, id_variable, .. } = &settings;
            let (section, name) = ("providers.tencent", tencent::NAME);
            let vendor = Vendor::new(section, port, name, model, endpoint);
            let endpoint = endpoints.made(&Vendor { secret_id_variable: Some(id_variable), ..vendor })?;
            Some(Arc::new(VendorMeshGenerator::new(settings, endpoint)))
        }
    })
}

/// The order of preference; `None` where the embedded provider answers alone.
fn preferred<P: ?Sized>(order: &[Option<Arc<P>>], embedded: &Arc<P>) -> Option<FallbackChain<P>> {
    if order.iter().all(Option::is_none) {
        return None;
    }
    let mut order = order.iter().map(|provider| provider.as_ref().unwrap_or(embedded).clone());
    Some(FallbackChain::new(order.next()?, order.collect()))
}

fn wrong(resolved: &Resolved, section: &str, key: &str, detail: String) -> ConfigErrors {
    let key = format!("{section}.{key}");
    ConfigErrors(vec![ConfigError { origin: resolved.origin(&key).clone(), key, detail }])
}

/// Settings of one section about an endpoint.
struct Vendor<'a> {
    section: &'static str,
    port: Port,
    provider: &'static str,
    model: &'a str,
    /// Variable with the id that goes with the key, where the vendor wants signatures.
    secret_id_variable: Option<&'a str>,
    idempotency_header: &'a str,
    settings: &'a EndpointSettings,
}

impl<'a> Vendor<'a> {
    /// One that wants its key sent, and knows no idempotency keys.
    fn new(
        section: &'static str,
        port: Port,
        provider: &'static str,
        model: &'a str,
        settings: &'a EndpointSettings,
    ) -> Self {
        let (secret_id_variable, idempotency_header) = (None, "");
        Self { section, port, provider, model, secret_id_variable, idempotency_header, settings }
    }
}

/// Makes endpoints that share one client and the rate limiters of their keys.
struct Endpoints<'a, V> {
    resolved: &'a Resolved,
    variable: V,
    policy: AddressPolicy,
    client: Option<HttpClient>,
    rate_limiters: RateLimiters,
}

impl<'a, V: Fn(&str) -> Option<String>> Endpoints<'a, V> {
    fn new(resolved: &'a Resolved, variable: V) -> Self {
        let settings = &resolved.config.providers;
        let policy = AddressPolicy::new(settings.allow_http, &settings.private_hosts);
        Self { resolved, variable, policy, client: None, rate_limiters: RateLimiters::default() }
    }

    fn made(&mut self, vendor: &Vendor<'_>) -> Result<Arc<Endpoint>, ConfigErrors> {
        let resolved = self.resolved;
        let wrong = |key: &str, detail: String| wrong(resolved, vendor.section, key, detail);
        let base = self
            .policy
            .check(&vendor.settings.base_url)
            .map_err(|error| wrong("base_url", error.to_string()))?;
        if base.query().is_some() || base.fragment().is_some() {
            let detail = "it ends in a query or a fragment; paths are appended to it".to_owned();
            return Err(wrong("base_url", detail));
        }
        let key = key(&vendor.settings.key_variable, &self.variable)
            .map_err(|error| wrong("key_variable", error.to_string()))?;
        let auth = match vendor.secret_id_variable {
            None => Auth::Bearer,
            Some(variable) => signing(&vendor.settings.base_url, variable, key.is_some(), &self.variable)
                .map_err(|error| wrong("id_variable", error.to_string()))?,
        };
        let client = match &self.client {
            Some(made) => made.clone(),
            None => {
                let made = http_client(resolved, self.policy.clone())?;
                self.client.insert(made).clone()
            }
        };
        let limits = &vendor.settings.limits;
        let rate_limiter = self.rate_limiters.limiter(
            &vendor.settings.base_url,
            key.as_ref(),
            limits.concurrency,
            limits.calls_per_minute,
        );
        Ok(Arc::new(Endpoint {
            port: vendor.port,
            provider: vendor.provider.to_owned(),
            model: vendor.model.to_owned(),
            base_url: vendor.settings.base_url.clone(),
            key,
            auth,
            idempotency_header: vendor.idempotency_header.to_owned(),
            limits: limits.clone(),
            on_unknown: resolved.config.providers.on_unknown,
            client,
            rate_limiter,
            circuit_breaker: CircuitBreaker::new(
                limits.breaker_failures,
                Duration::from_secs(limits.breaker_rest_secs),
            ),
        }))
    }
}

/// The one client, through the network or a recording.
fn http_client(resolved: &Resolved, policy: AddressPolicy) -> Result<HttpClient, ConfigErrors> {
    let settings = &resolved.config.providers;
    let place = Path::new(&settings.cassette);
    let unusable = |error: CassetteError| wrong(resolved, "providers", "cassette", error.to_string());
    let network = |policy| {
        let timeout = Duration::from_secs(settings.connect_timeout_secs);
        HttpClient::new(policy, timeout).map_err(|error| {
            let message = format!("the client cannot be made: {error}; install CA certificates");
            wrong(resolved, "providers", "connect_timeout_secs", message)
        })
    };
    match settings.mode {
        TransportMode::Live => network(policy),
        TransportMode::Record => {
            let cassette = Cassette::record_into(place).map_err(unusable)?;
            Ok(network(policy)?.recording(Arc::new(cassette)))
        }
        TransportMode::Replay => {
            let cassette = Cassette::replay(place).map_err(unusable)?;
            Ok(HttpClient::replaying(policy, Arc::new(cassette)))
        }
    }
}

/// Reason why the key of an endpoint cannot be used. `name` is that of its variable.
#[derive(Debug, thiserror::Error)]
enum KeyError {
    #[error("{name} and {name}_FILE are both set; unset one")]
    BothSet { name: String },
    #[error("{name} is empty")]
    Empty { name: String },
    #[error("{name}_FILE names {path}, which cannot be read: {source}")]
    Unreadable { name: String, path: String, source: std::io::Error },
    #[error("{name}_FILE names {path}, which is empty")]
    EmptyFile { name: String, path: String },
    /// The variable of the id that goes with a key.
    #[error("{name} is not set, and the key is of no use without it")]
    NoId { name: String },
}

/// Signature of requests to a service that wants one. Without a key nothing is signed, and the service says so.
fn signing(
    base_url: &str,
    variable_name: &str,
    has_key: bool,
    variable: impl Fn(&str) -> Option<String>,
) -> Result<Auth, KeyError> {
    let secret_id = key(variable_name, variable)?.map(Secret::into_id);
    if secret_id.is_none() && has_key {
        return Err(KeyError::NoId { name: variable_name.to_owned() });
    }
    let host = base_url.split("://").nth(1).unwrap_or_default();
    let service = host.split(['.', ':', '/']).next().unwrap_or_default().to_owned();
    Ok(Auth::Tc3 { secret_id: secret_id.unwrap_or_default(), service })
}

/// The key in a variable, or in the file that the variable with `_FILE` names; none where neither is set.
fn key(name: &str, variable: impl Fn(&str) -> Option<String>) -> Result<Option<Secret>, KeyError> {
    if name.is_empty() {
        return Ok(None);
    }
    let (text, file) = (variable(name), variable(&format!("{name}_FILE")));
    let name = name.to_owned();
    match (text, file) {
        (Some(_), Some(_)) => Err(KeyError::BothSet { name }),
        (Some(text), None) => Secret::new(&text).map(Some).ok_or(KeyError::Empty { name }),
        (None, Some(path)) => match std::fs::read_to_string(&path) {
            Ok(text) => Secret::new(&text).map(Some).ok_or(KeyError::EmptyFile { name, path }),
            Err(source) => Err(KeyError::Unreadable { name, path, source }),
        },
        (None, None) => Ok(None),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::{Sources, layers};

    fn resolved(set: &[(&str, &str)]) -> Resolved {
        let arguments = set.iter().map(|(key, text)| (key.to_string(), text.to_string(), "--set")).collect();
        layers::load(Sources { arguments, ..Sources::default() }).expect("is valid")
    }

    fn loaded(set: &[(&str, &str)], variables: &[(&str, &str)]) -> Result<Remote, String> {
        let variable = |name: &str| {
            variables.iter().find(|(known, _)| *known == name).map(|(_, value)| value.to_string())
        };
        Remote::with_keys(&resolved(set), variable).map_err(|errors| errors.to_string())
    }

    #[test]
    fn the_default_is_embedded_and_needs_nothing() {
        let remote = loaded(&[], &[]).expect("loads");
        assert!(remote.analysts.len() == 1 && remote.analysts[0].is_none());
    }

    #[test]
    fn what_is_wrong_is_found_before_any_work_and_names_its_key() {
        let chat = ("providers.analyst", "chat, embedded");
        let complaint = |set: &[(&str, &str)], variables: &[(&str, &str)]| {
            loaded(&[&[chat], set].concat(), variables).err().expect("is refused")
        };
        let message = complaint(&[("providers.chat.base_url", "http://api.openai.com/v1")], &[]);
        assert!(message.contains("providers.chat.base_url") && message.contains("allow_http"), "{message}");
        let message = complaint(&[("providers.chat.base_url", "https://10.0.0.1/v1")], &[]);
        assert!(message.contains("private_hosts"), "{message}");
        let message = complaint(&[("providers.chat.base_url", "https://a.example.org/v1?key=abc")], &[]);
        assert!(message.contains("query") && !message.contains("abc"), "{message}");
        let message = complaint(&[], &[("OPENAI_API_KEY", " ")]);
        assert!(message.contains("OPENAI_API_KEY is empty"), "{message}");
        let message = complaint(&[], &[("OPENAI_API_KEY_FILE", "/nowhere/key")]);
        assert!(message.contains("cannot be read"), "{message}");
        let played = [("providers.mode", "replay"), ("providers.cassette", "/nowhere/cassette.zip")];
        let message = complaint(&played, &[]);
        assert!(
            message.contains("providers.cassette") && message.contains("/nowhere/cassette.zip"),
            "{message}"
        );
    }

    #[test]
    fn every_port_has_its_providers() {
        let set = [
            ("providers.analyst", "chat, embedded"),
            ("providers.image_generator", "openai_images, embedded"),
            ("providers.segmenter", "sidecar, embedded"),
            ("providers.mesh_generator", "replicate, embedded"),
            ("providers.segmenter_sidecar.base_url", "https://segmenter.example.org"),
        ];
        let remote = loaded(&set, &[]).expect("loads");
        let counts = [
            remote.analysts.len(),
            remote.painters.len(),
            remote.segmenters.len(),
            remote.mesh_generators.len(),
        ];
        assert_eq!(counts, [2; 4]);
        let message = loaded(&[&set[..], &[("providers.replicate.inputs", "[]")]].concat(), &[]).err();
        assert!(message.expect("is refused").contains("providers.replicate.inputs"));
    }

    #[test]
    fn keys_come_from_a_variable_or_its_file() {
        let directory = tempfile::tempdir().expect("temporary directory");
        let path = directory.path().join("key");
        std::fs::write(&path, "sk-file\n").expect("writes");
        let path = path.to_string_lossy().into_owned();
        let read = |set: &[(&str, String)]| {
            key("K", |name| set.iter().find(|(known, _)| *known == name).map(|(_, value)| value.clone()))
        };
        assert_eq!(read(&[("K", "sk-1".into())]).expect("is usable"), Secret::new("sk-1"));
        assert_eq!(read(&[("K_FILE", path.clone())]).expect("is usable"), Secret::new("sk-file"));
        let both = read(&[("K", "sk-1".into()), ("K_FILE", path)]).expect_err("is refused");
        assert_eq!(both.to_string(), "K and K_FILE are both set; unset one");
        assert_eq!(read(&[]).expect("needs none"), None);
    }
}
