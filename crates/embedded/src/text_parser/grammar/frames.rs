//! Goals of the frames of verbs: taking, stacking, swapping, pouring and the like.

use super::Parser;
use super::action::{Action, Part, Path, PathKind};
use super::goals::{GoalDraft, GoalKind};
use crate::text_parser::verbs::{Frame, verbs};
use scene::RelationKind;
use scene::text_account::PredicateKind;

impl Parser<'_, '_> {
    /// The objects are no longer at their sources.
    pub(super) fn leave_sources(&mut self, action: &Action) {
        for part in action.objects.clone() {
            for path in action.sources.clone() {
                for &target in &path.targets {
                    let goal = GoalDraft {
                        take: part.take,
                        ..GoalDraft::new(PredicateKind::Off, part.mention).to(target)
                    };
                    let kind = match path.kind {
                        PathKind::Relation(RelationKind::In) => GoalKind::Predicate(PredicateKind::OutOf),
                        PathKind::Relation(RelationKind::On) => GoalKind::Predicate(PredicateKind::Off),
                        PathKind::At => GoalKind::AwayFromSupport,
                        _ => GoalKind::Predicate(PredicateKind::AwayFrom),
                    };
                    self.goal(GoalDraft { kind, ..goal }, action);
                }
                if path.targets.is_empty() {
                    self.goal(GoalDraft::new(PredicateKind::Lifted, part.mention), action);
                }
            }
        }
    }

    pub(super) fn taken(&mut self, action: &mut Action) {
        // "pick up the mug on the plate": the path describes the mug; "take the mug to the plate" moves it.
        let moves = action
            .paths
            .iter()
            .any(|path| path.directed || matches!(path.kind, PathKind::Person | PathKind::Table));
        if moves && action.frame == Frame::Take {
            if let Some(path) = self.destination(action) {
                self.reach(action, &path);
            }
            self.states(action);
            return;
        }
        if moves {
            if let Some(path) = self.destination(action) {
                self.reach(action, &path);
            }
            self.states(action);
            return;
        }
        self.modified(action);
        let out =
            action.particles.iter().any(|range| matches!(self.word_at(range.start), Some("out" | "off")));
        if out && action.sources.is_empty() && self.leave_known_support(action) {
            return;
        }
        if action.sources.iter().any(|path| !path.targets.is_empty()) && action.frame == Frame::Take {
            self.leave_sources(action);
        } else if action.frame == Frame::Take && self.verb_is(action, "unstack") {
            for part in action.objects.clone() {
                self.parsed.mentions[part.mention].stacked = true;
            }
        } else {
            self.each_object(action, PredicateKind::Lifted);
        }
    }

    /// "a bowl with a spoon in it; take it out": the object that is in or on another.
    pub(super) fn leave_known_support(&mut self, action: &Action) -> bool {
        let mut found = false;
        for part in action.objects.clone() {
            let supported = |link: &&super::Link| match link.kind {
                super::LinkKind::Relation(kind) => kind.is_support(),
                _ => true,
            };
            let links = self.parsed.links.iter();
            let own = links.clone().filter(supported).find(|link| link.from == part.mention);
            let inside = links.filter(supported).find(|link| link.to == part.mention);
            let Some(&link) = own.or(inside) else { continue };
            let goal = GoalDraft::new(PredicateKind::Off, link.from).to(link.to);
            self.goal(GoalDraft { kind: GoalKind::AwayFromSupport, ..goal }, action);
            found = true;
        }
        found
    }

    pub(super) fn verb_is(&self, action: &Action, verb: &str) -> bool {
        self.word_at(action.verb.start) == Some(verb)
    }

