"""What folds are: the shapes of their poles, and the verdict on a view along their axis."""
