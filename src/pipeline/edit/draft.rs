//! The scene while operations are carried out on it.

mod finish;
mod rest;

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use glam::DVec2;

use super::additions::NewObject;
use super::error::EditError;
use super::recolor;
use crate::pipeline::composition::{BodyParts, Composition};
use crate::pipeline::resolve::{Loaded, ResolvedBody, body};
use catalog::physical_properties;
use editing::workspace::{Workspace, WorkspaceObject};
use editing::{EditableObject, RestSettings};
use geometry::Pose;
use geometry::solid_query::MeshSolid;
use runtime::CancelFlag;
use scene::{InstanceId, Provenance, ReconstructionMethod, SupportRelation, Supporter};

/// Bodies, their geometry, and the same as a workspace; lists of objects have the same order, and bodies have the
/// table first.
#[derive(Clone)]
pub(super) struct Draft<'a> {
    pub composition: Composition,
    pub loaded: Vec<Loaded>,
    pub workspace: Workspace,
    pub rest: RestSettings<'a>,
    pub cancel: CancelFlag,
    /// Of the parent, by name.
    parent_poses: BTreeMap<String, Pose>,
    /// Content of each container of the parent, by name.
    parent_contents: BTreeMap<String, BTreeSet<String>>,
    /// Objects that operations name, which may move.
    named: BTreeSet<String>,
    /// Reasons why other objects moved, by name.
    causes: BTreeMap<String, String>,
    /// Bodies whose mesh or hulls are new.
    changed: BTreeSet<String>,
    /// Names of the objects that operations added, in order.
    added: Vec<String>,
    /// The objects of the operation before.
    last_result: Vec<InstanceId>,
}

impl<'a> Draft<'a> {
    /// The parent as a draft.
    ///
    /// # Errors
    ///
    /// [`EditError::Hulls`] for a body whose hulls cannot be used.
    pub fn new(
        composition: Composition,
        loaded: Vec<Loaded>,
        rest: RestSettings<'a>,
        cancel: CancelFlag,
    ) -> Result<Self, EditError> {
        let mut objects = Vec::with_capacity(loaded.len());
        for (index, (geometry, parts)) in loaded.iter().zip(&composition.bodies).enumerate() {
            let supporter = index
                .checked_sub(1)
                .map_or(Supporter::TABLE, |object| composition.supports.supporter(object));
            let mut object = workspace_object(geometry, &parts.resolved, supporter, index == 0)?;
            if let Some(yaw) = index.checked_sub(1).and_then(|object| composition.yaws.get(object)) {
                object.symmetry_order = yaw.symmetry_order;
            }
            objects.push(object);
        }
        let table = objects.remove(0);
        let parent_poses = composition
            .bodies
            .iter()
            .map(|parts| (parts.resolved.name.clone(), parts.resolved.settled))
            .collect();
        let mut parent_contents: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
        for object in &objects {
            if let (Some(parent), SupportRelation::In) = (object.supporter.parent, object.supporter.relation)
            {
                let contents = parent_contents.entry(objects[parent].body.name.clone()).or_default();
                contents.insert(object.body.name.clone());
            }
        }
        Ok(Self {
            workspace: Workspace { outline: composition.outline().clone(), table, objects },
            composition,
            loaded,
            rest,
            cancel,
            parent_poses,
            parent_contents,
            named: BTreeSet::new(),
            causes: BTreeMap::new(),
            changed: BTreeSet::new(),
            added: Vec::new(),
            last_result: Vec::new(),
        })
    }

    pub fn len(&self) -> usize {
        self.workspace.objects.len()
    }

    pub fn name(&self, object: usize) -> &str {
        &self.workspace.objects[object].body.name
    }

    pub fn id(&self, object: usize) -> InstanceId {
        self.composition.recognition.objects[object].id.clone()
    }

    pub fn parts(&mut self, object: usize) -> &mut BodyParts {
        &mut self.composition.bodies[object + 1]
    }

    pub fn pose(&self, object: usize) -> Pose {
        self.workspace.objects[object].body.world_from_object
    }

    pub fn supporter(&self, object: usize) -> Supporter {
        self.workspace.objects[object].supporter
    }

    /// Center of the footprint.
    pub fn center_m(&self, object: usize) -> DVec2 {
        self.workspace.objects[object].footprint().center()
    }

    /// Indices of the objects that operations added, the latest last.
    pub fn newest(&self) -> Vec<usize> {
        let position = |name: &String| (0..self.len()).find(|object| self.name(*object) == name);
        self.added.iter().filter_map(position).collect()
    }

    /// The objects of the operation before that still exist.
    pub fn last_result(&self) -> Vec<usize> {
        let position = |id: &InstanceId| (0..self.len()).find(|object| self.id(*object) == *id);
        self.last_result.iter().filter_map(position).collect()
    }

    /// Notes the objects of an operation, for "it" in the next one.
    pub fn note_result(&mut self, objects: &[InstanceId]) {
        self.last_result = objects.to_vec();
    }

