//! Files and answers that mean harm, or are broken: each is refused by whatever reads its kind, and none brings
//! anything down.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

use bytes::Bytes;
use http_client::HttpResponse;
use imaging::codec::decode_oriented_image;
use mesh_io::gltf::read_mesh_glb;
use mesh_io::obj_archive::read_mesh_obj_archive;
use remote::{chat, hunyuan3d, image, images, replicate, sidecar, tencent};

use crate::harness::server::settings;

/// Names and bytes of the files of a kind.
fn files(kind: &str) -> Vec<(String, Bytes)> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fixtures/hostile").join(kind);
    let mut files: Vec<(String, Bytes)> = std::fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap())
        .map(|entry| (entry.file_name().into_string().unwrap(), std::fs::read(entry.path()).unwrap().into()))
        .collect();
    files.sort();
    files
}

/// Checks that a reader refuses every file with a message and without a panic.
fn refused<T>(kind: &str, read: impl Fn(&Bytes) -> Result<T, String>) {
    let files = files(kind);
    assert!(files.len() >= 5, "{kind}");
    let taken: Vec<String> = files
        .iter()
        .filter_map(|(name, file)| match catch_unwind(AssertUnwindSafe(|| read(file))) {
            Ok(Err(message)) if !message.is_empty() => None,
            Ok(_) => Some(format!("{name} is taken")),
            Err(_) => Some(format!("{name} brings the reader down")),
        })
        .collect();
    assert!(taken.is_empty(), "{kind}: {taken:?}");
}

#[test]
fn meshes() {
    refused("glb", |file| read_mesh_glb(file).map_err(|error| error.to_string()));
    refused("archive", |file| read_mesh_obj_archive(file).map_err(|error| error.to_string()));
}

#[test]
fn images() {
    refused("picture", |file| image::received(file).map_err(|error| error.to_string()));
    // What is only too large for a vendor's image is left to the validation of requests.
    refused("picture", |file| decode_oriented_image(file, 4000).map_err(|error| error.to_string()));
}

#[test]
fn answers() {
    let providers = settings(&[]).config.providers;
    let reply = |body: &Bytes| HttpResponse {
        status: 200,
        content_type: "application/json".into(),
        retry_after: None,
        body: body.clone(),
    };
    let labels = ["mug".to_owned()];
    refused("answer", |file| {
        let read = chat::wire::read(&providers.chat, &reply(file));
        read.result.map_err(|failure| failure.reason)
    });
    refused("answer", |file| {
        let read = images::wire::read(&providers.openai_images, &reply(file));
        read.result.map_err(|failure| failure.reason)
    });
    refused("answer", |file| {
        let read = sidecar::wire::read(&providers.segmenter_sidecar, &reply(file), [4, 4], &labels);
        read.result.map_err(|failure| failure.reason)
    });
    refused("answer", |file| {
        let read = replicate::wire::submitted(&providers.replicate, &reply(file));
        read.result.map_err(|failure| failure.reason)
    });
    refused("answer", |file| replicate::wire::progress(&reply(file)).map_err(|failure| failure.reason));
    refused("answer", |file| {
        let read = hunyuan3d::wire::submitted(&providers.hunyuan3d, &reply(file));
        read.result.map_err(|failure| failure.reason)
    });
    refused("answer", |file| hunyuan3d::wire::progress(&reply(file)).map_err(|failure| failure.reason));
    refused("answer", |file| {
        let read = tencent::wire::submitted(&providers.tencent, &reply(file));
        read.result.map_err(|failure| failure.reason)
    });
    refused("answer", |file| tencent::wire::progress(&reply(file)).map_err(|failure| failure.reason));
}
