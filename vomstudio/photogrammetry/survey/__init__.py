"""Survey planning, checks of photos before reconstruction, and frames of videos."""
