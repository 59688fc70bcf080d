"""Figures, sheets and reports of measurements."""
