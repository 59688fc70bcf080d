"""Common parts of all commands: arguments, output, selection of the command."""
