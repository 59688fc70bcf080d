"""The scene in VTK: models, features, cameras, picking."""
