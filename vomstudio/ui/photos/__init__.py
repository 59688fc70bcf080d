"""The photos of a survey: list, masks, marks."""
