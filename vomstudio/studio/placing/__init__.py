"""Placement of models in World by observations or a reference model, with its errors."""