    /// Objects that rest directly on or in another one.
    pub fn load(&self, object: usize) -> Vec<usize> {
        (0..self.len()).filter(|other| self.supporter(*other).parent == Some(object)).collect()
    }

    /// Notes that an operation names an object.
    pub fn is_named(&mut self, object: usize) {
        let name = self.name(object).to_owned();
        self.named.insert(name);
    }

    /// Notes why objects that no operation names may move.
    pub fn may_move(&mut self, objects: &[usize], cause: &str) {
        for &object in objects {
            let name = self.name(object).to_owned();
            self.causes.entry(name).or_insert_with(|| cause.to_owned());
        }
    }

    /// The objects as phrases find them.
    pub fn editable(&self) -> Vec<EditableObject> {
        let recognized = &self.composition.recognition.objects;
        recognized
            .iter()
            .zip(&self.workspace.objects)
            .zip(&self.loaded[1..])
            .map(|((recognized, object), geometry)| EditableObject {
                name: recognized.id.clone(),
                label: recognized.label.clone(),
                category: recognized.category.clone(),
                stand_in: recognized.stand_in.is_some(),
                color: recolor::main_color(&geometry.mesh),
                material: recognized.material.clone(),
                size_m: geometry.mesh.size_m(),
                footprint: object.footprint(),
                supporter: object.supporter,
            })
            .collect()
    }

    /// Adds an object that has no place yet; its index.
    ///
    /// # Errors
    ///
    /// [`EditError`] for a mesh without mass, and for hulls that cannot be used.
    pub fn add(&mut self, new: &NewObject, loaded: Loaded) -> Result<usize, EditError> {
        let id = self.free_name(&new.recognized.id);
        let (category, material) = (&new.recognized.category, new.recognized.material.as_deref());
        let mut physical = physical_properties(&loaded.mesh, category, material)?;
        if let Some(mass_kg) = new.recognized.mass_kg {
            physical.mass = physical.mass.with_mass(mass_kg);
        }
        let resolved = ResolvedBody {
            name: id.to_string(),
            mesh: new.canonical.mesh.clone(),
            hulls: new.hulls.hulls.clone(),
            scale: 1.0,
            aligned: Pose::IDENTITY,
            planned: Pose::IDENTITY,
            settled: Pose::IDENTITY,
            displacement_m: 0.0,
            rotation_rad: 0.0,
            physical,
        };
        let mut object = workspace_object(&loaded, &resolved, Supporter::TABLE, false)?;
        (object.is_placed, object.symmetry_order) = (false, new.yaw.symmetry_order);
        self.workspace.objects.push(object);
        self.loaded.push(loaded);
        self.composition.bodies.push(BodyParts {
            mesh: resolved.mesh.clone(),
            hulls: resolved.hulls.clone(),
            resolved,
            thumbnail: Some(new.canonical.image.clone()),
            hull_excess_m: new.hulls.max_excess_m,
            hull_fit: new.hulls.fit,
            repair: new.hulls.repair,
            scale: 1.0,
            symmetry_order: new.yaw.symmetry_order,
            provenance: Provenance {
                mesh_by: new.raw.made_by.clone(),
                licence: new.raw.licence.clone(),
                notes: new.raw.notes.clone(),
            },
            grasp: None,
        });
        self.composition.yaws.push(new.yaw.clone());
        self.composition.methods.push(new.raw.method.unwrap_or(ReconstructionMethod::Generated));
        let mut recognized = new.recognized.clone();
        recognized.id = id;
        // An edit places upright objects; the pose of a tipped one is that of its mesh.
        recognized.tipped = None;
        Arc::make_mut(&mut self.composition.recognition).objects.push(recognized);
        let object = self.len() - 1;
        self.is_named(object);
        self.added.push(self.name(object).to_owned());
        Ok(object)
    }

    /// The name with the next number that no object of this scene or of its parent has.
    fn free_name(&self, made: &InstanceId) -> InstanceId {
        let stem = made.as_str().trim_end_matches(|c: char| c.is_ascii_digit()).trim_end_matches('_');
        let taken = |name: &str| {
            self.parent_poses.contains_key(name)
                || self.workspace.objects.iter().any(|object| object.body.name == name)
        };
        (1..)
            .map(|number| InstanceId::numbered(stem, number))
            .find(|name| !taken(name.as_str()))
            .unwrap_or_else(|| made.clone())
    }

    /// Gives an object the name and the label of one that is removed.
    pub fn rename(&mut self, object: usize, id: &InstanceId, label: String) {
        let old = self.name(object).to_owned();
        let new = id.to_string();
        self.parts(object).resolved.name.clone_from(&new);
        self.workspace.objects[object].body.name.clone_from(&new);
        let recognized = &mut Arc::make_mut(&mut self.composition.recognition).objects[object];
        (recognized.id, recognized.label) = (id.clone(), label);
        self.added.iter_mut().filter(|name| **name == old).for_each(|name| name.clone_from(&new));
        self.named.insert(new);
    }

