"""The outside world, in and out. No dialogs, no globals."""
