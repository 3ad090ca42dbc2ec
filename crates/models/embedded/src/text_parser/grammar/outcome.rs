//! Goals and start relations of instructions, by the frame of the verb.

use std::ops::Range;

use super::Parser;
use super::action::{Action, Formation, Part, Path, PathKind};
use super::frames::is_sided;
use super::goals::{GoalDraft, GoalKind};
use crate::text_parser::tokens::Token;
use crate::text_parser::verbs::Frame;
use scene::RelationKind;
use scene::text_account::PredicateKind;

impl Parser<'_, '_> {
    /// States the goal of an instruction, and the relations of its start state. Its destination and particles ("onto",
    /// "up") are words of the goal.
    pub(super) fn conclude(&mut self, action: Action) {
        let claims = self.parsed.account.claims.len();
        let paths = action.paths.iter().map(|path| path.tokens.clone());
        let words: Vec<Range<usize>> = paths.chain(action.particles.clone()).collect();
        self.stated(action);
        self.words_of_goals(claims, words);
    }

    fn stated(&mut self, mut action: Action) {
        let known = self.parsed.goals.clone();
        for range in action.particles.clone() {
            self.parsed.account.used(range);
        }
        // "use the knife to cut the apple".
        if action.frame == Frame::UseTool {
            self.use_tool(action);
            return;
        }
        self.sources(&mut action);
        self.implied_objects(&mut action);
        self.moved_part(&mut action);
        self.load_hosts(&mut action);
        if self.empties_host(&action) {
            self.acted = Self::mentions(&action.objects);
            return;
        }
        let lines_up = self.verb_is(&action, "line") && action.frame == Frame::Other;
        let formation = action.formation.or(lines_up.then_some(Formation::Together));
        if let Some(formation) = formation.filter(|_| !action.objects.is_empty()) {
            self.forms(&mut action, formation);
            self.end(&action, &known);
            return;
        }
        match action.frame {
            Frame::Place | Frame::Hang | Frame::Hand | Frame::Push => self.placed(&mut action),
            Frame::Stack => self.stacked(&mut action),
            Frame::Take | Frame::Lift => self.taken(&mut action),
            Frame::Swap => self.swapped(&action),
            Frame::Pour => self.poured(&mut action),
            Frame::Fill => self.filled(&action),
            Frame::Use => self.used_on(&mut action),
            Frame::Cover => self.covered(&action),
            Frame::Separate => self.separated(&action),
            Frame::Open => self.property(&mut action, PredicateKind::Opened),
            // "close the pot with the lid".
            Frame::Close if !action.tools.is_empty() => self.covered(&action),
            Frame::Close => self.property(&mut action, PredicateKind::Closed),
            Frame::Press => self.property(&mut action, PredicateKind::Pressed),
            Frame::Rotate => self.rotated_goal(&mut action),
            Frame::Flip => self.flipped(&mut action),
            Frame::Upright => {
                self.each_object(&action, PredicateKind::Upright);
                if let Some(path) = self.destination(&mut action) {
                    self.reach(&action, &path);
                }
                self.states(&mut action);
            }
            Frame::Topple if Self::tips_into(&action) => self.poured(&mut action),
            Frame::Topple => self.property(&mut action, PredicateKind::LyingOnSide),
            // What is said after an unknown verb may be its end, so it is no start state.
            Frame::UseTool | Frame::Other => {
                if self.other_goal(&mut action) {
                    self.acted = Self::mentions(&action.objects);
                    return;
                }
            }
        }
        self.end(&action, &known);
    }

    /// Reports an instruction that states no goal beside the known ones.
    fn end(&mut self, action: &Action, known: &[GoalDraft]) {
        let stays = self.stays(action) && !action.objects.is_empty();
        if self.parsed.goals == known && !action.is_continued && !stays {
            self.not_expressible(action.verb.clone());
        } else {
            self.parsed.account.used(action.verb.clone());
        }
        if !action.objects.is_empty() {
            self.acted = Self::mentions(&action.objects);
        }
    }

