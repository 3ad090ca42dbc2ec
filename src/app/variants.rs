//! The check of an order of variants: several scenes, made from a finished one by operations that seeds draw.

use super::App;
use super::edit_scene::ParentBundle;
use super::submission::{Submission, draw_seed};
use super::terms::Terms;
use crate::problem::{FieldError, Problem};
use runtime::seed::child_seed;
use scene::request::MAX_SEED;
use scene::variant::MAX_VARIANTS;
use scene::{Input, Randomize, Violation};

/// An order of variants, not checked.
#[derive(Clone, Debug, Default)]
pub struct VariantsOrder {
    pub count: u32,
    /// Differences between variants; everything where it is absent.
    pub randomize: Option<Randomize>,
    pub terms: Terms,
}

/// A request for variants that is valid.
pub struct Variants {
    /// Seed from which the seed of every variant is drawn.
    pub seed: u64,
    pub randomize: Randomize,
    /// One per variant, in order.
    pub submissions: Vec<Submission>,
}

impl App {
    /// Checks an order of variants of the parent; the results may be enqueued, once they have the parent's row.
    ///
    /// # Errors
    ///
    /// A [`Problem`] with every violation of the order.
    pub fn check_variants(&self, order: VariantsOrder, parent: &ParentBundle) -> Result<Variants, Problem> {
        let VariantsOrder { count, randomize, terms } = order;
        let mut errors = terms.errors();
        if !(1..=MAX_VARIANTS).contains(&count) {
            errors.push(FieldError::new("/count", format!("must be from 1 to {MAX_VARIANTS}")));
        }
        let randomize = randomize.unwrap_or_default();
        for Violation { pointer, detail } in randomize.violations() {
            errors.push(FieldError::new(format!("/randomize{pointer}"), detail));
        }
        if !errors.is_empty() {
            return Err(Problem::invalid(errors));
        }
        let randomize = randomize.or_usual();
        let seed = terms.seed.unwrap_or_else(draw_seed);
        let of_variant = |index: u32| {
            let seed = Some(child_seed(seed, &format!("variant {index}")) & MAX_SEED);
            let (parent, bundle_sha256) = (parent.id.clone(), parent.digest.to_string());
            self.submission(
                Terms { seed, ..terms.clone() },
                Input::Variant { parent, bundle_sha256, randomize },
            )
        };
        let submissions = (0..count).map(of_variant).collect::<Result<_, _>>()?;
        Ok(Variants { seed, randomize, submissions })
    }
}
