//! Clauses, one after the other, as operations.

use std::ops::Range;

use scene::program::{Program, Statement};
use scene::{EditOperation, EditPlace, EditProgram, RelationKind};

use super::discourse::{Changes, Discourse, Topic, goes_stale};
use super::error::{InstructionError, Reason};
use super::new_objects::{NewObjects, new_objects};
use super::targets::Target;
use crate::chart::Chart;
use crate::clause::Clause;
use crate::construction::Act;
use crate::nominal::{NounPhrase, Reference};
use crate::reading::Reading;
use crate::vocabulary::vocabulary;

pub(crate) type Outcome<T> = Result<T, InstructionError>;

/// A step that an instruction asks for.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Step {
    Operation(EditOperation),
    /// Objects leave what carries or contains them; where they go is open.
    TakeOut {
        target: String,
        carrier: String,
        is_inside: bool,
    },
    /// Objects get farther from another one.
    Away {
        target: String,
        landmark: String,
    },
    /// Objects are lifted; where they go is open.
    Lift {
        target: String,
    },
    /// Objects get another posture.
    Pose {
        target: String,
        act: Act,
    },
    /// Everything on or in an object leaves it.
    Clear {
        carrier: String,
        is_inside: bool,
    },
}

/// The steps so far, and what was named.
pub(crate) struct Fold<'c, 't> {
    pub chart: &'c Chart<'t>,
    pub steps: Vec<Step>,
    /// Tokens of the clause of each step.
    pub clauses: Vec<Range<usize>>,
    /// Whether all objects exist: instructions for a robot make none.
    pub all_exist: bool,
    pub discourse: Discourse,
    /// The operation after which the phrases of the topic no longer mean its objects.
    pub stale_at: Option<usize>,
    /// Tokens of the clause.
    pub clause: Range<usize>,
}

/// The program of a reading.
pub(super) fn program(chart: &Chart, reading: &Reading) -> Outcome<EditProgram> {
    let mut fold = Fold::new(chart, false);
    for clause in &reading.clauses {
        fold.clause = clause.start..clause.end;
        fold.check(clause)?;
    }
    if let Some(unread) = reading.unread.first() {
        if chart.word(unread.start) == "or" {
            return Err(fold.error(unread, Reason::Alternative));
        }
        let why = "say one change at a time: add, remove, replace, swap, move, turn, resize, recolor, rename, stack, line up, sort, tidy or rearrange objects, or change their weight, the light or the camera";
        return Err(fold.error(unread, Reason::NotUnderstood(why)));
    }
    for clause in &reading.clauses {
        fold.carry_out(clause)?;
    }
    let mut statements = Vec::new();
    let clauses = std::mem::take(&mut fold.clauses);
    for (step, clause) in std::mem::take(&mut fold.steps).into_iter().zip(clauses) {
        let meaning = match step {
            Step::Operation(operation) => operation,
            Step::TakeOut { target, carrier, is_inside } => {
                let target = located(&target, &carrier, is_inside);
                let place = EditPlace { relation: Some(RelationKind::On), ..EditPlace::default() };
                EditOperation::Move { target, place }
            }
            Step::Clear { carrier, is_inside } => {
                let target = located("everything", &carrier, is_inside);
                EditOperation::Remove { target, with_contents: false }
            }
            Step::Pose { .. } => return fold.refuse(Reason::Posture),
            Step::Away { .. } => return fold.refuse(Reason::HowFar),
            Step::Lift { .. } => continue,
        };
        statements.push(Statement { words: chart.quoted(clause), meaning });
    }
    let whole = 0..chart.tokens.len();
    if statements.is_empty() {
        let kept = !fold.discourse.kept.is_empty();
        return Err(fold.error(&whole, if kept { Reason::Negated } else { Reason::Empty }));
    }
    Ok(Program { statements, asides: asides(chart, reading) })
}

/// The words of clauses that ask for nothing.
pub(crate) fn asides(chart: &Chart, reading: &Reading) -> Vec<String> {
    let is_aside = |clause: &&Clause| matches!(clause.act, Act::Aside | Act::Mention | Act::Keep);
    let clauses = reading.clauses.iter().filter(is_aside);
    clauses.map(|clause| chart.quoted(clause.start..clause.end)).collect()
}

/// The phrase of objects on or in another one.
pub(crate) fn located(target: &str, carrier: &str, is_inside: bool) -> String {
    let is_name = target.contains('_') || carrier.is_empty();
    let preposition = if is_inside { "in" } else { "on" };
    if is_name { target.to_owned() } else { format!("{target} {preposition} {carrier}") }
}

impl<'c, 't> Fold<'c, 't> {
    pub fn new(chart: &'c Chart<'t>, all_exist: bool) -> Self {
        let clause = 0..chart.tokens.len();
        Self {
            chart,
            steps: Vec::new(),
            clauses: Vec::new(),
            all_exist,
            discourse: Discourse::default(),
            stale_at: None,
            clause,
        }
    }
}

