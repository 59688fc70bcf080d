"""Presentation of models and features in the viewport."""
