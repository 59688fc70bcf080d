"""What the user owns: frozen records, edits, history, session, selection."""
