"""VTK scene: models, features, cameras, picking."""
