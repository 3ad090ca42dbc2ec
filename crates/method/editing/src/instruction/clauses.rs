//! The clauses of an instruction: a verb and what it asks for, a request, or what an object should be like. A clause
//! without a verb repeats the verb of the one before it ("a fork on the left and a knife on the right").

use super::cursor::{Cursor, Outcome};
use super::measures::BIGGER;
use scene::EditOperation;

/// Operation that a verb asks for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Frame {
    /// New objects; existing ones are moved.
    Add,
    Move,
    Remove,
    /// Removal, or a move out of something.
    Take,
    Clear,
    Empty,
    Replace,
    Swap,
    Rotate,
    Face,
    /// The factor without a measure.
    Resize(Option<f64>),
    Make,
    Change,
    ColorOf,
    Relabel,
    Stack,
    Tidy,
    Clutter,
}

/// Verbs, longer phrases first.
const VERBS: &[(&str, Frame)] = &[
    ("get rid of", Frame::Remove),
    ("take away", Frame::Remove),
    ("throw away", Frame::Remove),
    ("throw out", Frame::Remove),
    ("remove", Frame::Remove),
    ("removing", Frame::Remove),
    ("delete", Frame::Remove),
    ("deleting", Frame::Remove),
    ("erase", Frame::Remove),
    ("discard", Frame::Remove),
    ("eliminate", Frame::Remove),
    ("clear away", Frame::Remove),
    ("clear off", Frame::Clear),
    ("clear", Frame::Clear),
    ("empty", Frame::Empty),
    ("take out", Frame::Take),
    ("take", Frame::Take),
    ("swap out", Frame::Replace),
    ("replace", Frame::Replace),
    ("replacing", Frame::Replace),
    ("substitute", Frame::Swap),
    ("swap", Frame::Swap),
    ("exchange", Frame::Swap),
    ("switch", Frame::Swap),
    ("give me", Frame::Add),
    ("bring me", Frame::Add),
    ("add", Frame::Add),
    ("adding", Frame::Add),
    ("put", Frame::Add),
    ("putting", Frame::Add),
    ("place", Frame::Add),
    ("placing", Frame::Add),
    ("insert", Frame::Add),
    ("include", Frame::Add),
    ("set", Frame::Add),
    ("lay", Frame::Add),
    ("position", Frame::Add),
    ("create", Frame::Add),
    ("spawn", Frame::Add),
    ("drop", Frame::Add),
    ("stand", Frame::Add),
    ("bring", Frame::Add),
    ("move", Frame::Move),
    ("moving", Frame::Move),
    ("shift", Frame::Move),
    ("slide", Frame::Move),
    ("push", Frame::Move),
    ("pull", Frame::Move),
    ("drag", Frame::Move),
    ("relocate", Frame::Move),
    ("transfer", Frame::Move),
    ("rotate", Frame::Rotate),
    ("rotating", Frame::Rotate),
    ("turn", Frame::Rotate),
    ("turning", Frame::Rotate),
    ("spin", Frame::Rotate),
    ("twist", Frame::Rotate),
    ("orient", Frame::Rotate),
    ("face", Frame::Face),
    ("point", Frame::Face),
    ("aim", Frame::Face),
    ("increase the size of", Frame::Resize(Some(BIGGER))),
    ("reduce the size of", Frame::Resize(Some(1.0 / BIGGER))),
    ("enlarge", Frame::Resize(Some(BIGGER))),
    ("grow", Frame::Resize(Some(BIGGER))),
    ("shrink", Frame::Resize(Some(1.0 / BIGGER))),
    ("scale", Frame::Resize(None)),
    ("resize", Frame::Resize(None)),
    ("double", Frame::Resize(Some(2.0))),
    ("halve", Frame::Resize(Some(0.5))),
    ("triple", Frame::Resize(Some(3.0))),
    ("make", Frame::Make),
    ("making", Frame::Make),
    ("paint", Frame::Make),
    ("repaint", Frame::Make),
    ("color", Frame::Make),
    ("colour", Frame::Make),
    ("recolor", Frame::Make),
    ("recolour", Frame::Make),
    ("dye", Frame::Make),
    ("change the color of", Frame::ColorOf),
    ("change the colour of", Frame::ColorOf),
    ("change the material of", Frame::ColorOf),
    ("set the color of", Frame::ColorOf),
    ("set the colour of", Frame::ColorOf),
    ("change", Frame::Change),
    ("rename", Frame::Relabel),
    ("relabel", Frame::Relabel),
    ("label", Frame::Relabel),
    ("call", Frame::Relabel),
    ("stack", Frame::Stack),
    ("pile up", Frame::Stack),
    ("pile", Frame::Stack),
    ("tidy up", Frame::Tidy),
    ("tidy", Frame::Tidy),
    ("straighten up", Frame::Tidy),
    ("straighten out", Frame::Tidy),
    ("straighten", Frame::Tidy),
    ("neaten up", Frame::Tidy),
    ("neaten", Frame::Tidy),
    ("organize", Frame::Tidy),
    ("organise", Frame::Tidy),
    ("align", Frame::Tidy),
    ("arrange", Frame::Tidy),
    ("clutter", Frame::Clutter),
];

