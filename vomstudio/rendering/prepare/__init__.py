"""Models on their way to the scene, made beside the window: what the workers do and hand over."""
