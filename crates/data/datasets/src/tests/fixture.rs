//! Small bundles made by hand, and datasets of them.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use serde_json::{Value, json};
use tempfile::TempDir;

use export::BundleFile;

use crate::bundle::sha256;
use crate::dataset_manifest::Layout;
use crate::filter::Filter;
use crate::freeze::{FreezeRequest, FrozenDataset, freeze};
use crate::sharing::LeakageRules;

/// An object of a scene.
pub struct ObjectSpec {
    pub name: &'static str,
    pub category: &'static str,
    pub size_m: [f64; 3],
    pub at_m: [f64; 3],
    pub mass_kg: f64,
    pub support: (&'static str, &'static str),
    /// Content of its mesh file; the name and the scene's id if it is empty.
    pub mesh: &'static str,
}

/// A box of 0.2 x 0.1 x 0.1 m and 0.3 kg at the center of the table.
pub const MUG: ObjectSpec = ObjectSpec {
    name: "mug_1",
    category: "mug",
    size_m: [0.2, 0.1, 0.1],
    at_m: [0.0, 0.0, 0.0],
    mass_kg: 0.3,
    support: ("table", "on"),
    mesh: "",
};

/// A scene on a table of 1 x 1 m.
pub struct SceneSpec {
    pub id: String,
    pub input: Value,
    pub objects: Vec<ObjectSpec>,
    /// Codes of failed checks; a scene without any passes.
    pub reasons: Vec<&'static str>,
}

impl SceneSpec {
    /// A scene with one mug, of a text.
    pub fn of_text(id: &str, text: &str) -> Self {
        let input = json!({ "kind": "text", "text": text });
        Self { id: id.to_owned(), input, objects: vec![MUG], reasons: Vec::new() }
    }

    /// A scene with one mug, edited from another one.
    pub fn edited(id: &str, parent: &str) -> Self {
        let operations = json!([{ "op": "tidy" }]);
        let input = json!({ "kind": "edit", "parent": parent, "bundle_sha256": "0".repeat(64), "operations": operations });
        Self { input, ..Self::of_text(id, "") }
    }

    /// The files of the bundle, the manifest included.
    pub fn files(&self) -> Vec<BundleFile> {
        let mut files = BTreeMap::new();
        let mut put = |path: &str, bytes: Vec<u8>| files.insert(path.to_owned(), bytes);
        put("scene.json", self.scene().to_string().into_bytes());
        put("report.json", self.report().to_string().into_bytes());
        put("preview/hero.png", format!("hero of {}", self.id).into_bytes());
        put("preview/top.png", format!("top of {}", self.id).into_bytes());
        put("glb/table.glb", b"a table".to_vec());
        for object in &self.objects {
            let mesh = match object.mesh {
                "" => format!("{} of {}", object.name, self.id),
                mesh => mesh.to_owned(),
            };
            put(&format!("glb/{}.glb", object.name), mesh.into_bytes());
        }
        let entries: Vec<Value> = files
            .iter()
            .map(|(path, bytes)| {
                json!({
                    "path": path, "sha256": sha256(bytes), "size": bytes.len(), "role": "r",
                    "media_type": media_type(path),
                })
            })
            .collect();
        let manifest = json!({
            "format": "tabletopgen-manifest/1", "scene": self.id, "licence": "CC0-1.0", "files": entries,
        });
        files.insert("manifest.json".to_owned(), manifest.to_string().into_bytes());
        files
            .into_iter()
            .map(|(path, bytes)| BundleFile::new(path.clone(), bytes, "r", media_type(&path)))
            .collect()
    }

    /// Writes the bundle as a folder.
    pub fn write_folder(&self, root: &Path) -> PathBuf {
        let folder = root.join(&self.id);
        for file in self.files() {
            let path = folder.join(&file.path);
            fs::create_dir_all(path.parent().expect("a folder")).expect("a temporary folder");
            fs::write(path, &file.bytes).expect("a temporary folder");
        }
        folder
    }

    /// Writes the bundle as an archive.
    pub fn write_archive(&self, root: &Path) -> PathBuf {
        let path = root.join(format!("{}.zip", self.id));
        fs::create_dir_all(root).expect("a temporary folder");
        fs::write(&path, export::zip_bundle(&self.files()).expect("an archive")).expect("a temporary folder");
        path
    }

    fn report(&self) -> Value {
        let reasons: Vec<Value> =
            self.reasons.iter().map(|code| json!({ "code": code, "bodies": [], "sentence": "s" })).collect();
        let verdict = if self.reasons.is_empty() { "pass" } else { "quarantine" };
        json!({ "format": "tabletopgen-report/1", "scene": self.id, "verdict": verdict, "reasons": reasons })
    }

