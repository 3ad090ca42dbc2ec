//! The default file is complete and sound; layers win in their order; complaints say what would do.

use super::keys::{Allowed, keys};
use super::parts::Parts;
use super::*;
use gpu::DeviceChoice;
use store::{BlobPlace, DatabaseAddress};

fn arguments(set: &[(&str, &str)]) -> Sources {
    let arguments = set.iter().map(|(key, text)| (key.to_string(), text.to_string(), "--set")).collect();
    Sources { arguments, ..Sources::default() }
}

fn complaint(set: &[(&str, &str)]) -> String {
    layers::load(arguments(set)).expect_err("is refused").to_string()
}

#[test]
fn every_key_is_described_and_every_number_has_a_range() {
    for (path, key) in keys() {
        assert!(key.meaning.ends_with('.'), "{path}: {:?} is no sentence", key.meaning);
        assert!(!key.unit.is_empty(), "{path} has no unit");
        let element = key.default.as_array().and_then(|list| list.first()).unwrap_or(&key.default);
        let number = element.is_integer() || element.is_float();
        assert_eq!(matches!(key.allowed, Allowed::Range { .. }), number, "range of {path}");
        if let Some(open) = &key.open_to_requests {
            let (whole, open) = (ends_of(&key.allowed), ends_of(open));
            assert!(
                whole.0 <= open.0 && open.0 <= open.1 && open.1 <= whole.1,
                "range of {path} for requests"
            );
            let default = key.default.to_string();
            assert!(
                value::parse_for_request(key, &default).is_ok(),
                "{path}: a request may not set {default}"
            );
        }
        assert!(value::fit(key, key.default.clone()).is_ok(), "the default of {path} is outside its range");
    }
}

#[test]
fn defaults_are_a_valid_configuration_and_mirror_every_field() {
    let resolved = layers::load(Sources::default()).expect("the defaults are valid");
    let mirrored = toml::Table::try_from(&resolved.config).expect("is TOML");
    let fields: std::collections::BTreeSet<String> =
        keys::flatten(&mirrored).into_iter().map(|(path, _)| path).collect();
    // Left out while it states nothing, so that identities of stages without it stay.
    let left_out = ["photograph.intrinsics_px"];
    let others: Vec<&str> =
        keys().keys().map(AsRef::as_ref).filter(|key: &&str| !fields.contains(*key)).collect();
    assert_eq!(others, left_out);
    for field in fields {
        assert!(keys().contains_key(&field), "{field} is missing in default.toml");
    }
}

#[test]
fn settings_that_ask_for_a_part_that_is_not_built_are_named() {
    let mut config = layers::load(Sources::default()).expect("the defaults are valid").config;
    let none = Parts { gpu: false, otel: false, postgres: false, s3: false };
    assert_eq!(none.lacking(&config), [], "the defaults ask for no part");
    config.compute.device = DeviceChoice::Gpu;
    config.telemetry.traces_endpoint = "http://collector:4318/v1/traces".into();
    config.store.database = DatabaseAddress::Postgres("postgres://jobs@db/jobs".into());
    config.store.blobs = BlobPlace::S3;
    let why = |what, feature| {
        format!("names {what}, and this program was built without it; build with `--features {feature}`")
    };
    let expected = [
        ("compute.device", why("a GPU", "gpu")),
        ("telemetry.traces_endpoint", why("a collector of traces", "otel")),
        ("store.database", why("PostgreSQL", "postgres")),
        ("store.blobs", why("an S3 bucket", "s3")),
    ];
    assert_eq!(none.lacking(&config), expected);
    assert_eq!(Parts { gpu: true, otel: true, postgres: true, s3: true }.lacking(&config), []);
}

#[test]
fn later_layers_win_and_are_remembered() {
    let directory = tempfile::tempdir().expect("temporary directory");
    let path = directory.path().join("site.toml");
    std::fs::write(&path, "[worker]\nfan_out = 3\npoll_ms = 50\nmax_attempts = 9\n[tsa]\ntau = 1\n")
        .expect("writes");
    let resolved = layers::load(Sources {
        file: Some(path.clone()),
        environment: vec![
            ("TABLETOPGEN__WORKER__POLL_MS".into(), "60".into()),
            ("TABLETOPGEN__WORKER__MAX_ATTEMPTS".into(), "8".into()),
            ("HOME".into(), "/home/somebody".into()),
        ],
        arguments: vec![("worker.max_attempts".into(), "7".into(), "--set")],
    })
    .expect("is valid");
    let Config { worker, tsa, .. } = &resolved.config;
    assert_eq!((worker.fan_out, worker.poll_ms, worker.max_attempts, tsa.tau), (3, 60, 7, 1.0));
    assert_eq!(resolved.origin("worker.fan_out"), &Origin::File(path));
    assert_eq!(resolved.origin("worker.poll_ms").to_string(), "environment TABLETOPGEN__WORKER__POLL_MS");
    assert_eq!(resolved.origin("worker.max_attempts"), &Origin::Argument("--set".into()));
    assert_eq!(resolved.origin("worker.lease_secs"), &Origin::Default);
}

