"""Mesh of the cloud, its texture atlas and its texture."""
