//! Members of vague sets that the text names: "some fruit, such as two apples and a pear", "three tools: a hammer,
//! ...".

use super::{Link, Parser};
use crate::text_parser::account::Claimed;
use crate::text_parser::lexicon::Meaning;
use crate::text_parser::phrases::phrases;
use crate::text_parser::property::Property;

impl Parser<'_, '_> {
    /// Words that introduce the members of the set before them. Whether the rule applies.
    pub(super) fn examples(&mut self) -> bool {
        let Some(&set) = self.subject.last() else { return false };
        if !matches!(self.parsed.mentions[set].meanings.first(), Some(Meaning::Vague(_))) {
            return false;
        }
        let length = phrases().list.examples.longest_at(self.tokens, self.at);
        let colon = self.at.checked_sub(1).is_some_and(|before| self.is_colon(before));
        if length.is_none() && !colon || self.open_set == Some(set) {
            return false;
        }
        self.parsed.account.used(self.at..self.at + length.unwrap_or(0));
        self.at += length.unwrap_or(0);
        self.open_set = Some(set);
        length.is_some()
    }

    /// A member takes the place of the set: it has the relations and places of the set, which has no objects of its
    /// own.
    pub(super) fn join_open_set(&mut self, mention: usize) {
        let Some(set) = self.open_set.filter(|set| *set != mention) else { return };
        let Some(&Meaning::Vague(index)) = self.parsed.mentions[set].meanings.first() else { return };
        let members = &self.lexicon.themes.vague[index];
        let belongs = match self.parsed.mentions[mention].meanings.first() {
            Some(Meaning::Category(category)) => {
                let name = &self.lexicon.categories[*category].name;
                members.members.contains(name)
                    || members.by_family.values().any(|members| members.contains(name))
            }
            _ => false,
        };
        if !belongs {
            return;
        }
        let whole = self.parsed.mentions[set].clone();
        if whole.count != Some([0, 0]) {
            self.parsed.account.claims.retain(|claim| claim.meaning != Claimed::Object(set));
            self.claim_property(whole.tokens.clone(), Property::Kind, vec![mention]);
            self.parsed.mentions[set].count = Some([0, 0]);
        }
        let links: Vec<Link> = self.parsed.links.iter().filter(|link| link.from == set).copied().collect();
        for link in links {
            self.parsed.links.push(Link { from: mention, ..link });
        }
        self.parsed.mentions[mention].places.extend(whole.places);
        self.subject.retain(|&member| member != set);
    }
}
