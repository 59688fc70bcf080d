"""Models (meshes and point clouds): readers, writers, cache and copies."""
