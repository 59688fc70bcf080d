"""Shapes of folds from their poles, and verdicts on views along their axes."""
