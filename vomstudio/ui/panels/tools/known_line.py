"""Tool for known lines, which uses the panel of the control points."""

SHARES = "control"
