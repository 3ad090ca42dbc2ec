"""tabletopgen side by side with NVIDIA's scene-synthesizer on what both can do: ten objects are placed on a table."""

DEPENDS_ON = (
    "crates/method/editing", "crates/models/embedded/src/layout", "crates/models/embedded/src/layout.rs",
    "crates/base/geometry", "crates/method/physics", "src/pipeline/edit", "src/pipeline/edit.rs",
    "tests/judges/layouts.py",
)
