//! A finished scene as the stages know it: what the certificate is made from, and what an edit starts from.
//!
//! The bundle holds it as `composition.json` with the convex hulls; meshes are the bundle's own `glb/<name>.glb`. So a
//! scene can be edited wherever its bundle is.

use std::sync::Arc;

use glam::DVec3;
use serde::{Deserialize, Serialize};

use super::checkpoint::ArtifactRef;
use super::clutter::Heap;
use super::resolve::ResolvedBody;
use super::{place, rotate};
use catalog::category;
use catalog::stand_in::is_stand_in;
use certificate::ResolveFinding;
use export::BundleFile;
use export::ExportError;
use geometry::decompose::HullFit;
use geometry::repair::Repair;
use geometry::{ConvexHull, Outline};
use imaging::Mask;
use scene::edit::EditAccount;
use scene::text_account::TextAccount;
use scene::{
    InstanceMask, Light, Provenance, Recognition, ReconstructionMethod, StandIn, SupportTree, Supporter,
};
use store::Digest;

/// Path of the stored composition in a bundle.
pub const PATH: &str = "composition.json";

/// Everything that is known of a scene, but its name and the settings it is measured with.
#[derive(Clone, Serialize, Deserialize)]
pub struct Composition {
    /// The reference image.
    pub image: ArtifactRef,
    pub recognition: Arc<Recognition>,
    pub masks: Vec<InstanceMask>,
    /// Pixels of the image that show something on the table which is none of the objects, where it was searched for.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub unread: Option<Mask>,
    /// The table first.
    pub bodies: Vec<BodyParts>,
    /// Of the bodies after the table.
    pub supports: SupportTree,
    pub table: place::PlacedTable,
    /// Of the objects, in order.
    pub yaws: Vec<rotate::Output>,
    /// Reconstruction method of each object's mesh.
    pub methods: Vec<ReconstructionMethod>,
    /// The table from above as the layout saw it; drawn on the sheet of an image.
    pub top_view: ArtifactRef,
    /// Standard error of the scene's scale, as a share of it, where the objects voted on it.
    pub scale_error: Option<f64>,
    pub resolve: ResolveFinding,
    pub account: Option<TextAccount>,
    /// Light of the scene, if it is not the studio's.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub light: Option<Light>,
    /// Result of the edit; `None` for a scene that was made from a text or an image.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub edit: Option<EditAccount>,
    /// Dropped objects; `None` where none was.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub clutter: Option<Heap>,
}

/// One body with everything the stages found out about it.
#[derive(Clone, Serialize, Deserialize)]
pub struct BodyParts {
    pub resolved: ResolvedBody,
    pub mesh: ArtifactRef,
    /// The mesh alone, drawn before it was rescaled, which no image of it shows; without one it is drawn anew.
    pub thumbnail: Option<ArtifactRef>,
    pub hulls: ArtifactRef,
    /// Largest distance by which a hull sticks out of the mesh, meters.
    pub hull_excess_m: f64,
    pub hull_fit: HullFit,
    pub repair: Repair,
    pub scale: f64,
    pub symmetry_order: u32,
    pub provenance: Provenance,
    /// Grasp of the body, once certified: an edit takes it from the parent for bodies that it does not change.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub grasp: Option<FoundGrasp>,
}

/// The result of a search for a grasp.
#[derive(Clone, PartialEq, Serialize, Deserialize)]
pub struct FoundGrasp {
    /// Of everything that decides the result.
    pub key: Digest,
    /// Contacts of the two fingers, object frame, meters; `None` where no gripper has room.
    pub contacts_m: Option<[DVec3; 2]>,
}

impl Composition {
    /// Edge of the table's top.
    pub fn outline(&self) -> &Outline {
        &self.table.outline_m
    }

