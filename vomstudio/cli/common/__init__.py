"""What every command of the command line shares: its words, its output, its first word."""
