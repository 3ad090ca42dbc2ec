//! The files that are written from types: as committed, they are what the program says.

use tabletopgen::api;

/// Files that are written from types: their paths, and what is written.
fn written() -> [(&'static str, String); 4] {
    let contract = serde_norway::to_string(&api::contract::document()).expect("a document becomes YAML");
    [
        ("openapi.yaml", contract),
        ("schemas/scene.schema.json", export::scene_schema().expect("a schema is JSON")),
        ("schemas/report.schema.json", export::report::schema().expect("a schema is JSON")),
        ("schemas/task.schema.json", tasks::task::schema().expect("a schema is JSON")),
    ]
}

/// `UPDATE_CONTRACT=1 cargo test -p tabletopgen --test it contract` writes the files.
#[test]
fn the_files_are_what_the_program_says() {
    for (path, written) in written() {
        let place = format!("{}/{path}", env!("CARGO_MANIFEST_DIR"));
        if std::env::var_os("UPDATE_CONTRACT").is_some() {
            std::fs::write(&place, &written).expect("the file is written");
        } else {
            let stored = std::fs::read_to_string(&place).expect("the file is read");
            let differs = written.lines().zip(stored.lines()).position(|(new, old)| new != old);
            assert!(written == stored, "{path} from line {differs:?} on; run it with UPDATE_CONTRACT=1");
        }
    }
}
