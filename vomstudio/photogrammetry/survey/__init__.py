"""What can be said of photos before any model is made of them: plans, checks, frames of a video."""
