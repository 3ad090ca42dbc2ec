//! The card of a dataset of demonstrations.

use crate::config::Resolved;
use demonstrations::Setup;
use episodes::card::DatasetCard;

/// Properties that no randomization varies.
const ONE_OF_EACH: &str = "\
The robot's base stands at one place in all episodes of a task. Grasps come from one list for each task, the best that the \
arm can reach is taken, and mostly it is the same in all episodes: a policy that is trained on them knows no other.";

/// Statements of a dataset's card besides its content.
pub fn card(title: String, resolved: &Resolved, setup: &Setup) -> DatasetCard {
    DatasetCard {
        title,
        license: resolved.config.export.licence.clone(),
        versions: vec![("tabletopgen".to_owned(), env!("CARGO_PKG_VERSION").to_owned())],
        randomization: format!("{}\n{ONE_OF_EACH}", setup.randomization().table()),
        regeneration: "`tabletopgen regenerate-episode` makes one again in the bundle whose digest its record states, and the \
                       same order all of them, to the byte."
            .to_owned(),
        ..DatasetCard::default()
    }
}
