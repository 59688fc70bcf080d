"""Tool that shares the panel of the control points, since both place the model together."""

SHARES = "control"
