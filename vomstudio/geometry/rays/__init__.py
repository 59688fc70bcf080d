"""Rays against meshes and clouds."""
