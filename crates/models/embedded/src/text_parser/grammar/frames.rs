//! Goals of the frames of verbs: taking, stacking, swapping, pouring and the like.

use super::Parser;
use super::action::{Action, Part, Path, PathKind};
use super::goals::{GoalDraft, GoalKind};
use crate::text_parser::tokens::Token;
use crate::text_parser::verbs::{Frame, verbs};
use scene::RelationKind;
use scene::description::RequestedPose;
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
        // "lift the marker upright".
        if action.frame == Frame::Lift
            && action.paths.iter().any(|path| path.kind == PathKind::State("upright".to_owned()))
        {
            self.modified_but_states(action);
            self.states(action);
            return;
        }
        let moves = action.paths.iter().any(|path| self.is_destination(action, path));
        if moves {
            if let Some(path) = self.destination(action) {
                self.reach(action, &path);
            }
            self.states(action);
            return;
        }
        self.modified(action);
        let is_out = |at: usize| matches!(self.word_at(at), Some("out" | "off"));
        let out = action.particles.iter().any(|range| is_out(range.start)) || action.verb.clone().any(is_out);
        if out && action.sources.is_empty() && self.leave_known_support(action) {
            return;
        }
        // "open the box and take the ball out".
        if out && action.sources.is_empty() && self.leave_opened(action) {
            return;
        }
        // "pick the mug from under the coffee maker".
        let under = |at: usize| matches!(self.word_at(at), Some("under" | "underneath" | "beneath"));
        let is_under = |path: &Path| path.tokens.clone().any(under) && !path.targets.is_empty();
        let leaves =
            action.frame == Frame::Take && action.sources.iter().any(|path| !path.targets.is_empty());
        if leaves || action.sources.iter().any(is_under) {
            self.leave_sources(action);
        } else if action.frame == Frame::Take && self.leave_stack(action) {
        } else if action.frame == Frame::Take && self.verb_is(action, "unstack") {
            for part in action.objects.clone() {
                self.parsed.mentions[part.mention].stacked = true;
                let goal = GoalDraft::new(PredicateKind::Off, part.mention);
                self.goal(GoalDraft { kind: GoalKind::UnstackOfItself, ..goal }, action);
            }
        } else {
            self.each_object(action, PredicateKind::Lifted);
        }
    }

    /// The objects are no longer in what has been opened.
    fn leave_opened(&mut self, action: &Action) -> bool {
        let opened = self.parsed.goals.iter().rev().find(|goal| {
            matches!(goal.kind, GoalKind::Predicate(PredicateKind::Opened | PredicateKind::Closed))
        });
        let Some(host) = opened.map(|goal| goal.object) else { return false };
        let parts: Vec<Part> = action.objects.iter().copied().filter(|part| part.mention != host).collect();
        for part in &parts {
            let goal = GoalDraft::new(PredicateKind::OutOf, part.mention).to(host);
            self.goal(GoalDraft { take: part.take, ..goal }, action);
        }
        !parts.is_empty()
    }

    /// "remove the top book of the stack": the last objects leave the others.
    fn leave_stack(&mut self, action: &Action) -> bool {
        let stacked = |part: &&Part| part.take.is_some() && self.parsed.mentions[part.mention].stacked;
        let parts: Vec<Part> = action.objects.iter().filter(stacked).copied().collect();
        for part in &parts {
            let goal = GoalDraft::new(PredicateKind::Off, part.mention);
            self.goal(GoalDraft { kind: GoalKind::UnstackOfItself, take: part.take, ..goal }, action);
        }
        !parts.is_empty()
    }

    /// Whether the path says where the object is taken. "pick up the mug on the plate" and "pick up the apple to the
    /// left of the bowl" describe the object; "take the mug to the plate" moves it.
    fn is_destination(&self, action: &Action, path: &Path) -> bool {
        match path.kind {
            PathKind::Person => true,
            // "pick up the block on the table".
            PathKind::Table => path.directed || action.frame == Frame::Take,
            _ if !path.directed => false,
            _ if is_sided(path) => {
                // "take the apple to the left of the bowl and put it in the bowl".
                let goes_on = matches!(self.word(0), Some("and" | "then"))
                    || matches!(self.tokens.get(self.at), Some(Token::Pause));
                action.frame == Frame::Take && !goes_on
            }
            _ => true,
        }
    }

    /// The paths but states describe the objects.
    fn modified_but_states(&mut self, action: &mut Action) {
        let (states, others): (Vec<Path>, Vec<Path>) = std::mem::take(&mut action.paths)
            .into_iter()
            .partition(|path| matches!(path.kind, PathKind::State(_)));
        action.paths = others;
        self.modified(action);
        action.paths = states;
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
            let take = part.take.filter(|_| link.from == part.mention);
            self.goal(GoalDraft { kind: GoalKind::AwayFromSupport, take, ..goal }, action);
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

    pub(super) fn used_on(&mut self, action: &mut Action) {
        let table = action.paths.iter().chain(&action.sources).any(|path| path.kind == PathKind::Table);
        let verb = self.word_at(action.verb.start).unwrap_or_default().to_owned();
        let mut objects = Self::mentions(&action.objects);
        // "rinse the plate under the faucet".
        let is_above = |path: &Path| path.inverse && path.kind == PathKind::Relation(RelationKind::On);
        let (above, paths): (Vec<Path>, Vec<Path>) =
            std::mem::take(&mut action.paths).into_iter().partition(is_above);
        for path in above {
            action.tools.extend(path.targets);
            self.parsed.account.used(path.tokens);
        }
        // "grab the sponge; wipe the plate".
        if action.tools.is_empty() {
            let lifted = GoalKind::Predicate(PredicateKind::Lifted);
            let held =
                self.parsed.goals.iter().rev().find(|goal| goal.kind == lifted).map(|goal| goal.object);
            action.tools.extend(held.filter(|held| !objects.contains(held)));
        }
        // "stamp the seal on the block".
        if matches!(verb.as_str(), "stamp" | "press")
            && action.tools.is_empty()
            && paths.iter().any(|path| !path.targets.is_empty())
        {
            action.tools = std::mem::take(&mut objects);
        }
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
        if self.tools_form_stack(&tools) {
            return;
        }
        if self.word(0) == Some("to") || self.word(0) == Some("for") || self.word(0) == Some("and") {
            let at = self.at + 1;
            if let Some((frame, length)) = verbs().at(self.tokens, at) {
                self.parsed.account.used(action.verb.start..action.verb.end);
                self.parsed.account.used(self.at..at);
                let subjects = if matches!(frame, Frame::Use | Frame::Pour) { tools } else { Vec::new() };
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
        // "cover the plate with the bowl upside down".
        let covers: Vec<Part> = action.tools.iter().map(|&mention| Part { mention, take: None }).collect();
        let stated = Action { objects: covers, ..action.clone() };
        for path in action.paths.iter().filter(|path| matches!(path.kind, PathKind::State(_))) {
            self.reach(&stated, path);
        }
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

    /// Turns objects over: one that is upside down becomes upright.
    pub(super) fn flipped(&mut self, action: &mut Action) {
        let upright = action.paths.iter().any(|path| path.kind == PathKind::State("upright".to_owned()));
        let paths = std::mem::take(&mut action.paths);
        for part in action.objects.clone() {
            let is_turned = self.parsed.mentions[part.mention].pose == RequestedPose::UpsideDown;
            let kind = if upright || is_turned { PredicateKind::Upright } else { PredicateKind::UpsideDown };
            action.objects = vec![part];
            action.paths.clone_from(&paths);
            self.property(action, kind);
        }
    }
}

/// Whether the path names a side of its target.
pub(super) fn is_sided(path: &Path) -> bool {
    matches!(
        path.kind,
        PathKind::Relation(
            RelationKind::LeftOf | RelationKind::RightOf | RelationKind::InFrontOf | RelationKind::Behind
        )
    )
}
