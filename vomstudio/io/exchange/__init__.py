"""Export of files in the formats of other programs for structural geology."""
