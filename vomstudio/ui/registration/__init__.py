"""One model by another: fitted to it, and held against it."""
