"""Running things without freezing: worker processes, typed jobs and events. No Qt."""