    /// "tip the cup into the bowl".
    fn tips_into(action: &Action) -> bool {
        let inside = |path: &Path| matches!(path.kind, PathKind::Relation(RelationKind::In) | PathKind::At);
        action.paths.iter().any(|path| path.directed && inside(path))
    }

    /// "pull out the drawer" opens it, "push the drawer in" closes it, "lift the lid of the box" opens the box.
    fn moved_part(&self, action: &mut Action) {
        let [object] = action.objects[..] else { return };
        let mention = &self.parsed.mentions[object.mention];
        let mut parts = self.tokens[mention.tokens.clone()].iter().filter_map(Token::word);
        let part =
            parts.next_back().filter(|word| matches!(*word, "drawer" | "door" | "lid" | "flap" | "drawers"));
        let Some(part) = part.filter(|_| self.can_open(object.mention)) else { return };
        let verb = self.word_at(action.verb.start).unwrap_or_default();
        if !action.paths.is_empty() || !action.sources.is_empty() {
            return;
        }
        action.frame = match verb {
            "pull" | "pulls" | "slide" if action.frame != Frame::Close => Frame::Open,
            "push" | "pushes" => Frame::Close,
            "lift" | "raise" if part == "lid" => Frame::Open,
            "lower" | "drop" if part == "lid" => Frame::Close,
            _ => action.frame,
        };
    }

    /// Whether the objects stay where they are ("leave the green block on the table").
    fn stays(&self, action: &Action) -> bool {
        matches!(self.word_at(action.verb.start), Some("leave" | "keep" | "leaves" | "keeps"))
    }

    /// "pick up the apple and place in the bowl": the objects of the instruction before.
    fn implied_objects(&self, action: &mut Action) {
        let moves = matches!(action.frame, Frame::Place | Frame::Push | Frame::Hang | Frame::Stack);
        let closes = matches!(action.frame, Frame::Open | Frame::Close);
        if !action.objects.is_empty() || action.unknown {
            return;
        }
        let part = |mention: usize| Part { mention, take: None };
        if closes {
            action.objects = self.openable().map(part).into_iter().collect();
        } else if moves && !action.paths.is_empty() {
            action.objects = self.acted.iter().copied().map(part).collect();
        }
    }

    pub(super) fn goal(&mut self, goal: GoalDraft, action: &Action) {
        self.add_goal(goal, action.verb.clone());
    }

    pub(super) fn mentions(parts: &[Part]) -> Vec<usize> {
        parts.iter().map(|part| part.mention).collect()
    }

    /// Sources are relations of the start state.
    pub(super) fn sources(&mut self, action: &mut Action) {
        if matches!(action.frame, Frame::Pour | Frame::Fill) {
            return;
        }
        let objects = Self::mentions(&action.objects);
        for path in action.sources.clone() {
            self.start_relation(&objects, &path);
        }
    }

    /// Paths that describe the objects, not their destination.
    pub(super) fn modified(&mut self, action: &mut Action) {
        let objects = Self::mentions(&action.objects);
        for path in std::mem::take(&mut action.paths) {
            self.start_relation(&objects, &path);
        }
    }

