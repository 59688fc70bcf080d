"""Survey planning, checks of photos (light, blur, overlap), and frames of videos."""
