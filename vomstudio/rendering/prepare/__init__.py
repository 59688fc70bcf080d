"""Preparation of models for the scene in worker threads."""