    /// The destination among the paths. "put the apple on the plate into the bowl": the directed path, or the last
    /// support; paths before it describe the object, paths after it describe its target.
    pub(super) fn destination(&mut self, action: &mut Action) -> Option<Path> {
        let paths = std::mem::take(&mut action.paths);
        let support = |path: &Path| match &path.kind {
            PathKind::Relation(kind) => kind.is_support(),
            PathKind::At | PathKind::Table => true,
            _ => false,
        };
        let is_state = |path: &Path| matches!(path.kind, PathKind::State(_));
        let spatial: Vec<usize> = (0..paths.len()).filter(|&k| !is_state(&paths[k])).collect();
        let Some(&last) = spatial.last() else {
            action.paths = paths;
            return None;
        };
        let from_end = |wanted: &dyn Fn(&Path) -> bool| spatial.iter().copied().rfind(|&k| wanted(&paths[k]));
        let directed = spatial.iter().copied().find(|&k| paths[k].directed && !is_sided(&paths[k]));
        // "move the apple on the plate to the left of the bowl", but "put the apple on the plate to the left of the
        // bowl".
        let sided = from_end(&|path| path.directed && is_sided(path)).filter(|_| self.moves(action));
        // "put it in the bowl in the sink": the bowl is in the sink.
        let first = spatial.iter().copied().find(|&k| support(&paths[k])).filter(|_| action.by_pronoun);
        let chosen = directed
            .or(sided)
            .or(first)
            .or_else(|| if support(&paths[last]) { Some(last) } else { from_end(&support) })
            .unwrap_or(last);
        let objects = Self::mentions(&action.objects);
        for (k, path) in paths.iter().enumerate() {
            if is_state(path) {
                action.paths.push(path.clone());
            } else if k < chosen {
                self.start_relation(&objects, path);
            } else if k > chosen {
                let same_kind = path.kind == paths[chosen].kind && path.tokens == paths[chosen].tokens;
                if same_kind {
                    self.reach(action, path);
                } else {
                    self.start_relation(&paths[chosen].targets.clone(), path);
                }
            }
        }
        Some(paths[chosen].clone())
    }

    /// Whether the verb names a motion, so that "to" begins its end.
    fn moves(&self, action: &Action) -> bool {
        action.frame == Frame::Push
            || matches!(
                self.word_at(action.verb.start),
                Some("move" | "shift" | "bring" | "transfer" | "relocate" | "carry" | "take")
            )
    }

    /// States that the objects are at the destination at the end.
    pub(super) fn reach(&mut self, action: &Action, path: &Path) {
        self.parsed.account.used(path.tokens.clone());
        for &part in &action.objects {
            for goal in self.goals_of_path(part, path) {
                self.goal(GoalDraft { take: part.take, ..goal }, action);
            }
        }
    }

    pub(super) fn goals_of_path(&mut self, part: Part, path: &Path) -> Vec<GoalDraft> {
        let object = part.mention;
        let to = |kind: PredicateKind| -> Vec<GoalDraft> {
            path.targets
                .iter()
                .filter(|target| **target != object)
                .map(|&target| GoalDraft { second: path.second, ..GoalDraft::new(kind, object).to(target) })
                .collect()
        };
        match &path.kind {
            PathKind::Relation(kind) => {
                let Some(predicate) = predicate_of(*kind, path.inverse) else {
                    self.not_expressible(path.tokens.clone());
                    return Vec::new();
                };
                if path.inverse && predicate == PredicateKind::On {
                    // "put the coaster under the mug": the mug is on the coaster at the end.
                    return path
                        .targets
                        .iter()
                        .map(|&target| GoalDraft::new(predicate, target).to(object))
                        .collect();
                }
                to(predicate)
            }
            PathKind::At => to(PredicateKind::On)
                .into_iter()
                .map(|goal| GoalDraft { kind: GoalKind::At, ..goal })
                .collect(),
            PathKind::Away => to(PredicateKind::AwayFrom),
            PathKind::Places(places) => places
                .iter()
                .filter_map(|place| Some(GoalDraft::new(place_predicate(*place)?, object)))
                .collect(),
            PathKind::Table => self.on_table(object),
            PathKind::Person => vec![GoalDraft::new(PredicateKind::Lifted, object)],
            PathKind::State(state) => match state.as_str() {
                "upright" => vec![GoalDraft::new(PredicateKind::Upright, object)],
                "lying_on_side" => vec![GoalDraft::new(PredicateKind::LyingOnSide, object)],
                _ => vec![GoalDraft::new(PredicateKind::UpsideDown, object)],
            },
        }
    }

    pub(super) fn states(&mut self, action: &mut Action) {
        for path in std::mem::take(&mut action.paths) {
            self.reach(action, &path);
        }
    }

