"""Rows of a table become sets of a net."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from vomstudio.core.errors import UsageError
from vomstudio.geology.orientation import Line, Plane, angle_between_lines, normals_to_planes
from vomstudio.io.gate.orientation_files import read_orientations
from vomstudio.products.net.table_net import net_from_table


def net(folder: Path, text: str, by: str | None = None, **more: Any) -> Any:
    table = folder / "table.csv"
    table.write_text(text, encoding="utf-8")
    return net_from_table(read_orientations(table), by, **more)


BOTH = """dip_direction,dip,trend,plunge,set,kind,site
120,30,,,A,bedding,n
130,35,,,A,bedding,s
,,200,10,A,striae,n
300,80,,,B,fault,s
90,45,,,,joint,n
"""


def told(result: Any) -> dict[str, tuple[str, list[float], list[float]]]:
    return {s.name: (s.kind, list(s.azimuth_deg), list(s.angle_deg)) for s in result.sets}


def test_rows_are_grouped_by_set(tmp_path: Path) -> None:
    assert told(net(tmp_path, BOTH)) == {
        "A (planes)": ("plane", [120, 130], [30, 35]),
        "A (lines)": ("line", [200], [10]),
        "B": ("plane", [300], [80]),
        "unassigned": ("plane", [90], [45]),
    }


def test_rows_are_grouped_by_any_column(tmp_path: Path) -> None:
    result = told(net(tmp_path, BOTH, "site"))
    assert result == {
        "n (planes)": ("plane", [120, 90], [30, 45]),
        "n (lines)": ("line", [200], [10]),
        "s": ("plane", [130, 300], [35, 80]),
    }
    with pytest.raises(UsageError, match="colour"):
        net(tmp_path, BOTH, "colour")


def test_rows_without_sets_are_grouped_by_kind_or_by_geometry(tmp_path: Path) -> None:
    without = BOTH.replace(",A,", ",,").replace(",B,", ",,")
    assert list(told(net(tmp_path, without))) == ["bedding", "striae", "fault", "joint"]
    bare = "dip_direction,dip,trend,plunge\n120,30,,\n,,200,10\n130,35,,\n"
    assert told(net(tmp_path, bare)) == {
        "planes": ("plane", [120, 130], [30, 35]),
        "lines": ("line", [200], [10]),
    }


def test_net_keeps_the_requested_options(tmp_path: Path) -> None:
    plain, requests = net(tmp_path, BOTH), net(tmp_path, BOTH, projection="angle", contour="kamb")
    assert (plain.projection, plain.contour) == ("area", None)
    assert (requests.projection, requests.contour) == ("angle", "kamb")


def test_clusters_have_a_mean_and_girdles_do_not(tmp_path: Path) -> None:
    rng = np.random.default_rng(2)
    normals = Plane(132, 41).normal() + 0.05 * rng.normal(size=(20, 3))
    direction, dip = normals_to_planes(normals)[:2]
    turn = np.radians(np.arange(0, 180, 9))
    girdle = np.column_stack([np.cos(turn), np.zeros(20), np.sin(turn)])
    around, steep = normals_to_planes(girdle)[:2]
    rows = [f"{a},{b},cluster" for a, b in zip(direction, dip, strict=True)]
    rows += [f"{a},{b},girdle" for a, b in zip(around, steep, strict=True)]
    result = net(tmp_path, "dip_direction,dip,set\n" + "\n".join(rows) + "\n")
    assert [s.name for s in result.sets] == ["cluster", "girdle"]
    (mean,) = result.means
    assert mean.color == result.sets[0].color
    assert angle_between_lines(mean.line, Line(132 + 180, 90 - 41)) < 3
