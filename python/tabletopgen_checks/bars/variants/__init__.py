"""Variants: what they must keep, and how much they differ."""

DEPENDS_ON = (
    "crates/base/catalog", "crates/method/editing", "crates/method/physics", "crates/base/scene/src/variant.rs",
    "python/tabletopgen_checks/bars/variants", "src/pipeline/edit", "src/pipeline/edit.rs",
)
