"""Build a relocatable Python with VOM Studio, as a Debian package and as a self-running image."""
