"""Results of a finished reconstruction, for inspection."""
