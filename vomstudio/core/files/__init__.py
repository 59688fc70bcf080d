"""The disk: writing whole or not at all, putting aside what was there, one program at a time."""
