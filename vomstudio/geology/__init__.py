"""Words and conventions: orientation, notation, statistics, folds, quality."""
