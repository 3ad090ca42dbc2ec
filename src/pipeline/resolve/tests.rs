//! Concessions where there is no room, from the failure to poses that hold.

use glam::DVec2;
use serde::de::DeserializeOwned;

use super::*;
use certificate::RelaxationKind;
use geometry::decompose::decompose;
use geometry::shapes::{block, rectangle, shell_of_revolution};
use geometry::{Material, Rgb, Solid};
use runtime::CancelFlag;
use scene::Supporter;
use store::Digest;

/// A section of the built-in settings.
fn section<T: DeserializeOwned>(name: &str) -> T {
    let defaults: toml::Table = include_str!("../../../config/default.toml").parse().expect("our own file");
    defaults[name].clone().try_into().expect("our own section")
}

/// Bodies on a square table, the table first.
struct Planted {
    inputs: Inputs,
    solids: Vec<Solid>,
    supporters: Vec<Supporter>,
}

impl Planted {
    fn on(side_m: f64, outcome: OnNoSpace) -> Self {
        let mut planted = Self {
            inputs: Inputs {
                bodies: Vec::new(),
                supports: SupportTree::new(Vec::new()).expect("no objects"),
                outline_m: Outline::new(rectangle(side_m, side_m)).expect("a square"),
                resolve: section("resolve"),
                settle: section("settle"),
                certify: section("certify"),
                no_room: NoSpaceSettings { outcome, ..section("no_room") },
            },
            solids: Vec::new(),
            supporters: Vec::new(),
        };
        let top = block(DVec3::new(side_m, side_m, 0.03)).translated(DVec3::new(0.0, 0.0, -0.03));
        planted.add_body("table", top, DVec2::ZERO);
        planted
    }

    fn add(&mut self, name: &str, solid: Solid, at: DVec2, supporter: Supporter) {
        self.add_body(name, solid, at);
        self.supporters.push(supporter);
        self.inputs.supports = SupportTree::new(self.supporters.clone()).expect("a tree");
    }

    fn add_body(&mut self, name: &str, solid: Solid, at: DVec2) {
        let artifact = ArtifactRef {
            name: name.into(),
            digest: Digest::of(name.as_bytes()),
            media_type: "application/octet-stream".into(),
            size: 1,
        };
        self.inputs.bodies.push(Part {
            name: name.into(),
            category: "of wood".into(),
            material: None,
            mass_kg: None,
            mesh: artifact.clone(),
            hulls: artifact,
            aligned: Pose::upright(at.extend(0.0), 0.0),
        });
        self.solids.push(solid);
    }

    fn loaded(&self, scales: &[f64]) -> Vec<Loaded> {
        let of = |(solid, &scale): (&Solid, &f64)| {
            let mut mesh = TexturedMesh::default();
            let solid = solid.clone().scaled(DVec3::splat(scale));
            mesh.add(solid, &Material::plain("wood", Rgb::hex(0x806040), 0.5));
            let found = decompose(&mesh, &section("decompose"), &CancelFlag::default()).expect("a solid");
            Loaded {
                solid: Arc::new(MeshSolid::new(&mesh).expect("a solid")),
                hulls: found.hulls,
                mesh: Arc::new(mesh),
            }
        };
        self.solids.iter().zip(scales).map(of).collect()
    }

    /// As the stage does it; the code of the failure where nothing more may be conceded.
    fn resolve(&self) -> Result<Output, &'static str> {
        let mut attempt = Attempt::new(self.inputs.bodies.clone(), self.inputs.supports.clone());
        for _ in 0..MAX_TRIES {
            let loaded = self.loaded(&attempt.scales);
            let supports = attempt.supports.clone();
            let failed = match solve(&self.inputs, &attempt.parts, supports, &loaded, &CancelFlag::default())
            {
                Ok(solved) => return Ok(solved.conceded(&attempt)),
                Err(failed) => failed,
            };
            let hulls: Vec<&[ConvexHull]> = loaded.iter().map(|geometry| &geometry.hulls[..]).collect();
            let stuck = failed.stuck.expect("nobody interrupts");
            if !attempt.give_way(&stuck, &self.inputs.no_room, &hulls, &self.inputs.outline_m) {
                return Err(failed.error.code);
            }
        }
        Err("no_end")
    }
}

/// Four cubes of 10 cm on a table of 20 cm, which would fit without the margin.
fn crowded(outcome: OnNoSpace) -> Planted {
    let mut planted = Planted::on(0.2, outcome);
    for (k, corner) in [(-0.05, -0.05), (0.05, -0.05), (0.05, 0.05), (-0.05, 0.05)].into_iter().enumerate() {
        planted.add(&format!("cube_{k}"), block(DVec3::splat(0.1)), corner.into(), Supporter::TABLE);
    }
    planted
}

#[test]
fn full_table_fails_the_job_unless_objects_may_shrink() {
    assert_eq!(crowded(OnNoSpace::Fail).resolve().err(), Some("no_room"));
    // All stand on the table already.
    assert_eq!(crowded(OnNoSpace::Move).resolve().err(), Some("no_room"));
    let shrunk = crowded(OnNoSpace::Shrink).resolve().expect("smaller ones fit");
    assert_eq!(shrunk.gave_way.len(), 4);
    for body in &shrunk.bodies[1..] {
        assert!((body.scale - 0.9).abs() < 1e-12 && body.displacement_m < 0.01, "{}", body.name);
        assert!(body.settled.translation_m.truncate().abs().max_element() < 0.1 - 0.045);
    }
    assert_eq!((shrunk.bodies[0].scale, shrunk.supports.len()), (1.0, 4));
}

#[test]
fn what_does_not_go_into_its_cup_stands_beside_it_if_it_may() {
    let with = |outcome| {
        let mut planted = Planted::on(0.6, outcome);
        let profile = [DVec2::new(0.03, 0.0), DVec2::new(0.03, 0.06)];
        planted.add("cup", shell_of_revolution(&profile, 0.004, 0.006, 32), DVec2::ZERO, Supporter::TABLE);
        planted.add("cube", block(DVec3::splat(0.1)), DVec2::new(0.01, 0.0), Supporter::containing(0));
        planted.resolve()
    };
    assert_eq!(with(OnNoSpace::Fail).err(), Some("unresolved"));
    let moved = with(OnNoSpace::Move).expect("there is room beside it");
    assert_eq!(
        moved.gave_way,
        [Relaxation { name: "cube".into(), how: RelaxationKind::Moved { from: "cup".into() } }]
    );
    assert_eq!((moved.supports.supporter(1), moved.bodies[2].scale), (Supporter::TABLE, 1.0));
    assert!(moved.bodies[2].settled.translation_m.z.abs() < 1e-3 && moved.bodies[1].displacement_m < 1e-3);
}
