"""Fields, facets and traces proposed from the surface."""