const MODALS: &[&str] =
    &["should", "must", "needs to", "need to", "has to", "have to", "goes", "go", "belongs", "belong"];

impl Cursor {
    /// Every clause.
    pub fn clauses(&mut self) -> Outcome<()> {
        let mut frame = None;
        loop {
            while self.is_at(self.at, ".") {
                self.at += 1;
                frame = None;
            }
            if self.at >= self.tokens.len() {
                return Ok(());
            }
            let mut gap = self.at + self.connector_at(self.at);
            gap += usize::from(gap > self.at && self.is_at(gap, "then"));
            let repeats = gap > self.at && self.is_phrase(gap) && self.modal_after(gap).is_none();
            if let Some(frame) = frame.filter(|_| repeats) {
                self.at = gap;
                self.clause(frame)?;
            } else {
                self.skip_opening();
                let _ = self.take("would you mind") || self.take("do you mind");
                if self.at >= self.tokens.len() && !self.operations.is_empty() {
                    return Ok(());
                }
                // A greeting is a sentence of its own.
                if self.is_at(self.at, ".") {
                    continue;
                }
                self.check_clause()?;
                frame = Some(self.next_clause()?);
            }
            self.skip_closing();
            let next = self.at + self.connector_at(self.at);
            let continues = next > self.at || self.is_at(next, "then") || self.is_at(next, "also");
            if !self.is_end(self.at) && !continues {
                return self.not_understood(self.at, "say one change at a time");
            }
        }
    }

    /// A clause with a verb, a request, or a clause that begins with its object; which verb a further object repeats.
    fn next_clause(&mut self) -> Outcome<Frame> {
        let start = self.at;
        if let Some(length) = self.polite_length(start) {
            self.at += length;
            return self.polite_request();
        }
        if self.modal_after(start).is_some() {
            return self.subject_first();
        }
        let found =
            VERBS.iter().filter(|(verb, _)| self.is_at(start, verb)).max_by_key(|(verb, _)| verb.len());
        let Some((verb, frame)) = found else {
            return self.not_understood(
                start,
                "begin with what to do: add, remove, replace, move, rotate, resize, paint, rename, stack or tidy",
            );
        };
        self.at += verb.split(' ').count();
        self.clause(*frame)?;
        Ok(*frame)
    }

    fn clause(&mut self, frame: Frame) -> Outcome<()> {
        match frame {
            Frame::Add | Frame::Move => self.add_or_move(frame),
            Frame::Remove => self.remove(false),
            Frame::Take => self.remove(true),
            Frame::Clear | Frame::Empty => self.clear(frame == Frame::Empty),
            Frame::Replace => self.replace(self.at.saturating_sub(1), &["with", "by", "for", "through"]),
            Frame::Swap => self.replace(self.at.saturating_sub(1), &["for", "with", "by"]),
            Frame::Rotate => self.rotate(),
            Frame::Face => self.face(),
            Frame::Resize(usual) => self.resize(usual),
            Frame::Make => self.make(),
            Frame::Change => self.change_to(),
            Frame::ColorOf => self.color_of(),
            Frame::Relabel => self.relabel(),
            Frame::Stack => self.stack(),
            Frame::Tidy => self.tidy(),
            Frame::Clutter => self.clutter_table(),
        }
    }

    /// Reads the words after "I want": new objects, or a state of existing ones.
    fn polite_request(&mut self) -> Outcome<Frame> {
        let start = self.at;
        if !self.is_definite(start) {
            self.add_or_move(Frame::Add)?;
            return Ok(Frame::Add);
        }
        if self.complement_index(start).is_some() {
            self.make()?;
            return Ok(Frame::Make);
        }
        let be = self.phrase_end(start, &|index| self.is_at(index, "to be"));
        if self.is_at(be, "to be") {
            let targets = self.targets(&|_, index| index == be)?;
            self.at = be + 2;
            let place = self.place()?;
            self.placed(&targets, &place, start)?;
        } else {
            self.relocate(true)?;
        }
        Ok(Frame::Move)
    }