    pub(super) fn stacked(&mut self, action: &mut Action) {
        let objects = action.objects.clone();
        let paths = std::mem::take(&mut action.paths);
        let mut below: Vec<usize> = Vec::new();
        for path in &paths {
            self.parsed.account.used(path.tokens.clone());
            match &path.kind {
                PathKind::Relation(kind) if kind.is_support() => below.extend(&path.targets),
                PathKind::At => below.extend(&path.targets),
                PathKind::State(_) | PathKind::Table => {}
                _ => {
                    let tops = Self::mentions(&objects);
                    self.start_relation(&tops, path);
                }
            }
        }
        below.extend(action.tools.iter().copied());
        if below.is_empty() {
            match objects[..] {
                [] => {}
                [one] => {
                    let goal = GoalDraft::new(PredicateKind::StackedOn, one.mention);
                    self.goal(GoalDraft { kind: GoalKind::StackOfItself, ..goal }, action);
                }
                _ => {
                    for pair in objects.windows(2) {
                        let goal =
                            GoalDraft::new(PredicateKind::StackedOn, pair[1].mention).to(pair[0].mention);
                        self.goal(goal, action);
                    }
                }
            }
            return;
        }
        let container = |parser: &Self, mention: usize| parser.is_container(mention);
        for &part in &objects {
            if part.mention == below[0] {
                let goal = GoalDraft::new(PredicateKind::StackedOn, part.mention);
                self.goal(GoalDraft { kind: GoalKind::StackOfItself, ..goal }, action);
                continue;
            }
            let inside = paths.iter().any(|path| path.kind == PathKind::Relation(RelationKind::In))
                && container(self, below[0]);
            let kind = if inside { PredicateKind::In } else { PredicateKind::StackedOn };
            self.goal(
                GoalDraft { take: part.take, ..GoalDraft::new(kind, part.mention).to(below[0]) },
                action,
            );
        }
        for pair in below.windows(2) {
            self.goal(GoalDraft::new(PredicateKind::StackedOn, pair[0]).to(pair[1]), action);
        }
    }

    pub(super) fn is_container(&self, mention: usize) -> bool {
        use crate::text_parser::lexicon::Meaning;
        match self.parsed.mentions[mention].meanings.first() {
            Some(Meaning::Category(index)) => {
                self.lexicon.categories[*index].affords(catalog::Affordance::Container)
            }
            _ => false,
        }
    }

    pub(super) fn swapped(&mut self, action: &Action) {
        let mut parts = action.objects.clone();
        parts.extend(action.seconds.clone());
        for path in &action.paths {
            self.parsed.account.used(path.tokens.clone());
            parts.extend(path.targets.iter().map(|&mention| Part { mention, take: None }));
        }
        parts.dedup();
        match parts[..] {
            [first, second, ..] if first.mention != second.mention => {
                self.goal(GoalDraft::new(PredicateKind::Swapped, first.mention).to(second.mention), action);
            }
            // "swap the two mugs".
            [one] | [one, ..] if self.is_several(one.mention) => {
                self.goal(GoalDraft::new(PredicateKind::Swapped, one.mention).to(one.mention), action);
            }
            _ => {}
        }
    }

    pub(super) fn targets(paths: &[Path]) -> Vec<usize> {
        paths.iter().flat_map(|path| path.targets.iter().copied()).collect()
    }

    pub(super) fn poured(&mut self, action: &mut Action) {
        let sources = Self::targets(&action.sources);
        let vessels = if sources.is_empty() { Self::mentions(&action.objects) } else { sources };
        for path in action.sources.iter().chain(&action.paths).cloned().collect::<Vec<_>>() {
            self.parsed.account.used(path.tokens);
        }
        for target in Self::targets(&action.paths) {
            for &vessel in &vessels {
                if vessel != target {
                    self.goal(GoalDraft::new(PredicateKind::PouredInto, vessel).to(target), action);
                }
            }
        }
        // "empty the box": everything leaves it.
        let objects = Self::mentions(&action.objects);
        if action.paths.is_empty() {
            for object in objects {
                let inside: Vec<usize> = self
                    .parsed
                    .links
                    .iter()
                    .filter(|link| {
                        link.to == object
                            && !matches!(link.kind, super::LinkKind::Relation(kind) if !kind.is_support())
                    })
                    .map(|link| link.from)
                    .collect();
                for content in inside {
                    self.goal(GoalDraft::new(PredicateKind::OutOf, content).to(object), action);
                }
            }
        }
    }

    /// "fill the mug with water from the pitcher".
    pub(super) fn filled(&mut self, action: &Action) {
        let mut vessels = Self::targets(&action.sources);
        vessels.extend(&action.tools);
        for path in action.sources.iter().chain(&action.paths).cloned().collect::<Vec<_>>() {
            self.parsed.account.used(path.tokens);
        }
        for part in action.objects.clone() {
            for &vessel in &vessels {
                if vessel != part.mention {
                    let pours = action.substance || self.is_container(vessel);
                    let kind = if pours { PredicateKind::PouredInto } else { PredicateKind::In };
                    self.goal(GoalDraft::new(kind, vessel).to(part.mention), action);
                }
            }
        }
    }

