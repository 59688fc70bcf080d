"""Output of a model with computed fields."""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING

from vomstudio.cli.common.arguments import progress_reporter
from vomstudio.core.findings import Finding

if TYPE_CHECKING:
    from vomstudio.core.arrays import GenericArray
    from vomstudio.studio.world_models import WorldModel


def write_labelled_model(
    args: argparse.Namespace,
    model: WorldModel,
    fields: Mapping[str, GenericArray],
    target: str | None = None,
) -> list[Finding]:
    """Write the model with the fields, in the World frame, to `target` or `args.labels`.

    Returns the findings. Raises TargetError.
    """
    from vomstudio.io.models.model_copy import companions
    from vomstudio.io.models.writing import write_model

    return write_model(
        replace(model.data, fields={**model.data.fields, **fields}),
        model.crs,
        args.labels if target is None else target,
        force=args.force,
        inputs=[model.loaded.path, *companions(model.loaded.path)],
        progress=progress_reporter(args),
        registration=model.registration_in_world,
    )
