"""Running things without freezing: worker processes, events. No Qt."""
