"""What a worker reads of a reconstruction for the window: small things as values, large as arrays
in files."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from vomstudio.progress import Progress


def inspect_alignment(args: Mapping[str, Any], progress: Progress) -> dict[str, Any]:
    """Photos, pairs and cameras of the reconstruction in `out`; see `inspection.overview`."""
    from vomstudio.photogrammetry.inspect.inspection import overview

    return overview(Path(args["out"]))


def inspect_pair(args: Mapping[str, Any], progress: Progress) -> dict[str, Any]:
    """The features and matches of photos `a` and `b`, as arrays in the file `into`."""
    import numpy as np

    from vomstudio.photogrammetry.inspect.inspection import pair

    found = pair(Path(args["out"]), args["a"], args["b"])
    np.savez(
        args["into"],
        left=found.left,
        right=found.right,
        matches=found.matches,
        refused=found.refused,
    )
    return {}


def inspect_residuals(args: Mapping[str, Any], progress: Progress) -> dict[str, Any]:
    """The residual vectors of the photo `name`, as arrays in the file `into`."""
    import numpy as np

    from vomstudio.photogrammetry.inspect.inspection import residual_vectors

    pixels, vectors = residual_vectors(Path(args["out"]), args["name"])
    np.savez(args["into"], pixels=pixels, vectors=vectors)
    return {}


def inspect_depths(args: Mapping[str, Any], progress: Progress) -> dict[str, Any]:
    """The depth map of the photo `name` as pictures in the file `into`."""
    import numpy as np

    from vomstudio.photogrammetry.inspect.inspection import depth_pictures

    made = depth_pictures(Path(args["out"]), args["name"])
    np.savez(
        args["into"],
        photo=made.photo,
        depth=made.depth,
        colors=made.colors,
        confidence=made.confidence,
        normals=made.normals,
    )
    return {
        "low": made.low,
        "high": made.high,
        "coverage": made.coverage,
    }


TASKS = {
    "inspect_alignment": inspect_alignment,
    "inspect_pair": inspect_pair,
    "inspect_residuals": inspect_residuals,
    "inspect_depths": inspect_depths,
}
