//! Clauses that change objects: others in their place, turns, sizes, colors, labels, rows.

use std::f64::consts::{FRAC_PI_2, PI};

use scene::{ArrangedAs, EditOperation, EditPlace, RelationKind, SortedBy};

use super::discourse::{Changes, Topic};
use super::error::Reason;
use super::fold::{Fold, Outcome};
use super::new_objects::{NewObjects, definite, new_objects};
use super::places::Destination;
use super::targets::Target;
use crate::clause::{Clause, Filler, Heading, SortKey};
use crate::construction::Act;
use crate::measures::Change;
use crate::nominal::Reference;

/// Factor of "enlarge" without a measure.
const BIGGER: f64 = 1.25;

impl Fold<'_, '_> {
    pub fn replace(&mut self, clause: &Clause) -> Outcome<()> {
        let others = clause.objects("other");
        if others.iter().all(|other| other.reference == Reference::Definite) {
            let mut both = self.targets(clause.objects(""))?;
            both.extend(self.targets(others)?);
            return self.swapped(both);
        }
        let targets = self.targets(clause.objects(""))?;
        let [other] = others else { return self.refuse(Reason::OneForOne) };
        let mut made = Vec::new();
        for target in targets {
            let noun = Some(target.noun.clone()).filter(|noun| !noun.is_empty());
            let last = noun.or_else(|| self.discourse.last_noun().map(str::to_owned));
            let new = new_objects(self.chart, other, last.as_deref());
            let new = new.map_err(|reason| self.error(&other.tokens, reason))?;
            let NewObjects::Objects { object, count } = new else { return self.refuse(Reason::OneForOne) };
            if count > 1 && !target.is_plural {
                return self.refuse(Reason::OneForOne);
            }
            made.push(definite(&object, count));
            self.discourse.mention(&other.noun, &definite(&object, count), false);
            self.push(EditOperation::Replace { target: target.phrase, object });
        }
        let is_plural = made.len() > 1 || other.quantity.is_plural();
        self.discourse.topic = Some(Topic { phrases: made, is_plural, ..Topic::default() });
        self.stale_at = None;
        Ok(())
    }

    pub fn swap(&mut self, clause: &Clause) -> Outcome<()> {
        let mut targets = self.targets(clause.objects(""))?;
        targets.extend(self.targets(clause.objects("other"))?);
        // "... and the pliers where the hammer is" says the same again.
        let mut back = self.targets(clause.objects("fourth"))?;
        back.extend(self.targets(clause.objects("third"))?);
        let is_same = back.iter().zip(&targets).all(|(back, target)| back.phrase == target.phrase);
        if !is_same {
            return self.refuse(Reason::Swap);
        }
        self.swapped(targets)
    }

    pub fn swapped(&mut self, targets: Vec<Target>) -> Outcome<()> {
        if targets.is_empty() || targets.len() > 2 || (targets.len() == 1 && !targets[0].is_plural) {
            return self.refuse(Reason::Swap);
        }
        let phrases = targets.iter().map(|target| target.phrase.clone()).collect();
        self.push(EditOperation::Swap { targets: phrases });
        self.now_about(targets, Changes::Place);
        Ok(())
    }

    pub fn turn(&mut self, clause: &Clause) -> Outcome<()> {
        let angle = clause.fillers.iter().find_map(|(_, filler)| match filler {
            Filler::Angle(rad) => Some(*rad),
            _ => None,
        });
        let heading = clause.fillers.iter().find_map(|(_, filler)| match filler {
            Filler::Heading(heading) => Some(yaw_rad(*heading)),
            _ => None,
        });
        let by_rad = if clause.act == Act::TurnAround { Some(PI) } else { angle };
        let targets = self.targets(clause.objects(""))?;
        let others = self.targets(clause.objects("other"))?;
        if !clause.objects("away").is_empty() {
            return self.refuse(Reason::NotUnderstood("say what it faces instead"));
        }
        let facing = match others.as_slice() {
            [] => None,
            [one] => Some(one.phrase.clone()),
            _ => return self.refuse(Reason::SeveralLandmarks),
        };
        if by_rad.is_none() && heading.is_none() && facing.is_none() {
            if self.all_exist && clause.act == Act::Turn {
                return self.pose(clause);
            }
            return self.refuse(Reason::HowFarTurned);
        }
        for target in &targets {
            let (target, facing) = (target.phrase.clone(), facing.clone());
            self.push(EditOperation::Rotate { target, by_rad, to_rad: heading, facing });
        }
        self.now_about(targets, Changes::Nothing);
        Ok(())
    }