    /// Takes over what was changed of the physical properties of an object.
    ///
    /// # Errors
    ///
    /// [`EditError::Hulls`] for hulls that cannot be used.
    pub fn refresh(&mut self, object: usize) -> Result<(), EditError> {
        let mut resolved = self.composition.bodies[object + 1].resolved.clone();
        resolved.settled = self.pose(object);
        self.rebuild(object, &resolved)
    }

    /// Removes an object; the indices of what rested on or in it, as they are afterward.
    pub fn remove(&mut self, object: usize) -> Vec<usize> {
        let loose = self.workspace.remove(object);
        self.loaded.remove(object + 1);
        self.composition.bodies.remove(object + 1);
        self.composition.yaws.remove(object);
        self.composition.methods.remove(object);
        Arc::make_mut(&mut self.composition.recognition).objects.remove(object);
        loose
    }

    /// Gives an object other geometry; its physical properties follow.
    ///
    /// # Errors
    ///
    /// [`EditError`] for a mesh without mass, and for hulls that cannot be used.
    pub fn reshape(&mut self, object: usize, loaded: Loaded, factor: f64) -> Result<(), EditError> {
        let recognized = &self.composition.recognition.objects[object];
        let (category, material) = (recognized.category.clone(), recognized.material.clone());
        let before = self.composition.bodies[object + 1].resolved.physical.mass.mass_kg;
        let mut physical = physical_properties(&loaded.mesh, &category, material.as_deref())?;
        // What a text states, or what is in it, scales with the volume.
        physical.mass = physical.mass.with_mass(before * factor.powi(3));
        self.replace_geometry(object, loaded, physical)
    }

    /// Gives an object another mesh of the same shape.
    pub fn repaint(
        &mut self,
        object: usize,
        loaded: Loaded,
        material: Option<&str>,
    ) -> Result<(), EditError> {
        let category = self.composition.recognition.objects[object].category.clone();
        let physical = match material {
            None => self.composition.bodies[object + 1].resolved.physical,
            Some(material) => physical_properties(&loaded.mesh, &category, Some(material))?,
        };
        self.replace_geometry(object, loaded, physical)
    }

    fn replace_geometry(
        &mut self,
        object: usize,
        loaded: Loaded,
        physical: catalog::PhysicalProperties,
    ) -> Result<(), EditError> {
        let pose = self.pose(object);
        let name = self.name(object).to_owned();
        let parts = self.parts(object);
        parts.resolved.physical = physical;
        parts.resolved.settled = pose;
        parts.thumbnail = None;
        let resolved = parts.resolved.clone();
        self.loaded[object + 1] = loaded;
        self.changed.insert(name);
        self.rebuild(object, &resolved)
    }

    /// Makes the object of the workspace again, of its geometry and its properties of now.
    fn rebuild(&mut self, object: usize, resolved: &ResolvedBody) -> Result<(), EditError> {
        let WorkspaceObject { supporter, symmetry_order, .. } = self.workspace.objects[object];
        let mut rebuilt = workspace_object(&self.loaded[object + 1], resolved, supporter, false)?;
        rebuilt.symmetry_order = symmetry_order;
        self.workspace.objects[object] = rebuilt;
        Ok(())
    }

    /// Gives the table another mesh.
    pub fn replace_table(&mut self, loaded: Loaded, material: Option<&str>) -> Result<(), EditError> {
        let physical = physical_properties(&loaded.mesh, "table", material)?;
        let parts = &mut self.composition.bodies[0];
        parts.resolved.physical = physical;
        let name = parts.resolved.name.clone();
        self.workspace.table = workspace_object(&loaded, &parts.resolved, Supporter::TABLE, true)?;
        self.loaded[0] = loaded;
        self.changed.insert(name);
        Ok(())
    }
}

fn workspace_object(
    geometry: &Loaded,
    resolved: &ResolvedBody,
    supporter: Supporter,
    fixed: bool,
) -> Result<WorkspaceObject, EditError> {
    let body = body(&resolved.name, geometry, resolved.settled, &resolved.physical, fixed);
    WorkspaceObject::new(body, geometry.solid.clone(), supporter, true)
        .map_err(|source| EditError::Hulls { body: resolved.name.clone(), source })
}

/// Mesh, solid and hulls of other geometry.
///
/// # Errors
///
/// [`EditError::Solid`] for a mesh that bounds no solid.
pub(super) fn load(
    mesh: geometry::TexturedMesh,
    hulls: Vec<geometry::ConvexHull>,
) -> Result<Loaded, EditError> {
    let mesh = mesh.snap_to_f32();
    let solid = MeshSolid::new(&mesh)?;
    Ok(Loaded { mesh: Arc::new(mesh), solid: Arc::new(solid), hulls })
}
