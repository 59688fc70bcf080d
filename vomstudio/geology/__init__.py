"""Structural geology: orientations, notation, statistics, folds, faults and verdicts."""
