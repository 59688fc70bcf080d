"""What a finished reconstruction rests on, read back to be looked at."""