#[test]
fn network_weights_accept_a_file_and_reject_nothing() {
    let weights = "/srv/weights/larger.safetensors";
    let resolved = layers::load(arguments(&[("network.weights", weights)])).expect("is valid");
    assert_eq!(resolved.config.network.weights, weights);
    let text = complaint(&[("network.weights", "")]);
    assert!(text.contains("network.weights is empty: name a safetensors file or \"built-in\""), "{text}");
}

#[test]
fn complaints_name_key_value_and_what_would_do() {
    let text = complaint(&[("worker.concurency", "2")]);
    assert!(text.contains("worker.concurency") && text.contains("nearest is worker.concurrency"), "{text}");
    let text = complaint(&[("worker.concurrency", "100")]);
    assert_eq!(text, "worker.concurrency (--set): 100 is outside its range, from 1 to 64 (jobs)");
    assert!(complaint(&[("worker.concurrency", "two")]).contains("\"two\" is not a whole number"));
    assert!(complaint(&[("tsa.tau", "NaN")]).contains("outside its range"));
    assert!(complaint(&[("log.format", "yaml")]).contains("not one of text, json"));
    assert!(complaint(&[("dro.solver", "newton")]).contains("not one of golden, paper"));
    // A setting without a default has no number.
    for asked in [("appraise.ratings", "true"), ("appraise.tasks", "3")] {
        assert!(complaint(&[asked]).contains("put chat into providers.analyst"), "{asked:?}");
        assert!(layers::load(arguments(&[asked, ("providers.analyst", "chat, embedded")])).is_ok());
    }
    assert!(complaint(&[("features.adapter", "clip")]).contains("not one of descriptor, dinov2"));
    assert!(complaint(&[("store.fsync", "yes")]).contains("true or false"));
    assert!(complaint(&[("resolve.clearances_m", "0.1, 7")]).contains("7 is outside"));
    assert!(complaint(&[("resolve.clearances_m", "[]")]).contains("empty"));
    assert!(complaint(&[("worker", "2")]).contains("no such key"));
    let text = complaint(&[("worker.heartbeat_secs", "20")]);
    assert!(text.contains("worker.lease_secs = 30"), "{text}");
    for (key, value) in [
        ("server.listen", "8080"),
        ("server.max_body_bytes", "20000000"),
        ("worker.backoff_cap_ms", "10"),
        ("log.filter", "tabletopgen=[what"),
        ("features.adapter", "dinov2"),
        ("analyst.default_max_objects", "3"),
        ("layout.min_gap_m", "0.05"),
        ("painter.elevation_rad", "1.2, 0.5"),
        ("painter.elevation_rad", "0.5"),
        ("descriptor.side_px", "97"),
        ("render.shadow_map_px", "5"),
        ("dro.fine_px", "250"),
        ("resolve.clearances_m", "0.2, 0.1"),
        ("export.date", "2026-1-31"),
        ("server.public_url", "scenes.example.org"),
        ("server.public_url", "https://"),
        ("server.allowed_origins", "https://app.example.org https://other.example.org/"),
        ("server.authentication.proxy_user_header", "x user"),
        ("server.authentication.proxy_user_header", "x-user"),
        ("server.authentication.proxy_tenant_header", "x-tenant"),
        ("server.authentication.proxy_usual_scopes", "read all"),
    ] {
        assert!(complaint(&[(key, value)]).starts_with(key), "{key} = {value}");
    }
    let proxy = [
        ("server.authentication.mode", "keys"),
        ("server.authentication.proxy_user_header", "x-user"),
        ("server.proxy_addresses", "10.0.0.1"),
    ];
    assert!(layers::load(arguments(&proxy)).is_ok());
    for lacking in [&proxy[1..], &proxy[..2]] {
        assert!(complaint(lacking).contains("everyone could name any user"), "{lacking:?}");
    }
    let unstable = complaint(&[("settle.solver_iterations", "5")]);
    assert!(unstable.starts_with("settle.contact_frequency_hz"), "{unstable}");
}

#[test]
fn everything_that_is_wrong_is_said_at_once() {
    let text = complaint(&[("worker.fan_out", "0"), ("nothing", "1"), ("tsa.tau", "x")]);
    assert_eq!(text.lines().count(), 3, "{text}");
}

