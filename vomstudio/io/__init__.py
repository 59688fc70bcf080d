"""Input and output of files, without dialogs and global state."""
