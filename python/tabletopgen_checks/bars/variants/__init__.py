"""Variants: what they must keep, and how much they differ."""

DEPENDS_ON = (
    "crates/catalog", "crates/editing", "crates/physics", "crates/scene/src/variant.rs",
    "python/tabletopgen_checks/bars/variants", "src/pipeline/edit", "src/pipeline/edit.rs",
)
