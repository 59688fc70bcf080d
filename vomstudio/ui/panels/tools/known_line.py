"""Share the panel of the control points: both place the model together."""

SHARES = "control"
