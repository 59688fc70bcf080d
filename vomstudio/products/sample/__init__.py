"""The sample outcrop measured and held against its truth."""
