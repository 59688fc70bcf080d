"""Journal of a project: rows, database, replay and migration."""
