"""Surface fields, and facets and traces proposed from the surface."""