    /// The index of "should" after the phrase that begins a clause.
    fn modal_after(&self, start: usize) -> Option<usize> {
        let is_modal = |index: usize| self.length_of_any(index, MODALS).is_some();
        let end = (start..self.tokens.len()).find(|&index| self.is_end(index) || is_modal(index))?;
        let begins = self.is_phrase(start) && !self.is_verb(start);
        let verb_between =
            (start..end).any(|index| self.is_verb(index) && self.is_boundary(index.saturating_sub(1)));
        (is_modal(end) && end > start && begins && !verb_between).then_some(end)
    }

    /// "the lamp should be behind the laptop".
    fn subject_first(&mut self) -> Outcome<Frame> {
        let start = self.at;
        let definite = self.is_definite(start);
        let is_modal = |cursor: &Self, index: usize| cursor.length_of_any(index, MODALS).is_some();
        if !definite {
            return self.not_understood(start, "say: add a mug next to the laptop");
        }
        let targets = self.targets(&is_modal)?;
        let Some(length) = self.length_of_any(self.at, MODALS) else {
            return self.not_understood(start, "say what should change");
        };
        self.at += length;
        let _ = self.take_any(&[
            "be moved",
            "be placed",
            "be put",
            "be positioned",
            "be",
            "stand",
            "sit",
            "lie",
            "go",
            "move",
            "become",
            "be painted",
        ]);
        if self.take_any(&["removed", "deleted"]) {
            for target in &targets {
                let operation = EditOperation::Remove { target: target.phrase.clone(), with_contents: false };
                self.change(target, operation, start)?;
            }
            self.now_about(&targets, self.operations.len().saturating_sub(targets.len()));
            return Ok(Frame::Remove);
        }
        if self.take_any(&["face", "facing"]) {
            let _ = self.take_any(&["toward", "towards"]);
            self.faced(&targets, start)?;
            return Ok(Frame::Face);
        }
        if self.preposition_at(self.at).is_some() {
            let place = self.place()?;
            self.placed(&targets, &place, start)?;
            return Ok(Frame::Move);
        }
        self.becomes(&targets, start)?;
        Ok(Frame::Make)
    }

    /// "clear the table" removes everything, "clear the tray" what is on it, "empty the mug" what is in it.
    fn clear(&mut self, empties: bool) -> Outcome<()> {
        let start = self.at;
        let end = self.phrase_end(start, &|_| false);
        let phrase = self.text(start, end);
        if self.is_at(start, "everything") || self.is_at(start, "all") || super::discourse::is_plural(&phrase)
        {
            return self.remove(false);
        }
        self.at = end;
        let target = match () {
            () if super::removals::is_table(&phrase) => "everything".to_owned(),
            () if !self.is_definite(start) || self.is_at(start, "it") => {
                return self.not_understood(start, "say: remove everything on the tray");
            }
            () if empties => format!("everything in {phrase}"),
            () => format!("everything on {phrase}"),
        };
        self.operations.push(EditOperation::Remove { target, with_contents: false });
        self.discourse.topic = None;
        Ok(())
    }

    fn tidy(&mut self) -> Outcome<()> {
        let start = self.at;
        let whole = [
            "everything on the table",
            "everything on the desk",
            "everything up",
            "everything",
            "all the objects",
            "all objects",
            "the whole table",
            "the table",
            "the desk",
            "my desk",
            "the tabletop",
            "the scene",
            "things up",
            "things",
            "all",
            "the objects on the table",
            "the objects",
            "it all",
            "the workbench",
            "the place",
        ];
        if !self.is_boundary(self.at) && !self.take_any(&whole) {
            return self.not_understood(start, "the whole table is tidied, not single objects");
        }
        let _ = self.take_any(&["neatly", "up", "a bit", "a little"]);
        self.operations.push(EditOperation::Tidy);
        self.discourse.topic = None;
        Ok(())
    }

    /// "clutter the table with ten objects".
    fn clutter_table(&mut self) -> Outcome<()> {
        let start = self.at;
        let _ = self.take("up");
        if !self.take_any(&["the table", "the desk", "my desk", "the scene", "the workbench"]) {
            return self.not_understood(start, "say: clutter the table");
        }
        let mut count = 5;
        let mut theme = None;
        if self.take("with") {
            let end = self.phrase_end(self.at, &|index| self.preposition_at(index).is_some());
            match self.new_objects(end)? {
                super::nouns::NewObjects::Clutter { count: stated, theme: named } => {
                    (count, theme) = (stated, named)
                }
                super::nouns::NewObjects::Objects { .. } => {
                    return self.not_understood(start, "say: add five mugs");
                }
            }
        }
        self.operations.push(EditOperation::Clutter { count, theme });
        Ok(())
    }
}
