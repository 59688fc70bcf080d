"""Option `--curved` of `fit`: one curved bed through several traces."""

from __future__ import annotations

from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from vomstudio.cli.common import text_tables
from vomstudio.cli.common.error_context import name_input_in_errors
from vomstudio.core.words import tr

if TYPE_CHECKING:
    from vomstudio.io.text.tables import PointGroups


def fit_curved_bed(path: str, groups: PointGroups) -> dict[str, Any]:
    """Fit one curved bed to all traces for the option `--curved`. Raises GeometryError."""
    from vomstudio.geology.beds.curved import curved_bed

    with name_input_in_errors(path, "--curved"):
        fit = curved_bed([str(name) for name in groups.ids], groups.points, groups.offsets)
    return {
        "degree": fit.degree,
        "p": fit.p,
        "rms_m": fit.rms_m,
        "n": fit.n,
        "n_effective": fit.n_effective,
        "dips": [asdict(dip) for dip in fit.dips],
    }


def result_text(fit: dict[str, Any]) -> str:
    """Describe the fit of a curved bed, with its local dip at each trace."""
    if fit["p"] is None:
        text = tr("A single plane fits all traces.")
    else:
        text = tr(
            "The bed is curved (p {p} for a plane): a surface of degree {degree} fits it with RMS"
            " {rms} m.",
            p=text_tables.figures(fit["p"]),
            degree=fit["degree"],
            rms=text_tables.figures(fit["rms_m"]),
        )
    rows = [
        [
            dip["id"],
            text_tables.plane_with_error(dip, "error95_deg"),
        ]
        for dip in fit["dips"]
    ]
    headers = [tr("id"), tr("plane")]
    return f"{text}\n" + text_tables.table(headers, ["", tr("dip direction/dip ± 95 %")], rows)
