"""tabletopgen side by side with NVIDIA's scene-synthesizer on what both can do: ten objects are placed on a table."""
