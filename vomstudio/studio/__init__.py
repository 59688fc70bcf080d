"""Application logic without a user interface: project, models, tools and jobs."""