    pub fn resize(&mut self, clause: &Clause) -> Outcome<()> {
        let stated = clause.fillers.iter().find_map(|(_, filler)| match filler {
            Filler::Factor(factor) => Some((Change::To, *factor)),
            Filler::Change(change, value) => Some((*change, *value)),
            _ => None,
        });
        let roles = [("", None), ("twice", Some(2.0)), ("thrice", Some(3.0)), ("half", Some(0.5))];
        let role = roles.into_iter().find(|(role, _)| !clause.objects(role).is_empty());
        let (role, fixed) = role.unwrap_or(("", None));
        let grows = clause.act != Act::Shrink;
        let factor = match (stated, fixed) {
            (_, Some(fixed)) => fixed,
            (Some((Change::To, factor)), _) => factor,
            (Some((Change::Part, part)), _) => {
                if grows {
                    1.0 + part
                } else {
                    1.0 - part
                }
            }
            (Some((Change::Factor, factor)), _) => {
                if grows {
                    factor
                } else {
                    1.0 / factor
                }
            }
            (None, None) => {
                if grows {
                    BIGGER
                } else {
                    1.0 / BIGGER
                }
            }
        };
        if !(0.5..=2.0).contains(&factor) {
            return self.refuse(Reason::Factor(factor));
        }
        let targets = self.targets(clause.objects(role))?;
        for target in &targets {
            self.push(EditOperation::Resize { target: target.phrase.clone(), factor });
        }
        self.now_about(targets, Changes::Size);
        Ok(())
    }

    pub fn recolor(&mut self, clause: &Clause) -> Outcome<()> {
        let Some(appearance) = clause.appearance().cloned() else { return self.refuse(Reason::Empty) };
        // "make the vase larger and made of glass"
        let it = [self.topic_phrase()];
        let phrases = clause.objects("");
        let targets = self.targets(if phrases.is_empty() { it.as_slice() } else { phrases })?;
        for target in &targets {
            let (color, material) = (appearance.color.clone(), appearance.material.clone());
            let operation = if self.is_table_phrase(&target.phrase) {
                EditOperation::RestyleTable { material, color }
            } else {
                EditOperation::Recolor { target: target.phrase.clone(), color, material }
            };
            self.push(operation);
        }
        self.now_about(targets, Changes::Appearance);
        Ok(())
    }

    pub fn rename(&mut self, clause: &Clause) -> Outcome<()> {
        let label = clause.fillers.iter().find_map(|(_, filler)| match filler {
            Filler::Label(label) => Some(label.clone()),
            _ => None,
        });
        let Some(label) = label else { return self.refuse(Reason::Empty) };
        let targets = self.targets(clause.objects(""))?;
        for target in &targets {
            self.push(EditOperation::Relabel { target: target.phrase.clone(), label: label.clone() });
        }
        self.now_about(targets, Changes::Label);
        Ok(())
    }

    pub fn stack(&mut self, clause: &Clause) -> Outcome<()> {
        let mut above = self.targets(clause.objects(""))?;
        above.extend(self.targets(clause.objects("top"))?);
        // "the green cubes on the red ones"
        for target in above.iter().filter(|target| !target.is_pronoun) {
            self.discourse.mention(&target.noun, &target.phrase, false);
        }
        let below = self.targets(clause.objects("below"))?;
        // Several on several are stacks side by side: each gets one of those below.
        if let ([bottom], [top]) = (below.as_slice(), above.as_slice())
            && bottom.is_plural
            && top.is_plural
        {
            let place = EditPlace::related(RelationKind::On, bottom.phrase.clone());
            self.push(EditOperation::Move { target: top.phrase.clone(), place });
        } else {
            let targets = below.iter().chain(&above).map(|target| target.phrase.clone()).collect();
            self.push(EditOperation::Stack { targets });
        }
        self.now_about(above, Changes::Place);
        Ok(())
    }

    pub fn arrange(&mut self, clause: &Clause) -> Outcome<()> {
        let sort_by = clause.fillers.iter().find_map(|(_, filler)| match filler {
            Filler::Key(SortKey::Size) => Some(SortedBy::Size),
            Filler::Key(SortKey::Height) => Some(SortedBy::Height),
            Filler::Key(SortKey::Color) => Some(SortedBy::Color),
            Filler::Key(SortKey::Kind) => Some(SortedBy::Kind),
            _ => None,
        });
        let sort_by = sort_by.or((clause.act == Act::Sort).then_some(SortedBy::Size));
        let place = match clause.place().map(|place| self.destination(place, false)).transpose()? {
            None | Some(Destination::Anywhere) => None,
            Some(Destination::Place(place)) if place.offset_m.is_none() => Some(place),
            Some(_) => {
                return self
                    .refuse(Reason::NotUnderstood("say along which edge of the table, or leave it out"));
            }
        };
        let beside = place.as_ref().and_then(|place| place.relation);
        let along_side = matches!(beside, Some(RelationKind::FromLeftEdge | RelationKind::FromRightEdge));
        let parallel = clause.objects("parallel").first().map(|edge| self.chart.words(edge.tokens.clone()));
        let in_depth = clause.act == Act::LineUpInDepth
            || along_side
            || parallel
                .is_some_and(|edge| edge.contains("left") || edge.contains("right") || edge.contains("side"));
        let as_ = if in_depth { ArrangedAs::Column } else { ArrangedAs::Row };
        let targets = self.targets(clause.objects(""))?;
        let phrases: Vec<String> = targets.iter().map(|target| target.phrase.clone()).collect();
        self.push(EditOperation::Arrange { targets: phrases, arrangement: as_, sort_by, place });
        self.now_about(targets, Changes::Place);
        Ok(())
    }
}

/// The yaw of a front that points to a side; 0 faces the front edge.
fn yaw_rad(heading: Heading) -> f64 {
    match heading {
        Heading::Front => 0.0,
        Heading::Back => PI,
        Heading::Left => -FRAC_PI_2,
        Heading::Right => FRAC_PI_2,
    }
}
