"""Projects: records, kinds of features, edits, history, journal, import and export."""