#[test]
fn files_are_read_with_the_same_care() {
    let directory = tempfile::tempdir().expect("temporary directory");
    let path = directory.path().join("site.toml");
    let refused = |text: &str| {
        std::fs::write(&path, text).expect("writes");
        let sources = Sources { file: Some(path.clone()), ..Sources::default() };
        layers::load(sources).expect_err("is refused").to_string()
    };
    assert!(refused("[worker]\nfan_out = 1.5").contains("1.5 is not a whole number"));
    assert!(refused("[worker]\nfan_uot = 1").contains("worker.fan_out"));
    assert!(refused("[walker]\nfan_out = 1").contains("worker.fan_out"));
    assert!(refused("[worker\n").contains("is no TOML"));
    let missing = Sources { file: Some(directory.path().join("none.toml")), ..Sources::default() };
    assert!(layers::load(missing).expect_err("is refused").to_string().contains("cannot be read"));
}

/// The ends of a range; of everything else, all numbers.
fn ends_of(allowed: &Allowed) -> (f64, f64) {
    match allowed {
        Allowed::Range { low, high } => (*low, high.unwrap_or(f64::INFINITY)),
        Allowed::Anything | Allowed::Words(_) => (f64::NEG_INFINITY, f64::INFINITY),
    }
}

#[test]
fn a_request_sets_only_what_is_open_to_it() {
    let resolved = layers::load(Sources::default()).expect("valid");
    let refused = |key: &str, value: &str| {
        let set = [(key.to_owned(), value.to_owned())].into();
        let errors = resolved.with(&set).expect_err(key);
        assert_eq!(errors.0[0].key, key);
        errors.0[0].detail.clone()
    };
    // Each of these is a valid setting of the server, and some of them take minutes of every worker.
    for (key, value) in [
        ("analyst.max_text_chars", "100000"),
        ("layout.attempts", "1000"),
        ("layout.candidates", "1000"),
        ("image_generator.top_px", "4096"),
        ("photograph.top_view_px", "2048"),
        ("category_fit.candidates", "64"),
        ("canonicalize.yaws", "72"),
        ("decompose.excess_spacing_m", "0.001"),
        ("dro.solver", "paper"),
        ("dro.coarse_yaws", "720"),
        ("dro.keep", "64"),
        ("dro.fine_px", "1024"),
        ("settle.duration_s", "60"),
        ("settle.steps_per_s", "2000"),
        ("resolve.separation_passes", "1000"),
        ("resolve.settles", "10"),
        ("certify.sample_spacing_m", "0.0001"),
        ("certify.dss_duration_s", "60"),
        ("certify.dss_displacement_m", "1"),
        ("fidelity.min_silhouette_iou", "0"),
        ("providers.mode", "record"),
        ("worker.concurrency", "64"),
        ("queue.max_jobs", "20000"),
    ] {
        assert!(layers::load(arguments(&[(key, value)])).is_ok() || key.starts_with("providers"), "{key}");
        assert!(refused(key, value).contains("cannot be set for one scene"), "{key}");
    }
    assert!(refused("preview.hero_width_px", "4096").contains("from 64 to 1920"));
    assert!(refused("decompose.max_hulls", "256").contains("from 1 to 64"));
    let long = "0.001, 0.001, 0.001, 0.001, 0.001";
    assert!(refused("resolve.clearances_m", long).contains("at most 4"));
    assert!(is_open_to_requests("no_room.outcome", "shrink") && !is_open_to_requests("no_room.outcome", "x"));
}

#[test]
fn a_request_changes_scenes_and_nothing_else() {
    let resolved = layers::load(Sources::default()).expect("valid");
    let set = |pairs: &[(&str, &str)]| pairs.iter().map(|(k, v)| (k.to_string(), v.to_string())).collect();
    let own =
        resolved.with(&set(&[("decompose.max_hulls", "24"), ("resolve.clearances_m", "[0.001, 0.002]")]));
    let own = own.expect("is valid").config;
    assert_eq!((own.decompose.max_hulls, own.resolve.clearances_m.len()), (24, 2));
    assert_eq!(
        Config {
            decompose: resolved.config.decompose.clone(),
            resolve: resolved.config.resolve.clone(),
            ..own
        },
        resolved.config
    );
    let errors = resolved
        .with(&set(&[
            ("server.listen", "0.0.0.0:80"),
            ("decompose.resolution", "7"),
            ("features.weights", "/etc"),
            ("tsa.tua", "1"),
        ]))
        .expect_err("is refused");
    let keys: Vec<&str> = errors.0.iter().map(|error| error.key.as_str()).collect();
    assert_eq!(keys, ["decompose.resolution", "features.weights", "server.listen", "tsa.tua"]);
    for error in &errors.0[1..3] {
        assert!(error.detail.contains("cannot be set for one scene"), "{error}");
    }
}
