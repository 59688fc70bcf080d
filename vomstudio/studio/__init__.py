"""The application without a screen: background work and the thread that owns it. No Qt."""
