//! The support tree that the relations of the objects state.

use super::LayoutObject;
use scene::{RelationKind, SupportRelation, SupportTree, Supporter};

/// The supports of the objects: each by its first support relation to another object, on the table without one.
/// Relations that would close a cycle are ignored.
pub fn support_tree(objects: &[LayoutObject]) -> SupportTree {
    let stated = |object: &LayoutObject| {
        let support = object.relations.iter().find_map(|&(kind, target)| {
            let parent = target.filter(|&parent| kind.is_support() && parent < objects.len())?;
            let relation = match kind {
                RelationKind::In => SupportRelation::In,
                _ => SupportRelation::On,
            };
            Some(Supporter { parent: Some(parent), relation })
        });
        support.unwrap_or(Supporter::TABLE)
    };
    let stated: Vec<Supporter> = objects.iter().map(stated).collect();
    SupportTree::without_contradictions(&stated)
}

#[cfg(test)]
mod tests {
    use super::*;
    use RelationKind::{In, LeftOf, On, StackedOn};
    use catalog::category;
    use geometry::TexturedMesh;

    #[test]
    fn first_support_relation_counts_unless_it_closes_a_cycle() {
        let mesh = TexturedMesh::default();
        let object = |relations: &[(RelationKind, Option<usize>)]| LayoutObject {
            name: "mug".into(),
            category: category("mug").expect("a category of the catalog"),
            mesh: &mesh,
            relations: relations.to_vec(),
        };
        let objects = [
            object(&[(LeftOf, Some(2)), (On, None), (In, Some(1)), (On, Some(2))]),
            // Closes the cycle with the first.
            object(&[(StackedOn, Some(0))]),
            object(&[(LeftOf, Some(0))]),
            object(&[(StackedOn, Some(2)), (In, Some(1))]),
            // No such object.
            object(&[(On, Some(5)), (In, Some(3))]),
        ];
        let table = Supporter::TABLE;
        let expected = [Supporter::containing(1), table, table, Supporter::on(2), Supporter::containing(3)];
        assert_eq!(support_tree(&objects).supporters(), expected);
    }
}