    /// Returns the composition with the marks of stand-ins that its meshes bear out, and the account's list of them. A
    /// mesh that was made from an image is what was asked for.
    pub fn with_stand_ins(mut self) -> Self {
        let recognition = Arc::make_mut(&mut self.recognition);
        for (object, method) in recognition.objects.iter_mut().zip(&self.methods) {
            if *method != ReconstructionMethod::Category {
                object.stand_in = None;
            }
        }
        if let Some(account) = &mut self.account {
            let marked = recognition.objects.iter().filter(|object| object.stand_in.is_some());
            account.stand_ins = marked.map(|object| object.id.clone()).collect();
        }
        self
    }

    /// Marks the stand-ins of a scene of an earlier version, which only lists them.
    fn mark_listed_stand_ins(&mut self) {
        let listed = self.account.as_ref().map_or(&[][..], |account| &account.stand_ins);
        for object in &mut Arc::make_mut(&mut self.recognition).objects {
            let is_listed = listed.contains(&object.id) || is_stand_in(&object.category);
            if object.stand_in.is_none() && is_listed {
                let shown_as = category(&object.category).map(|category| category.label.clone());
                let shown_as = shown_as.unwrap_or_else(|| object.category.clone());
                object.stand_in = Some(StandIn { stands_for: object.label.clone(), shown_as });
            }
        }
    }

    /// The name of the supporting body.
    pub fn name_of(&self, supporter: Supporter) -> &str {
        let body = supporter.parent.map_or(0, |parent| parent + 1);
        &self.bodies[body].resolved.name
    }
}

/// Reason why a stored composition is not read.
#[derive(Debug, thiserror::Error)]
pub enum CompositionError {
    #[error(transparent)]
    Json(#[from] serde_json::Error),
    #[error("its composition has the format {found}, and this program reads {}", StoredComposition::FORMAT)]
    OtherFormat { found: String },
    #[error("its lists of objects have different lengths")]
    UnequalLists,
}

/// `composition.json`.
#[derive(Serialize, Deserialize)]
pub struct StoredComposition {
    /// [`StoredComposition::FORMAT`].
    pub format: String,
    pub composition: Composition,
    /// Of each body, in its frame, meters.
    pub hulls: Vec<Vec<ConvexHull>>,
}

impl StoredComposition {
    /// Raised when a stored composition is read otherwise.
    pub const FORMAT: &str = "tabletopgen-composition/1";

    /// Reads the file of a bundle.
    ///
    /// # Errors
    ///
    /// [`CompositionError`] for a file that is no composition, or one of another version.
    pub fn read(bytes: &[u8]) -> Result<Self, CompositionError> {
        let mut stored: Self = serde_json::from_slice(bytes)?;
        stored.composition.mark_listed_stand_ins();
        if stored.format != Self::FORMAT {
            return Err(CompositionError::OtherFormat { found: stored.format });
        }
        let Composition { bodies, recognition, yaws, methods, supports, .. } = &stored.composition;
        let objects = recognition.objects.len();
        let is_whole = bodies.len() == objects + 1
            && [yaws.len(), methods.len(), supports.len()].iter().all(|n| *n == objects)
            && stored.hulls.len() == bodies.len();
        if is_whole { Ok(stored) } else { Err(CompositionError::UnequalLists) }
    }

    /// The file of a bundle. `composition` has its bodies in the frames of the bundle, where no object is tipped.
    ///
    /// # Errors
    ///
    /// [`ExportError::Json`] for a number that JSON does not have.
    pub fn file(composition: &Composition, hulls: Vec<Vec<ConvexHull>>) -> Result<BundleFile, ExportError> {
        let mut composition = composition.clone();
        let mut recognition = (*composition.recognition).clone();
        recognition.objects.iter_mut().for_each(|object| object.tipped = None);
        composition.recognition = Arc::new(recognition);
        let stored = Self { format: Self::FORMAT.to_owned(), composition, hulls };
        Ok(BundleFile::new(PATH, serde_json::to_vec(&stored)?, "composition", "application/json"))
    }
}