    pub(super) fn placed(&mut self, action: &mut Action) {
        if action.objects.is_empty() {
            self.modified(action);
            return;
        }
        if self.stays(action) {
            self.modified(action);
            return;
        }
        let verb = self.word_at(action.verb.start).unwrap_or_default();
        let gathers = matches!(verb, "gather" | "collect" | "group");
        let leaves = action.sources.iter().any(|path| !path.targets.is_empty());
        let lays =
            verb == "lay" && action.particles.iter().any(|range| self.word_at(range.start) == Some("down"));
        let destination = self.destination(action).or_else(|| self.place_before(action));
        match destination {
            Some(path) => {
                let pressed = verb == "push"
                    && matches!(path.kind, PathKind::Relation(RelationKind::On))
                    && !path.directed
                    && !path.inverse;
                if pressed {
                    // "push the button on the lamp": it describes the object.
                    let objects = Self::mentions(&action.objects);
                    self.start_relation(&objects, &path);
                    self.each_object(action, PredicateKind::Moved);
                } else {
                    self.reach(action, &path);
                    if action.frame == Frame::Push
                        && matches!(path.kind, PathKind::Places(_))
                        && path.distance_m.is_some()
                    {
                        self.each_object(action, PredicateKind::Moved);
                    }
                }
            }
            None if action.for_person => self.each_object(action, PredicateKind::Lifted),
            None if leaves => self.leave_sources(action),
            None if lays && action.paths.is_empty() => self.each_object(action, PredicateKind::LyingOnSide),
            None if action.frame == Frame::Hand => self.each_object(action, PredicateKind::Lifted),
            None if action.frame == Frame::Push
                || matches!(verb, "move" | "shift" | "relocate" | "reposition") =>
            {
                self.each_object(action, PredicateKind::Moved);
            }
            None if !action.paths.is_empty() => {}
            None if gathers => {
                for part in action.objects.clone() {
                    self.goal(
                        GoalDraft {
                            kind: GoalKind::Together,
                            ..GoalDraft::new(PredicateKind::NextTo, part.mention)
                        },
                        action,
                    );
                }
            }
            None => {}
        }
        self.states(action);
    }

    pub(super) fn each_object(&mut self, action: &Action, kind: PredicateKind) {
        for part in action.objects.clone() {
            self.goal(GoalDraft { take: part.take, ..GoalDraft::new(kind, part.mention) }, action);
        }
    }

    pub(super) fn property(&mut self, action: &mut Action, kind: PredicateKind) {
        let paths = std::mem::take(&mut action.paths);
        let (states, spatial): (Vec<Path>, Vec<Path>) =
            paths.into_iter().partition(|path| matches!(path.kind, PathKind::State(_)));
        let objects = Self::mentions(&action.objects);
        for path in spatial {
            self.start_relation(&objects, &path);
        }
        for path in states {
            self.parsed.account.used(path.tokens);
        }
        self.each_object(action, kind);
    }
}

pub(super) fn predicate_of(kind: RelationKind, inverse: bool) -> Option<PredicateKind> {
    Some(match kind {
        RelationKind::On | RelationKind::StackedOn => PredicateKind::On,
        RelationKind::In if !inverse => PredicateKind::In,
        RelationKind::LeftOf => PredicateKind::LeftOf,
        RelationKind::RightOf => PredicateKind::RightOf,
        RelationKind::InFrontOf => PredicateKind::InFrontOf,
        RelationKind::Behind => PredicateKind::Behind,
        RelationKind::NextTo | RelationKind::Around => PredicateKind::NextTo,
        RelationKind::Between => PredicateKind::Between,
        _ => return None,
    })
}

fn place_predicate(kind: RelationKind) -> Option<PredicateKind> {
    Some(match kind {
        RelationKind::AtCenter => PredicateKind::AtCenter,
        RelationKind::AtBack => PredicateKind::AtBack,
        RelationKind::AtFront => PredicateKind::AtFront,
        RelationKind::AtLeft => PredicateKind::AtLeft,
        RelationKind::AtRight => PredicateKind::AtRight,
        RelationKind::AtBackLeft => PredicateKind::AtBackLeft,
        RelationKind::AtBackRight => PredicateKind::AtBackRight,
        RelationKind::AtFrontLeft => PredicateKind::AtFrontLeft,
        RelationKind::AtFrontRight => PredicateKind::AtFrontRight,
        _ => return None,
    })
}
