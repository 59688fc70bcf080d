"""Survey planning, checks of photos (light, blur, enlargement), and frames of videos."""
