"""Results of a finished reconstruction, read back for inspection."""
