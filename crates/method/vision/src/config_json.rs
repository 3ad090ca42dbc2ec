//! Checks of the numbers in a vision transformer's `config.json`, before any of them sizes a tensor.

/// A key, the number found, and the smallest and largest that are accepted.
pub(crate) type Range<'a> = (&'a str, usize, usize, usize);

/// Reason why a number is unfit: outside its range, or heads that do not divide the width of a token.
pub(crate) fn unfit_sizes(ranges: &[Range], hidden_size: usize, heads: usize) -> Option<String> {
    for (key, found, low, high) in ranges {
        if !(low..=high).contains(&found) {
            return Some(format!("{key} is {found}, outside {low} to {high}"));
        }
    }
    let is_shared = hidden_size.is_multiple_of(heads);
    (!is_shared)
        .then(|| format!("hidden_size = {hidden_size} cannot be shared by num_attention_heads = {heads}"))
}

/// Reason why `layer_norm_eps` is unfit.
pub(crate) fn unfit_epsilon(layer_norm_eps: f64) -> Option<String> {
    let is_sound = (0.0..1.0).contains(&layer_norm_eps);
    (!is_sound).then(|| format!("layer_norm_eps is {layer_norm_eps}, outside 0 to 1"))
}
