"""View direction and saved views."""
