"""Survey planning, checks of photos (light, blur, enlargement, overlap), and frames of videos."""
