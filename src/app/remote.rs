//! Which remote models answer, if any: their endpoints are made once, when the program starts, so that all jobs share
//! turns, breakers and connections. Without any, nothing here touches the network or looks for certificates.

use std::sync::Arc;
use std::time::Duration;

use crate::config::{ConfigError, ConfigErrors, Resolved};
use crate::provider::preference::PreferredAnalyst;
use crate::provider::remote::address::AddressRules;
use crate::provider::remote::breaker::Breaker;
use crate::provider::remote::chat::{self, ChatAnalyst};
use crate::provider::remote::settings::AnalystProvider;
use crate::provider::remote::turns::AllTurns;
use crate::provider::remote::{ChatSettings, Endpoint, Outbound, Secret};
use crate::provider::{Port, Ports, SceneAnalyst};

/// The remote analysts of the configuration, in its order; `None` stands for the embedded one.
#[derive(Clone)]
pub struct Remote {
    analysts: Vec<Option<Arc<dyn SceneAnalyst>>>,
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
        let rules = AddressRules::new(settings.allow_http, &settings.private_hosts);
        let (mut outbound, mut turns) = (None, AllTurns::default());
        let mut analysts: Vec<Option<Arc<dyn SceneAnalyst>>> = Vec::new();
        for provider in &settings.analyst {
            let (section, chat) = match provider {
                AnalystProvider::Embedded => {
                    analysts.push(None);
                    continue;
                }
                AnalystProvider::Chat => ("providers.chat", &settings.chat),
                AnalystProvider::SecondChat => ("providers.second_chat", &settings.second_chat),
            };
            let wrong = |key: &str, detail: String| {
                let key = format!("{section}.{key}");
                ConfigErrors(vec![ConfigError { origin: resolved.origin(&key).clone(), key, detail }])
            };
            let base = rules.check(&chat.base_url).map_err(|error| wrong("base_url", error.to_string()))?;
            if base.query().is_some() || base.fragment().is_some() {
                return Err(wrong(
                    "base_url",
                    "it ends in a query or a fragment; paths are appended to it".into(),
                ));
            }
            let key = key(&chat.key_variable, &variable).map_err(|error| wrong("key_variable", error))?;
            let outbound = match &outbound {
                Some(made) => made,
                None => {
                    let timeout = Duration::from_secs(settings.connect_timeout_secs);
                    let made = Outbound::new(rules.clone(), timeout).map_err(|error| {
                        wrong(
                            "base_url",
                            format!("the client cannot be made: {error}; install CA certificates"),
                        )
                    })?;
                    outbound.insert(made)
                }
            };
            let endpoint = endpoint(chat, key, outbound.clone(), &mut turns, resolved);
            analysts
                .push(Some(Arc::new(ChatAnalyst { settings: chat.clone(), endpoint: Arc::new(endpoint) })));
        }
        Ok(Self { analysts })
    }

    /// The ports with the analysts in their order, the embedded one where it stands.
    pub fn answer(&self, ports: Ports) -> Ports {
        let embedded = ports.analyst.clone();
        let mut order =
            self.analysts.iter().map(|analyst| analyst.clone().unwrap_or_else(|| embedded.clone()));
        match order.next() {
            Some(first) => Ports { analyst: PreferredAnalyst::of(first, order.collect()), ..ports },
            None => ports,
        }
    }
}

fn endpoint(
    chat: &ChatSettings,
    key: Option<Secret>,
    outbound: Outbound,
    turns: &mut AllTurns,
    resolved: &Resolved,
) -> Endpoint {
    let limits = &chat.limits;
    let turns = turns.of(&chat.base_url, key.as_ref(), limits.concurrency, limits.calls_per_minute);
    Endpoint {
        port: Port::Analyst,
        provider: chat::NAME.to_owned(),
        model: chat.model.clone(),
        base_url: chat.base_url.clone(),
        key,
        idempotency_header: chat.idempotency_header.clone(),
        limits: limits.clone(),
        on_unknown: resolved.config.providers.on_unknown,
        outbound,
        turns,
        breaker: Breaker::new(limits.breaker_failures, Duration::from_secs(limits.breaker_rest_secs)),
    }
}

/// The key in a variable, or in the file that the variable with `_FILE` names; none where neither is set.
fn key(name: &str, variable: impl Fn(&str) -> Option<String>) -> Result<Option<Secret>, String> {
    if name.is_empty() {
        return Ok(None);
    }
    let file = format!("{name}_FILE");
    match (variable(name), variable(&file)) {
        (Some(_), Some(_)) => Err(format!("{name} and {file} are both set; unset one")),
        (Some(text), None) => Secret::new(&text).map(Some).ok_or_else(|| format!("{name} is empty")),
        (None, Some(path)) => {
            let text = std::fs::read_to_string(&path)
                .map_err(|error| format!("{file} names {path}, which cannot be read: {error}"))?;
            Secret::new(&text).map(Some).ok_or_else(|| format!("{file} names {path}, which is empty"))
        }
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
        let told = complaint(&[("providers.chat.base_url", "http://api.openai.com/v1")], &[]);
        assert!(told.contains("providers.chat.base_url") && told.contains("allow_http"), "{told}");
        let told = complaint(&[("providers.chat.base_url", "https://10.0.0.1/v1")], &[]);
        assert!(told.contains("private_hosts"), "{told}");
        let told = complaint(&[("providers.chat.base_url", "https://a.example.org/v1?key=abc")], &[]);
        assert!(told.contains("query") && !told.contains("abc"), "{told}");
        let told = complaint(&[], &[("OPENAI_API_KEY", " ")]);
        assert!(told.contains("OPENAI_API_KEY is empty"), "{told}");
        let told = complaint(&[], &[("OPENAI_API_KEY_FILE", "/nowhere/key")]);
        assert!(told.contains("cannot be read"), "{told}");
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
        assert_eq!(read(&[("K", "sk-1".into())]), Ok(Secret::new("sk-1")));
        assert_eq!(read(&[("K_FILE", path.clone())]), Ok(Secret::new("sk-file")));
        assert!(read(&[("K", "sk-1".into()), ("K_FILE", path)]).is_err());
        assert_eq!(read(&[]), Ok(None));
    }
}
