"""VTK scene with models, features, cameras and picking."""
