"""Application without a screen: open project and models, tools, jobs, background work."""
