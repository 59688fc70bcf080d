"""Safe file access: atomic writing, backups, locks, and limits for untrusted files."""
