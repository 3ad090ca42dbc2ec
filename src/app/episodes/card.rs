//! The card of a dataset of demonstrations.

use crate::config::Resolved;
use demonstrations::Setup;
use episodes::card::DatasetCard;

/// What the card of a dataset states besides what is in it.
pub fn card(title: String, resolved: &Resolved, setup: &Setup) -> DatasetCard {
    DatasetCard {
        title,
        license: resolved.config.export.licence.clone(),
        versions: vec![("tabletopgen".to_owned(), env!("CARGO_PKG_VERSION").to_owned())],
        randomization: setup.randomization().table(),
        regeneration: "`tabletopgen regenerate-episode` makes one again in the bundle whose digest its record states, and the \
                       same order all of them, to the byte."
            .to_owned(),
        ..DatasetCard::default()
    }
}
