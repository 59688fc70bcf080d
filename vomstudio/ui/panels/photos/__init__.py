"""Photo sets, opened photos, masks and marks."""
