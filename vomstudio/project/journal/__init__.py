"""The journal of a project: rows, database, replay, migration."""