    fn scene(&self) -> Value {
        let pose = json!({ "translation_m": [0.0, 0.0, 1.0], "rotation_xyzw": [0.0, 0.0, 0.0, 1.0] });
        let physics = json!({
            "mass_kg": 1.0, "center_of_mass_m": [0.0, 0.0, 0.0], "inertia_diagonal_kg_m2": [1.0, 1.0, 1.0],
            "principal_axes_xyzw": [0.0, 0.0, 0.0, 1.0], "friction": { "static": 0.5, "dynamic": 0.4 },
            "restitution": 0.1, "hulls": 1,
        });
        let table = merged(
            &physics,
            json!({
                "name": "table", "label": "table", "shape": "square", "model": "desk", "height_m": 0.7,
                "outline_m": [[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]], "size_m": [1.0, 1.0, 0.7],
                "mesh": "glb/table.glb",
            }),
        );
        let instance = |object: &ObjectSpec| {
            merged(
                &physics,
                json!({
                    "name": object.name, "label": object.name, "category": object.category,
                    "image": { "bbox_px": [0, 0, 1, 1] }, "translation_m": object.at_m,
                    "rotation_xyzw": [0.0, 0.0, 0.0, 1.0], "yaw_rad": 0.0, "symmetry_order": 1,
                    "scale": [1.0, 1.0, 1.0], "size_m": object.size_m, "mass_kg": object.mass_kg,
                    "support": { "parent": object.support.0, "relation": object.support.1 },
                    "mesh": format!("glb/{}.glb", object.name),
                    "provenance": { "mesh_by": "embedded/catalog", "licence": "CC0-1.0", "notes": [] },
                }),
            )
        };
        json!({
            "format": "tabletopgen-scene/1", "id": self.id, "seed": 1,
            "request": { "version": 1, "input": self.input, "seed": 1, "options": {} },
            "frame": { "up": "+z", "handedness": "right", "origin": "table", "units": "m" },
            "camera": {
                "width_px": 10, "height_px": 10, "fx": 1.0, "fy": 1.0, "cx": 5.0, "cy": 5.0,
                "world_from_camera": pose,
            },
            "table": table,
            "instances": self.objects.iter().map(instance).collect::<Vec<_>>(),
            "metrics": { "col_o": 0.0, "col_s": 0.0, "ss": 1.0, "dss_aligned": 1.0, "dss_shipped": 1.0 },
        })
    }
}

fn media_type(path: &str) -> &'static str {
    if path.ends_with(".png") { "image/png" } else { "application/json" }
}

fn merged(base: &Value, over: Value) -> Value {
    let mut members = base.as_object().expect("an object").clone();
    members.extend(over.as_object().expect("an object").clone());
    Value::Object(members)
}

/// Bundles and datasets in a temporary folder.
pub struct Place {
    folder: TempDir,
}

impl Place {
    pub fn new() -> Self {
        Self { folder: TempDir::new().expect("a temporary folder") }
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// Twelve scenes of six texts, one of them edited from another, half of them as archives.
    pub fn with_scenes() -> Self {
        let place = Self::new();
        let bundles = place.path("bundles");
        for k in 0..12 {
            let id = format!("scene{k:02}");
            let spec = match k {
                11 => SceneSpec::edited(&id, "scene00"),
                _ => SceneSpec::of_text(&id, &format!("A mug, number {}", k % 6)),
            };
            if k % 2 == 0 {
                spec.write_folder(&bundles)
            } else {
                spec.write_archive(&bundles)
            };
        }
        place
    }

    /// A request for all bundles in `bundles`, written below `out`: shards of at most three scenes.
    pub fn request(&self, out: &str) -> FreezeRequest {
        FreezeRequest {
            name: "mugs".to_owned(),
            version: None,
            last_removed: 0,
            sources: vec![self.path("bundles")],
            batch_output: None,
            filter: Filter::default(),
            plan: "train=0.5,test=0.5".parse().expect("a plan"),
            leakage_rules: LeakageRules::ALL,
            layout: Layout::Shards { max_bytes: 1 << 20, max_scenes: Some(3) },
            out: self.path(out),
        }
    }

    /// Freeze request without splits, which few scenes cannot fill.
    pub fn undivided(&self, out: &str) -> FreezeRequest {
        FreezeRequest { plan: "none".parse().expect("a plan"), ..self.request(out) }
    }

    pub fn freeze(&self, out: &str) -> FrozenDataset {
        freeze(&self.request(out), &mut |_| {}).expect("a dataset")
    }
}

/// All files below a folder with their content.
pub fn content(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let paths = crate::files::list(folder).expect("a folder");
    paths.into_iter().map(|path| (path.clone(), fs::read(folder.join(path)).expect("a file"))).collect()
}
