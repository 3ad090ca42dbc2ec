"""A thousand scenes in one batch, and the dataset that is frozen of them."""
