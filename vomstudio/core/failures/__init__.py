"""What the program does about its own mistakes: they are logged, shown and put into a report."""
