"""The promises of the README, each measured in full and written to docs/results/."""