impl Fold<'_, '_> {
    pub fn push(&mut self, operation: EditOperation) {
        self.push_step(Step::Operation(operation));
    }

    pub fn push_step(&mut self, step: Step) {
        self.steps.push(step);
        self.clauses.push(self.clause.clone());
    }

    /// Adds the steps of a clause.
    pub fn carry_out(&mut self, clause: &Clause) -> Outcome<()> {
        self.clause = clause.start..clause.end;
        let is_named = |phrase: &&NounPhrase| {
            phrase.reference != Reference::Pronoun && !matches!(phrase.noun.as_str(), "one" | "ones")
        };
        let named = clause.objects("").iter().find(is_named).map(|phrase| plain(&phrase.noun));
        // "the left banana goes on the plate and the right one on the board"
        self.discourse.clause_noun = named.clone().or_else(|| self.discourse.main_noun.clone());
        self.discourse.main_noun = named.or_else(|| self.discourse.main_noun.take());
        let main = clause.objects("").first().filter(|phrase| phrase.reference == Reference::Definite);
        self.discourse.clause_phrase = main.map(|phrase| self.phrase(phrase));
        self.carry(clause)
    }

    pub fn error(&self, tokens: &Range<usize>, reason: Reason) -> InstructionError {
        let (span, words) = (self.chart.bytes(tokens), self.chart.quoted(tokens.clone()));
        InstructionError { words, span, reason }
    }

    pub fn refuse<T>(&self, reason: Reason) -> Outcome<T> {
        Err(self.error(&self.clause, reason))
    }

    /// Refuses what is no command before any command is carried out.
    fn check(&self, clause: &Clause) -> Outcome<()> {
        match clause.act {
            Act::Condition => self.refuse(Reason::Conditional),
            Act::Question => self.refuse(Reason::Question),
            Act::Negation => self.refuse(Reason::Negated),
            _ => Ok(()),
        }
    }

    fn carry(&mut self, clause: &Clause) -> Outcome<()> {
        match clause.act {
            Act::Put | Act::Move | Act::Add => self.put(clause),
            Act::Take => self.take(clause),
            Act::Remove | Act::RemoveWithContents => self.remove(clause),
            Act::Clear | Act::Empty => self.clear(clause),
            Act::Replace => self.replace(clause),
            Act::Swap => self.swap(clause),
            Act::Turn | Act::TurnAround | Act::Face => self.turn(clause),
            Act::Topple | Act::LayOnSide | Act::StandUp => self.pose(clause),
            Act::Lift => self.lift(clause),
            Act::Resize | Act::Grow | Act::Shrink => self.resize(clause),
            Act::Recolor => self.recolor(clause),
            Act::Rename => self.rename(clause),
            Act::Stack => self.stack(clause),
            Act::LineUp | Act::LineUpInDepth | Act::Sort => self.arrange(clause),
            Act::Tidy => self.tidy(),
            Act::Clutter => self.clutter(clause),
            Act::Rearrange => self.rearrange(),
            Act::Remake => self.remake(clause),
            Act::SetPhysics => self.set_physics(clause),
            Act::RestyleTable => self.restyle_table(clause),
            Act::Relight => self.relight(clause),
            Act::MoveCamera => self.move_camera(clause),
            Act::Except => self.except(clause),
            Act::Likewise => self.likewise(clause),
            Act::Aside => Ok(()),
            Act::Keep => self.keep(clause),
            Act::Mention => self.mention(clause),
            Act::Condition | Act::Question | Act::Negation => Ok(()),
        }
    }

    fn remove(&mut self, clause: &Clause) -> Outcome<()> {
        let targets = self.targets(clause.objects(""))?;
        self.remove_targets(targets, clause.act == Act::RemoveWithContents)
    }

    pub fn remove_targets(&mut self, targets: Vec<Target>, with_contents: bool) -> Outcome<()> {
        for target in &targets {
            if self.is_table_phrase(&target.phrase) {
                return self.refuse(Reason::Table);
            }
            self.push(EditOperation::Remove { target: target.phrase.clone(), with_contents });
        }
        self.now_about(targets, Changes::Nothing);
        if let Some(topic) = &mut self.discourse.topic {
            topic.is_removed = true;
            for phrase in &topic.phrases {
                for (_, known, is_removed) in &mut self.discourse.mentions {
                    *is_removed |= known == phrase;
                }
            }
        }
        Ok(())
    }