    pub(super) fn used_on(&mut self, action: &mut Action) {
        let table = action.paths.iter().any(|path| path.kind == PathKind::Table);
        let verb = self.word_at(action.verb.start).unwrap_or_default().to_owned();
        let mut objects = Self::mentions(&action.objects);
        let paths = std::mem::take(&mut action.paths);
        // "spread butter on the bread with the knife", "stir in the pot", "sweep the beans into the pan".
        let mut moved = false;
        for path in &paths {
            if path.directed && !objects.is_empty() && verbs().is_form(&verb) {
                self.reach(action, path);
                moved = true;
            } else if objects.is_empty() {
                objects.extend(&path.targets);
                self.parsed.account.used(path.tokens.clone());
            } else {
                self.start_relation(&objects, path);
            }
        }
        for tool in action.tools.clone() {
            if table && objects.is_empty() {
                self.goal(GoalDraft::new(PredicateKind::UsedOn, tool), action);
            }
            for &object in &objects {
                if object != tool && !moved {
                    self.goal(GoalDraft::new(PredicateKind::UsedOn, tool).to(object), action);
                }
            }
        }
    }

    /// "use the knife to cut the apple": the object is the tool of the next verb.
    pub(super) fn use_tool(&mut self, action: Action) {
        let tools = Self::mentions(&action.objects);
        if self.word(0) == Some("to") || self.word(0) == Some("for") || self.word(0) == Some("and") {
            let at = self.at + 1;
            if let Some((frame, length)) = verbs().at(self.tokens, at) {
                self.parsed.account.used(action.verb.start..action.verb.end);
                self.parsed.account.used(self.at..at);
                let subjects = if frame == Frame::Use { tools } else { Vec::new() };
                self.act(frame, at, length, subjects);
                return;
            }
        }
        let objects = tools.clone();
        let targets: Vec<usize> = Self::targets(&action.paths);
        for &tool in &objects {
            for &target in &targets {
                self.goal(GoalDraft::new(PredicateKind::UsedOn, tool).to(target), &action);
            }
        }
        if targets.is_empty() {
            self.not_expressible(action.verb);
        } else {
            for path in action.paths {
                self.parsed.account.used(path.tokens);
            }
            self.parsed.account.used(action.verb);
        }
    }

    /// "cover the bowl with the plate": the plate is on the bowl.
    pub(super) fn covered(&mut self, action: &Action) {
        for part in action.objects.clone() {
            for &cover in &action.tools {
                self.goal(GoalDraft::new(PredicateKind::On, cover).to(part.mention), action);
            }
        }
    }

    pub(super) fn separated(&mut self, action: &Action) {
        let mut targets = Self::targets(&action.paths);
        targets.extend(Self::targets(&action.sources));
        for path in action.sources.iter().chain(&action.paths).cloned().collect::<Vec<_>>() {
            self.parsed.account.used(path.tokens);
        }
        let objects = Self::mentions(&action.objects);
        if let ([first, second], true) = (&objects[..], targets.is_empty()) {
            targets.push(*second);
            self.goal(GoalDraft::new(PredicateKind::AwayFrom, *first).to(*second), action);
            return;
        }
        for &object in &objects {
            for &target in &targets {
                self.goal(GoalDraft::new(PredicateKind::AwayFrom, object).to(target), action);
            }
        }
    }

    pub(super) fn rotated_goal(&mut self, action: &mut Action) {
        let state = action.paths.iter().any(|path| matches!(path.kind, PathKind::State(_)));
        let paths = std::mem::take(&mut action.paths);
        if state {
            action.paths = paths;
            self.states(action);
            return;
        }
        for path in paths {
            self.parsed.account.used(path.tokens);
        }
        self.each_object(action, PredicateKind::Rotated);
    }

    pub(super) fn flipped(&mut self, action: &mut Action) {
        let upright = action.paths.iter().any(|path| path.kind == PathKind::State("upright".to_owned()));
        let kind = if upright { PredicateKind::Upright } else { PredicateKind::UpsideDown };
        self.property(action, kind);
    }
}
