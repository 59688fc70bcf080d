"""What points a plane or a line needs, and why there is none where they do not suffice."""

from __future__ import annotations

from vomstudio.words import to_translate

TOO_FEW = to_translate("needs at least 3 points; pick more")
NOT_FINITE = to_translate(
    "has coordinates that are not finite numbers, or beyond 1e150; remove those points"
)
IDENTICAL = to_translate("all points are at the same place; pick points farther apart")
COLLINEAR = to_translate(
    "all points lie on one straight line, which many planes contain; pick one beside it"
)
PARALLEL = to_translate(
    "the plane is parallel to the {axis} axis, so it cannot be found by "
    "regression of {axis}; use another axis, or the moment of inertia (pca)"
)

# Squares of these stay in range.
LARGEST = 1e150
# Distances below this many roundings of the largest coordinate are rounding, not shape.
ROUNDINGS = 4.0
# Points repeated exactly are looked for in short traces only, where one of them matters.
COUNT_REPEATS_UP_TO = 16