    /// "clear the table" removes everything, "clear the tray" what is on it, "empty the mug" what is in it.
    fn clear(&mut self, clause: &Clause) -> Outcome<()> {
        let is_inside = clause.act == Act::Empty;
        for target in self.targets(clause.objects(""))? {
            let is_all = target.phrase.starts_with("everything") || target.phrase.starts_with("all ");
            match () {
                () if self.is_table_phrase(&target.phrase) => {
                    self.push(EditOperation::Remove {
                        target: "everything".to_owned(),
                        with_contents: false,
                    });
                }
                () if is_all => {
                    self.push(EditOperation::Remove { target: target.phrase, with_contents: false })
                }
                () => self.push_step(Step::Clear { carrier: target.phrase, is_inside }),
            }
        }
        self.discourse.topic = None;
        Ok(())
    }

    pub fn lift(&mut self, clause: &Clause) -> Outcome<()> {
        let targets = self.targets(clause.objects(""))?;
        for target in &targets {
            self.push_step(Step::Lift { target: target.phrase.clone() });
        }
        self.now_about(targets, Changes::Nothing);
        Ok(())
    }

    pub fn pose(&mut self, clause: &Clause) -> Outcome<()> {
        let targets = self.targets(clause.objects(""))?;
        for target in &targets {
            self.push_step(Step::Pose { target: target.phrase.clone(), act: clause.act });
        }
        self.now_about(targets, Changes::Nothing);
        Ok(())
    }

    fn tidy(&mut self) -> Outcome<()> {
        self.push(EditOperation::Tidy);
        self.discourse.topic = None;
        Ok(())
    }

    fn clutter(&mut self, clause: &Clause) -> Outcome<()> {
        let clutter = match clause.objects("") {
            [] => NewObjects::Clutter { count: 5, theme: None },
            [phrase] => {
                new_objects(self.chart, phrase, None).map_err(|reason| self.error(&phrase.tokens, reason))?
            }
            _ => return self.refuse(Reason::NotUnderstood("say: add five mugs")),
        };
        match clutter {
            NewObjects::Clutter { count, theme } => self.push(EditOperation::Clutter { count, theme }),
            NewObjects::Objects { .. } => return self.refuse(Reason::NotUnderstood("say: add five mugs")),
        }
        Ok(())
    }

    fn keep(&mut self, clause: &Clause) -> Outcome<()> {
        // Only what is there can stay: "not blue, and a stand" keeps nothing.
        let is_new = |phrase: &&NounPhrase| {
            phrase.reference == Reference::Indefinite && self.chart.resolves(&phrase.tokens) != Some(true)
        };
        if let Some(new) = clause.objects("").iter().find(is_new) {
            return Err(
                self.error(&new.tokens, Reason::NotUnderstood("name the objects that stay as they are"))
            );
        }
        let targets = self.targets(clause.objects(""))?;
        self.discourse.kept.extend(targets.iter().map(|target| target.phrase.clone()));
        self.now_about(targets, Changes::Nothing);
        Ok(())
    }

    fn mention(&mut self, clause: &Clause) -> Outcome<()> {
        let existing = clause.objects("").iter().filter(|phrase| phrase.reference != Reference::Indefinite);
        let existing: Vec<NounPhrase> = existing.cloned().collect();
        let targets = self.targets(&existing)?;
        self.now_about(targets, Changes::Nothing);
        Ok(())
    }

    /// Makes the objects of a clause what pronouns stand for.
    pub fn now_about(&mut self, targets: Vec<Target>, changes: Changes) {
        self.discourse.taken_at = None;
        if changes != Changes::Place {
            self.discourse.landmark = None;
        }
        let was_stale = self.discourse.topic.as_ref().is_some_and(|topic| topic.is_stale)
            && targets.iter().any(|target| target.is_pronoun);
        for target in targets.iter().rev().filter(|target| !target.is_pronoun) {
            self.discourse.mention(&target.noun, &target.phrase, false);
        }
        let is_stale = was_stale || targets.iter().any(|target| goes_stale(&target.phrase, changes));
        let is_plural = targets.len() > 1 || targets.iter().any(|target| target.is_plural);
        self.stale_at = is_stale.then(|| self.steps.len().saturating_sub(1));
        let phrases: Vec<String> = targets.into_iter().map(|target| target.phrase).collect();
        let single = phrases.len() == 1;
        self.discourse.topic =
            Some(Topic { is_plural, is_stale: is_stale && single, phrases, ..Topic::default() });
    }

    pub fn is_table_phrase(&self, phrase: &str) -> bool {
        let lower = phrase.to_lowercase();
        let bare =
            ["the ", "my ", "this ", "our ", "your "].iter().find_map(|article| lower.strip_prefix(article));
        vocabulary().is_table(bare.unwrap_or(&lower))
    }
}

/// A noun without colors and materials before it: a label of the scene may begin with them.
fn plain(noun: &str) -> String {
    let mut rest = noun;
    while let Some((first, more)) = rest.split_once(' ') {
        if !vocabulary().is_color(first) && !vocabulary().is_material(first) {
            break;
        }
        rest = more;
    }
    rest.to_owned()
}
