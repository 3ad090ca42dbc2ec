"""tabletopgen side by side with NVIDIA's scene-synthesizer on what both can do: ten objects are placed on a table."""

DEPENDS_ON = (
    "crates/editing", "crates/embedded/src/layout", "crates/embedded/src/layout.rs", "crates/geometry",
    "crates/physics", "src/pipeline/edit", "src/pipeline/edit.rs", "tests/judges/layouts.py",
)
