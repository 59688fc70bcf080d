"""Ground control formats; each module defines CONTROL_FORMAT."""
