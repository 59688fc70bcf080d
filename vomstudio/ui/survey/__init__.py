"""Planning a survey, frames of a video, making a model."""
