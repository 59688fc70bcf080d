"""What every stage stands on: COLMAP as a library, memory, settings, folders of stages."""
