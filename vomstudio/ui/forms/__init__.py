"""Parts of which panels and dialogs are put together: fields, and their copy as a command."""
