//! Commands that turn objects about the vertical axis.

use std::f64::consts::PI;

use super::Reason;
use super::cursor::{Cursor, Outcome};
use super::discourse::Target;
use super::removals::is_table;
use scene::EditOperation;

impl Cursor {
    /// "by 90 degrees clockwise", "around", "toward the plate" after what is turned.
    pub fn rotate(&mut self) -> Outcome<()> {
        let start = self.at;
        if let Some(at) = self.complement_index(start) {
            return self.become_at(at);
        }
        let facing = ["toward", "towards", "to face", "so that it faces", "so it faces", "to point at", "to"];
        let stops = |cursor: &Self, index: usize| {
            cursor.angle_at(index).is_some()
                || (cursor.turn_direction_at(index).is_some() && !cursor.is_at(index + 3, "of"))
                || cursor
                    .length_of_any(index, &["by", "around", "over", "upside down", "on its side", "into"])
                    .is_some()
                || cursor.length_of_any(index, &facing).is_some()
        };
        let targets = self.targets(&stops)?;
        if self.length_of_any(self.at, &["over", "upside down", "on its side"]).is_some() {
            return self.not_understood(start, "objects turn about the vertical axis only");
        }
        if self.is_at(self.at, "into") {
            self.at = start;
            return self.change_to();
        }
        let (mut angle_rad, mut sign, mut around) = (None, None, false);
        loop {
            if self.is_at(self.at, "by")
                && self.number_at(self.at + 1).is_some()
                && self.angle_at(self.at + 1).is_none()
            {
                let (degrees, length) = self.number_at(self.at + 1).unwrap_or_default();
                self.at += 1 + length;
                angle_rad = Some(degrees.to_radians());
            } else if let Some((direction, length)) = self.turn_direction_at(self.at) {
                self.at += length;
                sign = Some(direction);
            } else if let Some(angle) = self.angle_at(self.at) {
                self.at += angle.length;
                angle_rad = Some(angle.rad);
            } else if self.take("around") {
                around = true;
            } else if !(self.is_at(self.at, "by") && self.angle_at(self.at + 1).is_some() && self.take("by"))
            {
                break;
            }
        }
        if let Some(angle) = self.is_at(self.at, "to").then(|| self.angle_at(self.at + 1)).flatten() {
            self.at += 1 + angle.length;
            let to_rad = Some(angle.rad);
            return self.turned(&targets, start, |target| EditOperation::Rotate {
                target,
                by_rad: None,
                to_rad,
                facing: None,
            });
        }
        if angle_rad.is_none() && sign.is_none() && !around {
            if self.take_any(&facing[..6]) {
                return self.faced(&targets, start);
            }
            return Err(self.error(start, self.at, Reason::HowFarTurned));
        }
        let angle_rad = angle_rad.or((around && sign.is_none()).then_some(PI));
        let Some(angle_rad) = angle_rad else {
            return Err(self.error(start, self.at, Reason::HowFarTurned));
        };
        let by_rad = Some(sign.unwrap_or(1.0) * angle_rad);
        self.turned(&targets, start, |target| EditOperation::Rotate {
            target,
            by_rad,
            to_rad: None,
            facing: None,
        })
    }

    /// "face X to Y", "make X face Y".
    pub fn face(&mut self) -> Outcome<()> {
        let start = self.at;
        let toward = ["toward", "towards", "to face", "to", "at"];
        let stops = |cursor: &Self, index: usize| {
            cursor.length_of_any(index, &toward).is_some()
                || cursor.heading_at(index).is_some_and(|(_, length)| cursor.is_boundary(index + length))
        };
        let targets = self.targets(&stops)?;
        let _ = self.take_any(&toward);
        self.faced(&targets, start)
    }

    /// Reads the object or direction that the targets shall face.
    pub fn faced(&mut self, targets: &[Target], start: usize) -> Outcome<()> {
        if let Some((yaw_rad, length)) = self.heading_at(self.at)
            && self.is_boundary(self.at + length)
        {
            self.at += length;
            let to_rad = Some(yaw_rad);
            return self.turned(targets, start, |target| EditOperation::Rotate {
                target,
                by_rad: None,
                to_rad,
                facing: None,
            });
        }
        let from = self.at;
        if self.is_at(from, "each other") {
            let [first, second] = targets else {
                return Err(self.error(start, from + 2, Reason::SeveralLandmarks));
            };
            self.at += 2;
            for (target, other) in [(first, second), (second, first)] {
                let facing = Some(other.phrase.clone());
                let target = target.phrase.clone();
                self.operations.push(EditOperation::Rotate { target, by_rad: None, to_rad: None, facing });
            }
            return Ok(());
        }
        let end = self.phrase_end(from, &|_| false);
        if end == from {
            return self.not_understood(start, "say what it faces: the plate, the front, the left");
        }
        if matches!(self.word(from), "it" | "them" | "each" | "every" | "all" | "a" | "an") {
            return Err(self.error(from, end, Reason::SeveralLandmarks));
        }
        self.at = end;
        let facing = self.target_text(from, end);
        self.turned(targets, start, |target| EditOperation::Rotate {
            target,
            by_rad: None,
            to_rad: None,
            facing: Some(facing.clone()),
        })
    }

    pub fn turned(
        &mut self,
        targets: &[Target],
        start: usize,
        operation: impl Fn(String) -> EditOperation,
    ) -> Outcome<()> {
        let first = self.operations.len();
        for target in targets {
            if is_table(&target.phrase) {
                return Err(self.error(start, self.at, Reason::Table));
            }
            self.change(target, operation(target.phrase.clone()), start)?;
        }
        self.now_about(targets, first);
        Ok(())
    }
}
