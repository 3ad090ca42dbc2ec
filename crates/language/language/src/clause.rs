//! Clauses: the constructions that fit at an index, with what fills their roles.

use crate::appearance::Appearance;
use crate::chart::{Chart, Span};
use crate::construction::{Act, Construction, Means, Part, RoleKind};
use crate::lexicon::{begins_with, lexicon};
use crate::measures::{Change, angles_at, changes_at, factors_at};
use crate::nominal::NounPhrase;
use crate::place::Place;

/// Side that a front points to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Heading {
    Front,
    Back,
    Left,
    Right,
}

/// Property that objects are sorted by.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SortKey {
    Size,
    Color,
    Kind,
    Height,
}

/// Content of a role.
#[derive(Clone, Debug, PartialEq)]
pub enum Filler {
    Objects(Vec<NounPhrase>),
    Place(Place),
    Angle(f64),
    Factor(f64),
    Change(Change, f64),
    Appearance(Appearance),
    Label(String),
    Heading(Heading),
    Key(SortKey),
    /// Words up to the end of the clause.
    Rest,
}

impl Filler {
    /// The noun phrases in it.
    pub fn phrases(&self) -> &[NounPhrase] {
        match self {
            Self::Objects(phrases) => phrases,
            Self::Place(place) => place.phrases(),
            _ => &[],
        }
    }
}

/// A clause that was read.
#[derive(Clone, Debug, PartialEq)]
pub struct Clause {
    pub act: Act,
    /// Tokens.
    pub start: usize,
    pub end: usize,
    /// Whether its verb is that of the clause before.
    pub is_elliptic: bool,
    /// Indices of its verbs.
    pub verbs: Vec<usize>,
    /// Names of roles with what fills them; the name of the main one is empty.
    pub fillers: Vec<(String, Filler)>,
    /// Values that its words state.
    pub means: Means,
}

impl Clause {
    /// The objects of a role; empty where it has none.
    pub fn objects(&self, role: &str) -> &[NounPhrase] {
        let found = self.fillers.iter().find_map(|(name, filler)| match filler {
            Filler::Objects(objects) if name == role => Some(objects.as_slice()),
            _ => None,
        });
        found.unwrap_or_default()
    }

    /// The place that the objects go to; the one that they come from, if nothing else is said.
    pub fn place(&self) -> Option<&Place> {
        let places = self.fillers.iter().filter_map(|(_, filler)| match filler {
            Filler::Place(place) => Some(place),
            _ => None,
        });
        let goal = places.clone().find(|place| !place.is_source());
        goal.or_else(|| places.clone().next())
    }

    pub fn appearance(&self) -> Option<&Appearance> {
        self.fillers.iter().find_map(|(_, filler)| match filler {
            Filler::Appearance(appearance) => Some(appearance),
            _ => None,
        })
    }
}

/// A partial match.
#[derive(Clone)]
struct Match {
    end: usize,
    cost: f64,
    verbs: Vec<usize>,
    fillers: Vec<(String, Filler)>,
}

/// Matches of one construction that are followed at a time.
const MAX_MATCHES: usize = 64;

