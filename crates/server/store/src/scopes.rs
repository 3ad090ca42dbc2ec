//! Scopes: what a key may be used for. None of them includes another one.

use std::collections::BTreeSet;
use std::fmt;

use serde::{Deserialize, Serialize};

/// A kind of use.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Scope {
    /// See and download.
    Read,
    /// Order work.
    Submit,
    /// Remove results, and change what is said about them.
    Delete,
    /// Cancel, repeat and verify work; read metrics.
    Operate,
    /// Manage keys and webhooks, and read the record of changes. Its owner can make a key with any scope.
    Admin,
}

impl Scope {
    pub const ALL: [Self; 5] = [Self::Read, Self::Submit, Self::Delete, Self::Operate, Self::Admin];

    pub fn as_str(self) -> &'static str {
        match self {
            Self::Read => "read",
            Self::Submit => "submit",
            Self::Delete => "delete",
            Self::Operate => "operate",
            Self::Admin => "admin",
        }
    }

    /// Inverse of [`Self::as_str`].
    pub fn parse(text: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|scope| scope.as_str() == text)
    }
}

impl fmt::Display for Scope {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.as_str())
    }
}

/// The text is no list of scopes.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum InvalidScope {
    #[error("{0:?} is no scope; scopes are read, submit, delete, operate and admin")]
    Word(String),
    #[error("must not have more scopes than there are")]
    TooMany,
}

/// Scopes; serialized as a list of words, at most as many as there are scopes.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "Vec<String>", into = "Vec<&'static str>")]
pub struct ScopeSet(BTreeSet<Scope>);

impl ScopeSet {
    pub fn all() -> Self {
        Self(Scope::ALL.into())
    }

    pub fn contains(&self, scope: Scope) -> bool {
        self.0.contains(&scope)
    }

    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Words with commas or spaces between them.
    ///
    /// # Errors
    ///
    /// [`InvalidScope`] for any other word.
    pub fn parse(text: &str) -> Result<Self, InvalidScope> {
        words(text)
            .map(|word| Scope::parse(word).ok_or_else(|| InvalidScope::Word(word.to_owned())))
            .collect()
    }

    /// The scopes among words of another system, such as the groups of an identity provider.
    pub fn among(text: &str) -> Self {
        words(text).filter_map(Scope::parse).collect()
    }
}

fn words(text: &str) -> impl Iterator<Item = &str> {
    text.split([',', ' ']).filter(|word| !word.is_empty())
}

impl FromIterator<Scope> for ScopeSet {
    fn from_iter<I: IntoIterator<Item = Scope>>(scopes: I) -> Self {
        Self(scopes.into_iter().collect())
    }
}

impl fmt::Display for ScopeSet {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let words: Vec<&str> = self.0.iter().map(|scope| scope.as_str()).collect();
        f.write_str(&words.join(" "))
    }
}

impl TryFrom<Vec<String>> for ScopeSet {
    type Error = InvalidScope;

    fn try_from(words: Vec<String>) -> Result<Self, InvalidScope> {
        if words.len() > Scope::ALL.len() {
            return Err(InvalidScope::TooMany);
        }
        words.into_iter().map(|word| Scope::parse(&word).ok_or(InvalidScope::Word(word))).collect()
    }
}

impl From<ScopeSet> for Vec<&'static str> {
    fn from(scopes: ScopeSet) -> Self {
        scopes.0.into_iter().map(Scope::as_str).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scopes_are_words() {
        let set = ScopeSet::parse("submit,read read").expect("scopes");
        assert_eq!(set.to_string(), "read submit");
        assert_eq!(serde_json::to_string(&set).expect("serializes"), r#"["read","submit"]"#);
        assert_eq!(serde_json::from_str::<ScopeSet>(r#"["submit","read"]"#).expect("reads"), set);
        assert!(set.contains(Scope::Read) && !set.contains(Scope::Admin));
        let refused = ScopeSet::parse("read, all").expect_err("is refused").to_string();
        assert!(refused.contains("\"all\"") && refused.contains("operate"), "{refused}");
        assert_eq!(ScopeSet::among("email admin,profile").to_string(), "admin");
        assert!(ScopeSet::among("Admin openid").is_empty());
        assert_eq!(ScopeSet::parse(&ScopeSet::all().to_string()), Ok(ScopeSet::all()));
    }
}
