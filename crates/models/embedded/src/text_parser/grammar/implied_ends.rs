//! Ends of instructions that no predicate of the verb names: "load the rack with plates", verbs without a predicate
//! whose path says where the object goes, and what is put on the table.

use super::action::{Action, Part, Path, PathKind};
use super::goals::{GoalDraft, GoalKind};
use super::{LinkKind, Parser};
use crate::text_parser::verbs::Frame;
use scene::text_account::PredicateKind;

/// Verbs that leave their object where it is, or whose effect is none of place.
const STILL: &[&str] = &[
    "touch", "reach", "point", "find", "identify", "count", "inspect", "look", "approach", "select",
    "choose", "avoid", "watch", "detect", "locate", "guard", "protect", "do", "go", "wave", "prepare",
    "light", "tilt", "see", "check", "observe", "examine", "describe", "name", "break", "tear", "crush",
    "smash", "bend", "cook", "heat", "feed",
];

impl Parser<'_, '_> {
    /// "load the rack with ...": the object is the target.
    pub(super) fn loads(&self, action: &Action) -> bool {
        action.frame == Frame::Place
            && action.paths.is_empty()
            && matches!(
                self.word_at(action.verb.start),
                Some("load" | "loads" | "loading" | "pack" | "stuff" | "stock" | "align" | "pair")
            )
    }

    /// "load the rack with the plates": the plates go into the rack. "align the ruler with the book": beside it.
    pub(super) fn load_hosts(&self, action: &mut Action) {
        if action.tools.is_empty() || !self.loads(action) || action.objects.is_empty() {
            return;
        }
        let tokens = action.verb.clone();
        if matches!(self.word_at(action.verb.start), Some("align" | "pair")) {
            let path = self.path(PathKind::Relation(scene::RelationKind::NextTo), tokens);
            action.paths.push(Path { targets: std::mem::take(&mut action.tools), directed: true, ..path });
            return;
        }
        let targets = Self::mentions(&action.objects);
        let tools = std::mem::take(&mut action.tools);
        action.objects = tools.into_iter().map(|mention| Part { mention, take: None }).collect();
        action.paths.push(Path { targets, directed: true, ..self.path(PathKind::At, tokens) });
    }

    /// The goal of a verb without a predicate: its path or its source says where the object is at the end. Without one
    /// the object has moved, and the verb is reported. Whether the verb is reported.
    pub(super) fn other_goal(&mut self, action: &mut Action) -> bool {
        let verb = self.word_at(action.verb.start).unwrap_or_default();
        let is_still =
            STILL.contains(&verb) || verb.strip_suffix("ing").is_some_and(|verb| STILL.contains(&verb));
        if is_still || action.objects.is_empty() {
            for path in std::mem::take(&mut action.paths) {
                self.not_expressible(path.tokens);
            }
            return false;
        }
        // "fold the cloth from the left to the right" does not move it there.
        if matches!(verb, "fold" | "unfold" | "unroll") {
            let is_side = |path: &Path| matches!(path.kind, PathKind::Places(_));
            let (sides, paths): (Vec<Path>, Vec<Path>) =
                std::mem::take(&mut action.paths).into_iter().partition(is_side);
            action.paths = paths;
            for path in sides {
                self.not_expressible(path.tokens);
            }
        }
        if verb == "uncover" && action.paths.is_empty() {
            return self.uncovered(action);
        }
        if action.paths.iter().any(|path| !matches!(path.kind, PathKind::State(_))) {
            if let Some(path) = self.destination(action) {
                self.reach(action, &path);
            }
            self.states(action);
            return false;
        }
        if action.sources.iter().any(|path| !path.targets.is_empty()) {
            self.leave_sources(action);
            return false;
        }
        for &tool in &action.tools.clone() {
            for part in action.objects.clone() {
                self.goal(GoalDraft::new(PredicateKind::UsedOn, tool).to(part.mention), action);
            }
        }
        if !action.paths.is_empty() {
            self.states(action);
        } else if action.tools.is_empty() && !self.is_colon(self.at) {
            // "clear the plate: remove the fork from it" says after the colon what is to be done.
            self.each_object(action, PredicateKind::Moved);
        }
        self.not_expressible(action.verb.clone());
        true
    }

    /// "uncover the pot": what is on it, or its lid, leaves it.
    fn uncovered(&mut self, action: &Action) -> bool {
        for host in Self::mentions(&action.objects) {
            let on = LinkKind::Relation(scene::RelationKind::On);
            let cover = self.parsed.links.iter().rev().find(|link| link.to == host && link.kind == on);
            let cover = match cover.map(|link| link.from) {
                Some(cover) => Some(cover),
                None => self.usual_vessel("lid", action.verb.clone()),
            };
            // The verb is no name of the lid.
            self.parsed.account.retract(&action.verb);
            if let Some(cover) = cover {
                self.goal(GoalDraft::new(PredicateKind::Off, cover).to(host), action);
            }
        }
        self.parsed.account.used(action.verb.clone());
        true
    }

    /// The goals of an object that is put on the table: it has also left what it was in or on.
    pub(super) fn on_table(&self, object: usize) -> Vec<GoalDraft> {
        let mut goals = vec![GoalDraft::new(PredicateKind::On, object)];
        for link in self.parsed.links.iter().filter(|link| link.from == object && link.to != object) {
            let is_support = match link.kind {
                LinkKind::Relation(kind) => kind.is_support(),
                LinkKind::At => true,
                _ => false,
            };
            if is_support {
                let goal = GoalDraft::new(PredicateKind::Off, object).to(link.to);
                goals.push(GoalDraft { kind: GoalKind::AwayFromSupport, ..goal });
            }
        }
        goals
    }

    /// "put a fork next to each plate": one for each of them.
    pub(super) fn for_each_target(&mut self, targets: &[usize], action: &Action) {
        let [target] = targets[..] else { return };
        for part in &action.objects {
            let mention = &mut self.parsed.mentions[part.mention];
            let is_one = mention.count.is_none_or(|count| count == [1, 1]) && !mention.plural;
            if is_one && part.take.is_none() && part.mention != target && mention.each_of.is_none() {
                mention.each_of = Some(target);
                mention.count = None;
            }
        }
    }
}
