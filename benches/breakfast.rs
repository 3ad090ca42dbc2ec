//! The scene every bench works on: a breakfast of thirteen objects, as the embedded image generator renders it.
//!
//! Shipped settings, one seed, no files: what a bench measures is what a job does.

// Each bench takes what it needs.
#![allow(dead_code)]

use std::sync::Arc;

use catalog::{Recipe, physical_properties};
use embedded::image_generator::EmbeddedImageGenerator;
use embedded::single_view_reconstruction::SingleViewSettings;
use embedded::text_parser;
use embedded::text_parser::DescribeOptions;
use geometry::decompose::decompose;
use geometry::solid_query::MeshSolid;
use geometry::{Outline, Pose, TexturedMesh};
use physics::Body;
use ports::{Call, GeneratedReference, ImageGenerator, SyntheticGroundTruth};
use runtime::CancelFlag;
use runtime::CpuPool;
use scene::{RecognizedObject, SceneDescription, SupportTree};
use tabletopgen::config;
use tabletopgen::config::{Config, Sources};

pub const TEXT: &str = "A breakfast table with a bowl of three apples, a plate with a croissant on it, a glass of \
                        water, a milk carton, a cereal box, a mug with a spoon in it and two eggs";
pub const SEED: u64 = 22;

/// The settings the program ships with.
pub fn config() -> Config {
    config::layers::load(Sources::default()).expect("the shipped defaults are valid").config
}

pub fn describe(config: &Config) -> SceneDescription {
    let options = DescribeOptions { max_objects: 64, table: None, on_unknown: Default::default() };
    text_parser::describe(TEXT, SEED, &options, &config.analyst).expect("every word is known")
}

pub fn image_generator(config: &Config) -> EmbeddedImageGenerator {
    EmbeddedImageGenerator {
        photograph: SingleViewSettings {
            sizes: config.photograph.clone(),
            naming: config.category_fit.clone(),
        },
        layout: config.layout.clone(),
        image_generator: config.image_generator.clone(),
        render: config.render.clone(),
        decompose: config.decompose.clone(),
        settle: config.settle.clone(),
        resolve: config.resolve.clone(),
        certify: config.certify.clone(),
    }
}

/// One core, so that figures compare between machines.
pub fn call() -> Call {
    Call::without_budget(CpuPool::new(1).expect("a pool of one thread"), CancelFlag::default())
}

pub fn render(
    image_generator: &EmbeddedImageGenerator,
    call: &Call,
    description: &Arc<SceneDescription>,
) -> GeneratedReference {
    let generated = image_generator.reference(call, description.clone(), SEED);
    futures::executor::block_on(generated).expect("the breakfast can be painted")
}

/// The rendered scene with meshes and poses.
pub struct Breakfast {
    pub config: Config,
    pub generated: GeneratedReference,
    pub table: TexturedMesh,
    pub outline: Outline,
    /// In the order of [`Self::objects`].
    pub meshes: Vec<TexturedMesh>,
    pub poses: Vec<Pose>,
}

impl Breakfast {
    pub fn new() -> Self {
        let config = config();
        let generated = render(&image_generator(&config), &call(), &Arc::new(describe(&config)));
        let ground_truth = generated.ground_truth.as_ref().expect("our painter knows what it painted");
        let seen = &ground_truth.known.recognition.table;
        let table =
            catalog::build_table(&seen.model, seen.size_m, seen.color, seen.material.as_deref(), seen.seed)
                .expect("a table of the catalog");
        let meshes = ground_truth.known.recognition.objects.iter().map(mesh).collect();
        let truth = &ground_truth.truth.instances;
        let poses = truth
            .iter()
            .map(|i| Pose { translation_m: i.translation_m, rotation: i.rotation_xyzw })
            .collect();
        Self { table: table.mesh, outline: table.outline_m, meshes, poses, config, generated }
    }

    pub fn ground_truth(&self) -> &SyntheticGroundTruth {
        self.generated.ground_truth.as_ref().expect("our painter knows what it painted")
    }

    pub fn objects(&self) -> &[RecognizedObject] {
        &self.ground_truth().known.recognition.objects
    }

    /// The table first, then the objects, where they stand; and their solids.
    pub fn bodies(&self) -> (Vec<Body>, Vec<MeshSolid>) {
        let table = std::iter::once(("table", "table", None, &self.table, Pose::IDENTITY));
        let objects = self.objects().iter().zip(&self.meshes).zip(&self.poses).map(|((o, mesh), pose)| {
            (o.id.as_str(), o.category.as_str(), o.material.as_deref(), mesh, *pose)
        });
        let made = table.chain(objects).map(|(name, category, material, mesh, world_from_object)| {
            let hulls =
                decompose(mesh, &self.config.decompose, &CancelFlag::default()).expect("catalog meshes do");
            let physical = physical_properties(mesh, category, material).expect("catalog meshes are closed");
            let body = Body {
                name: name.to_owned(),
                hulls: hulls.hulls,
                world_from_object,
                mass: physical.mass,
                friction: physical.friction,
                restitution: physical.restitution,
                rolling_friction_m: physical.rolling_friction_m,
                fixed: name == "table",
            };
            (body, MeshSolid::new(mesh).expect("catalog meshes are closed"))
        });
        made.unzip()
    }

    /// Supports of [`Self::objects`].
    pub fn supports(&self) -> SupportTree {
        self.ground_truth().known.recognition.support_tree().expect("a rendered scene is valid")
    }
}

fn mesh(object: &RecognizedObject) -> TexturedMesh {
    let recipe = Recipe {
        category: object.category.clone(),
        size_m: object.size_m,
        color: object.color,
        material: object.material.clone(),
        seed: object.seed,
    };
    catalog::build(&recipe).expect("a kind of the catalog")
}
