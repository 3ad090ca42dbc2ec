//! Tests of the outputs that may be replaced, and that nothing is half written.

use std::fs;

use super::kind::DATABASE_FILE;
use super::*;

const MANIFEST: &str = r#"{ "format": "tabletopgen-manifest/1", "files": [{ "path": "mjcf/old.xml" }] }"#;

fn home() -> tempfile::TempDir {
    tempfile::tempdir().expect("temporary directory")
}

/// Names of everything in a folder.
fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).expect("a folder").flatten();
    let mut names: Vec<String> =
        entries.map(|entry| entry.file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

fn earlier_bundle(folder: &Path) {
    fs::create_dir_all(folder.join("mjcf")).expect("made");
    fs::write(folder.join("mjcf/old.xml"), "old").expect("written");
    fs::write(folder.join("manifest.json"), MANIFEST).expect("written");
}

fn refusal(path: &Path, is_forced: bool, inputs: &[&Path]) -> String {
    let failure = Output::check(path, Kind::Bundle, is_forced, inputs).expect_err("is refused");
    assert_eq!(failure.exit, Exit::Usage, "{failure}");
    failure.message
}

#[test]
fn a_check_leaves_nothing_and_a_new_folder_appears_whole() {
    let home = home();
    let path = home.path().join("a/b");
    let output = Output::check(&path, Kind::Bundle, false, &[]).expect("is free");
    assert_eq!(names(home.path()), Vec::<String>::new());

    let abandoned = output.begin().expect("begins");
    abandoned.write("mjcf/new.xml", b"new").expect("writes");
    assert!(!path.exists(), "it is written beside");
    drop(abandoned);
    assert_eq!(names(&home.path().join("a")), Vec::<String>::new(), "what was abandoned is gone");

    let partial = output.begin().expect("begins");
    partial.write("mjcf/new.xml", b"new").expect("writes");
    for outside in ["../out", "/etc/x", "a/../../b"] {
        assert!(partial.write(outside, b"").is_err(), "{outside}");
    }
    partial.publish().expect("publishes");
    assert_eq!(names(&home.path().join("a")), ["b"]);
    assert_eq!(fs::read(path.join("mjcf/new.xml")).expect("written"), b"new");
}

#[cfg(unix)]
#[test]
fn a_new_folder_has_the_permissions_of_an_ordinary_one() {
    use std::os::unix::fs::PermissionsExt;
    let home = home();
    fs::create_dir(home.path().join("ordinary")).expect("made");
    let output = Output::check(&home.path().join("new"), Kind::Bundle, false, &[]).expect("is free");
    output.begin().and_then(Partial::publish).expect("publishes");
    let mode = |name: &str| fs::metadata(home.path().join(name)).expect("there").permissions().mode();
    assert_eq!(mode("new"), mode("ordinary"));
}

#[test]
fn an_earlier_output_is_replaced_whole_when_forced_and_only_then() {
    let home = home();
    let path = home.path().join("scene");
    earlier_bundle(&path);
    assert!(refusal(&path, false, &[]).contains("holds a bundle already"));
    let output = Output::check(&path, Kind::Bundle, true, &[]).expect("forced");
    let failed = output.begin().expect("begins");
    failed.write("mjcf/new.xml", b"new").expect("writes");
    drop(failed);
    assert!(path.join("mjcf/old.xml").exists(), "after a failure the earlier one is there");
    let partial = output.begin().expect("begins");
    partial.write("mjcf/new.xml", b"new").expect("writes");
    partial.publish().expect("publishes");
    assert_eq!((names(home.path()), names(&path)), (vec!["scene".to_owned()], vec!["mjcf".to_owned()]));
    assert_eq!(names(&path.join("mjcf")), ["new.xml"]);
}

#[test]
fn files_of_others_are_never_replaced() {
    let home = home();
    let path = home.path().join("scene");
    earlier_bundle(&path);
    fs::write(path.join("mjcf/thesis.tex"), "years of work").expect("written");
    for is_forced in [false, true] {
        let refused = refusal(&path, is_forced, &[]);
        assert!(refused.contains("mjcf/thesis.tex") && refused.contains("no part of a bundle"), "{refused}");
    }
    let other_kind = Output::check(&path, Kind::Execution, true, &[]).expect_err("is no execution");
    assert!(other_kind.message.contains("no part of an execution"), "{other_kind}");
    // A file that comes while the work goes on.
    fs::remove_file(path.join("mjcf/thesis.tex")).expect("removed");
    let output = Output::check(&path, Kind::Bundle, true, &[]).expect("forced");
    let partial = output.begin().expect("begins");
    partial.write("scene.json", b"{}").expect("writes");
    fs::write(path.join("notes.txt"), "mine").expect("written");
    let refused = partial.publish().expect_err("the place was taken").message;
    let kept = refused.rsplit("is in ").next().expect("a path");
    assert!(Path::new(kept).join("scene.json").exists(), "{refused}");
    assert!(path.join("notes.txt").exists() && path.join("mjcf/old.xml").exists());
}

#[test]
fn inputs_are_never_written_to() {
    let home = home();
    let bundle = home.path().join("parents/desk");
    earlier_bundle(&bundle);
    let inputs = [bundle.as_path()];
    assert!(refusal(&bundle, true, &inputs).contains("is an input of this command"));
    assert!(refusal(&home.path().join("parents"), true, &inputs).contains("holds an input"));
    assert!(refusal(&bundle.join("edited"), true, &inputs).contains("lies inside an input"));
    assert!(refusal(&home.path().join("parents/none/../desk"), true, &inputs).contains("is an input"));
    #[cfg(unix)]
    {
        let link = home.path().join("link");
        std::os::unix::fs::symlink(&bundle, &link).expect("linked");
        assert!(refusal(&link, true, &inputs).contains("is an input"));
        std::os::unix::fs::symlink(home.path().join("nowhere"), home.path().join("dangling"))
            .expect("linked");
        assert!(refusal(&home.path().join("dangling"), true, &[]).contains("leads nowhere"));
    }
    Output::check(&home.path().join("parents/desk2"), Kind::Bundle, false, &inputs).expect("beside is free");
}

#[test]
fn nothing_is_written_below_a_file() {
    let home = home();
    fs::write(home.path().join("notes.txt"), "mine").expect("written");
    assert!(refusal(&home.path().join("notes.txt"), true, &[]).contains("is a file"));
    assert!(refusal(&home.path().join("notes.txt/a/b"), true, &[]).contains("lies below the file"));
}

#[test]
fn each_kind_knows_its_own() {
    let home = home();
    let folder = |name: &str, files: &[(&str, &str)]| {
        let folder = home.path().join(name);
        fs::create_dir_all(&folder).expect("made");
        for (file, text) in files {
            let path = folder.join(file);
            fs::create_dir_all(path.parent().expect("a folder")).expect("made");
            fs::write(path, text).expect("written");
        }
        folder
    };
    let execution = r#"{ "task": {}, "seed": 1, "execution": {} }"#;
    let record = r#"{ "custom_id": "a", "state": "succeeded" }"#;
    for (kind, files, is_own) in [
        (Kind::Execution, &[("execution.json", execution), ("task.json", "{}"), ("video.mp4", "")][..], true),
        (Kind::Execution, &[("task.json", "{}")], false),
        (Kind::Execution, &[("execution.json", execution), ("notes.txt", "")], false),
        (Kind::Tasks, &[("domain.bddl", ""), ("task_0001.json", ""), ("task_0001.bddl", "")], true),
        (Kind::Tasks, &[("domain.bddl", ""), ("task.json", "")], false),
        (Kind::Tasks, &[("task_0001.json", "")], false),
        (Kind::Episodes, &[("robomimic/records.jsonl", ""), ("robomimic/dataset.hdf5", "")], true),
        (Kind::Episodes, &[("robomimic/records.jsonl", ""), ("robomimic/policy.pth", "")], false),
        (Kind::Episodes, &[("records/records.jsonl", "")], false),
        (Kind::Episodes, &[("robomimic/dataset.hdf5", "")], false),
        (Kind::Batch, &[("output.jsonl", record), ("anything", "")], true),
        (Kind::Batch, &[("output.jsonl", "{}")], false),
        (Kind::Backup, &[(DATABASE_FILE, "")], true),
        (Kind::Backup, &[("thesis.tex", "")], false),
    ] {
        let path = folder("place", files);
        assert_eq!(Output::check(&path, kind, true, &[]).is_ok(), is_own, "{kind:?} {files:?}");
        fs::remove_dir_all(&path).expect("removed");
        folder("place", &[]);
        Output::check(&path, kind, false, &[]).expect("an empty folder is free");
    }
}

#[test]
fn a_file_is_replaced_when_forced_and_only_then() {
    let home = home();
    let path = home.path().join("page.html");
    let check = |is_forced, inputs: &[&Path]| file::check(&path, "--html", is_forced, inputs);
    check(false, &[]).expect("is free");
    file::write(&path, b"one", false).expect("writes");
    let refused = check(false, &[]).expect_err("it exists").message;
    assert!(refused.starts_with("--html ") && refused.contains("--force"), "{refused}");
    // It came after the check.
    assert!(file::write(&path, b"two", false).is_err());
    assert_eq!(fs::read(&path).expect("there"), b"one");
    check(true, &[]).expect("forced");
    file::write(&path, b"two", true).expect("writes");
    assert_eq!(
        (fs::read(&path).expect("there"), names(home.path())),
        (b"two".to_vec(), vec!["page.html".to_owned()])
    );
    assert!(check(true, &[&path]).expect_err("an input").message.contains("is an input"));
    let folder = file::check(home.path(), "--html", true, &[]).expect_err("a folder").message;
    assert!(folder.contains("is a folder"), "{folder}");
}
