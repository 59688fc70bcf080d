"""Parts shared by all commands: arguments, output, and selection of the command."""
