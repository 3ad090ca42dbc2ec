//! From a draft to a scene: poses, supports, and the movements that no operation asked for.

use std::collections::BTreeSet;
use std::sync::Arc;

use super::Draft;
use crate::pipeline::composition::Composition;
use crate::pipeline::resolve::Loaded;
use physics::settle::angle_between_rad;
use scene::edit::MovedObject;
use scene::recognition::StandsOn;
use scene::{InstanceId, SupportRelation, SupportTree, Supporter};

impl Draft<'_> {
    /// The finished scene: poses and supports of the workspace, and every movement that no operation asked for.
    pub fn finish(mut self) -> (Composition, Vec<Loaded>, BTreeSet<String>, Vec<MovedObject>) {
        let supporters: Vec<Supporter> = (0..self.len()).map(|object| self.supporter(object)).collect();
        self.composition.supports = SupportTree::without_contradictions(&supporters);
        self.forget_named_clutter();
        let mut moved = Vec::new();
        let recognition = Arc::make_mut(&mut self.composition.recognition);
        let ids: Vec<InstanceId> = recognition.objects.iter().map(|object| object.id.clone()).collect();
        for (index, object) in self.workspace.objects.iter().enumerate() {
            let pose = object.body.world_from_object;
            let resolved = &mut self.composition.bodies[index + 1].resolved;
            (resolved.aligned, resolved.planned, resolved.settled) = (pose, pose, pose);
            (resolved.displacement_m, resolved.rotation_rad) = (0.0, 0.0);
            if let Some(yaw_rad) = pose.yaw_rad() {
                self.composition.yaws[index].yaw_rad = yaw_rad;
            }
            recognition.objects[index].stands_on = match (object.supporter.parent, object.supporter.relation)
            {
                (None, _) => StandsOn::Table,
                (Some(parent), SupportRelation::On) => StandsOn::On(ids[parent].clone()),
                (Some(parent), SupportRelation::In) => StandsOn::In(ids[parent].clone()),
            };
            let Some(before) = self.parent_poses.get(&object.body.name) else { continue };
            if *before != pose && !self.named.contains(&object.body.name) {
                moved.push(MovedObject {
                    name: ids[index].clone(),
                    distance_m: (pose.translation_m - before.translation_m).length(),
                    angle_rad: angle_between_rad(before, &pose),
                    cause: self
                        .causes
                        .get(&object.body.name)
                        .cloned()
                        .unwrap_or_else(|| "it moves with what it rests on".to_owned()),
                });
            }
        }
        (self.composition, self.loaded, self.changed, moved)
    }

    /// Objects that operations name no longer are where they fell.
    fn forget_named_clutter(&mut self) {
        let Some(heap) = &mut self.composition.clutter else { return };
        let (named, workspace) = (&self.named, &self.workspace);
        heap.retain(|name| {
            !named.contains(name) && workspace.objects.iter().any(|object| object.body.name == name)
        });
        if heap.dropped.is_empty() {
            self.composition.clutter = None;
        }
    }
}