impl Chart<'_> {
    /// The readings of a construction at an index.
    pub(crate) fn clauses_at(&self, at: usize, construction: &Construction) -> Vec<Span<Clause>> {
        let start = Match { end: at, cost: construction.cost, verbs: Vec::new(), fillers: Vec::new() };
        let matches = self.followed(vec![start], &construction.parts);
        let clause = |found: Match| Span {
            end: found.end,
            cost: found.cost,
            value: Clause {
                act: construction.act,
                start: at,
                end: found.end,
                is_elliptic: !construction.repeats.is_empty(),
                verbs: found.verbs,
                fillers: found.fillers,
                means: construction.means,
            },
        };
        matches.into_iter().map(clause).collect()
    }

    fn followed(&self, mut matches: Vec<Match>, parts: &[Part]) -> Vec<Match> {
        for part in parts {
            let mut next: Vec<Match> = Vec::new();
            for found in &matches {
                next.extend(self.after(found, part));
            }
            next.sort_by(|a, b| a.cost.total_cmp(&b.cost));
            next.truncate(MAX_MATCHES);
            matches = next;
            if matches.is_empty() {
                break;
            }
        }
        matches
    }

    fn after(&self, found: &Match, part: &Part) -> Vec<Match> {
        let at = found.end;
        let moved = |length: usize| Match { end: at + length, ..found.clone() };
        match part {
            Part::Words(phrases) => {
                let here = phrases.iter().filter(|phrase| begins_with(&self.tokens, at, phrase));
                here.map(|phrase| moved(phrase.len())).collect()
            }
            Part::Class(class) => self.lengths(class, at).into_iter().map(moved).collect(),
            Part::Verb(class, form) => {
                let mut found = found.clone();
                found.verbs.push(at);
                let lengths = lexicon().verb_lengths(class, *form, &self.tokens, at);
                lengths.into_iter().map(|length| Match { end: at + length, ..found.clone() }).collect()
            }
            Part::Optional(parts) => {
                let mut matches = vec![found.clone()];
                matches.extend(self.followed(vec![found.clone()], parts));
                matches
            }
            Part::Any(parts) => parts.iter().flat_map(|part| self.after(found, part)).collect(),
            Part::Role(kind, name) => {
                let with = |end: usize, cost: f64, filler: Filler| {
                    let mut fillers = found.fillers.clone();
                    fillers.push((name.clone(), filler));
                    Match { end, cost: found.cost + cost, verbs: found.verbs.clone(), fillers }
                };
                self.fillers_at(at, *kind)
                    .into_iter()
                    .map(|span| with(span.end, span.cost, span.value))
                    .collect()
            }
        }
    }

    fn fillers_at(&self, at: usize, kind: RoleKind) -> Vec<Span<Filler>> {
        fn wrapped<T>(spans: Vec<Span<T>>, wrap: impl Fn(T) -> Filler) -> Vec<Span<Filler>> {
            spans
                .into_iter()
                .map(|span| Span { end: span.end, cost: span.cost, value: wrap(span.value) })
                .collect()
        }
        match kind {
            RoleKind::Object => wrapped(self.lists_at(at).to_vec(), Filler::Objects),
            RoleKind::Place | RoleKind::Source => {
                let is_fit = |span: &&Span<Place>| span.value.is_source() == (kind == RoleKind::Source);
                wrapped(self.places_at(at).iter().filter(is_fit).cloned().collect(), Filler::Place)
            }
            RoleKind::Angle => wrapped(angles_at(&self.tokens, at), Filler::Angle),
            RoleKind::Factor => wrapped(factors_at(&self.tokens, at), Filler::Factor),
            RoleKind::Change => {
                wrapped(changes_at(&self.tokens, at), |(change, value)| Filler::Change(change, value))
            }
            RoleKind::Appearance => wrapped(self.appearances_at(at), Filler::Appearance),
            RoleKind::Label => wrapped(self.labels_at(at), Filler::Label),
            RoleKind::Heading => wrapped(self.headings_at(at), Filler::Heading),
            RoleKind::Key => wrapped(self.keys_at(at), Filler::Key),
            RoleKind::Rest => {
                let end = (at..self.tokens.len()).find(|&end| matches!(self.word(end), "." | "," | "then"));
                vec![Span { end: end.unwrap_or(self.tokens.len()), cost: 0.0, value: Filler::Rest }]
            }
        }
    }

    /// A quoted text, or one to four words without an article.
    fn labels_at(&self, at: usize) -> Vec<Span<String>> {
        if let Some(token) = self.tokens.get(at).filter(|token| token.is_quoted) {
            return vec![Span { end: at + 1, cost: 0.0, value: token.word.clone() }];
        }
        let article = usize::from(matches!(self.word(at), "a" | "an" | "the"));
        let start = at + article;
        let is_word = |at: &usize| !lexicon().is_function_word(self.word(*at)) && !self.word(*at).is_empty();
        let count = (start..(start + 4).min(self.tokens.len())).take_while(is_word).count();
        let label = |length: usize| Span {
            end: start + length,
            cost: 0.2 - 0.05 * length as f64,
            value: self.written(start..start + length),
        };
        (1..=count).map(label).collect()
    }

    /// Sides that a front points to: "the viewer", "the left edge".
    fn headings_at(&self, at: usize) -> Vec<Span<Heading>> {
        const HEADINGS: &[(Heading, &[&str])] = &[
            (
                Heading::Front,
                &[
                    "the front",
                    "the viewer",
                    "the camera",
                    "me",
                    "us",
                    "forward",
                    "forwards",
                    "front",
                    "the front edge",
                    "the front of the table",
                    "the user",
                ],
            ),
            (
                Heading::Back,
                &[
                    "the back",
                    "away from me",
                    "away from the viewer",
                    "away from us",
                    "away",
                    "backward",
                    "backwards",
                    "the back edge",
                    "the wall",
                    "the back of the table",
                ],
            ),
            (Heading::Left, &["the left", "left", "the left edge", "the left side"]),
            (Heading::Right, &["the right", "right", "the right edge", "the right side"]),
        ];
        let mut found = Vec::new();
        for (heading, patterns) in HEADINGS {
            for pattern in *patterns {
                let words = crate::lexicon::split(pattern);
                if begins_with(&self.tokens, at, &words) {
                    found.push(Span { end: at + words.len(), cost: -0.2, value: *heading });
                }
            }
        }
        found
    }

    fn keys_at(&self, at: usize) -> Vec<Span<SortKey>> {
        let key = match self.word(at) {
            "size" | "sizes" => SortKey::Size,
            "color" | "colour" | "colors" | "colours" => SortKey::Color,
            "kind" | "type" | "category" | "kinds" | "sort" => SortKey::Kind,
            "height" | "heights" => SortKey::Height,
            _ => return Vec::new(),
        };
        vec![Span { end: at + 1, cost: 0.0, value: key }]
    }
}
