"""Surface analysis of a patch: deviations from its plane, roughness and profiles."""
