"""The outcrop in its photos."""
