"""Numbers only: arrays, frames, plane fits and their errors, mesh and cloud holders."""
