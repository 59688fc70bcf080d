"""The option `--curved` of `fit`: one bed that bends, through several traces of it."""

from __future__ import annotations

from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from vomstudio.cli.common import text_tables
from vomstudio.cli.common.naming import numbers_of
from vomstudio.core.words import tr

if TYPE_CHECKING:
    from vomstudio.io.text.tables import PointGroups


def fitted(path: str, groups: PointGroups) -> dict[str, Any]:
    """What `--curved` adds to the object. Raises GeometryError."""
    from vomstudio.geology.beds.curved import curved_bed

    with numbers_of(path, "--curved"):
        found = curved_bed([str(name) for name in groups.ids], groups.points, groups.offsets)
    return {
        "degree": found.degree,
        "p": found.p,
        "rms_m": found.rms_m,
        "n": found.n,
        "n_effective": found.n_effective,
        "dips": [asdict(one) for one in found.dips],
    }


def result_text(fit: dict[str, Any]) -> str:
    """Return the fit of a bent bed in words, with its local dip at each trace."""
    if fit["p"] is None:
        text = tr("One plane explains all of the traces.")
    else:
        text = tr(
            "The bed bends (p of a plane {p}): a surface of degree {degree}, rms {rms} m.",
            p=text_tables.figures(fit["p"]),
            degree=fit["degree"],
            rms=text_tables.figures(fit["rms_m"]),
        )
    rows = [
        [
            one["id"],
            text_tables.measured_plane(one, "error95_deg"),
        ]
        for one in fit["dips"]
    ]
    heads = [tr("id"), tr("plane")]
    return f"{text}\n" + text_tables.table(heads, ["", tr("dip direction/dip ± 95 %")], rows)
