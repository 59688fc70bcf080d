"""`vomstudio sets`: the table it writes, seeds, refusals."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import vomstudio as vs
from tests.messages import codes

CHANCE = np.random.default_rng(1)
TRUE = {"bed": (120.0, 30.0), "joint": (30.0, 86.0)}


def table() -> str:
    """Two sets a metre and a quarter of a metre apart, in shuffled rows, and two strays."""
    rows = []
    for name, (direction, dip), gap in (("bed", TRUE["bed"], 1.0), ("joint", TRUE["joint"], 0.25)):
        d, a = np.radians(dip), np.radians(direction)
        normal = np.array([np.sin(a) * np.sin(d), np.cos(a) * np.sin(d), np.cos(d)])
        for i in range(30):
            x, y, z = i * gap * normal
            rows.append(
                f"{name},{direction + CHANCE.normal(0, 2):.2f},"
                f"{min(dip + CHANCE.normal(0, 2), 90):.2f},{x:.4f},{y:.4f},{z:.4f}"
            )
    rows += ["stray,250,50,,,", "stray,300,20,,,"]
    rows = [rows[i] for i in CHANCE.permutation(len(rows))]
    return "# taken in 2024\nset,dipdir,dip,x,y,z\n" + "\n".join(rows) + "\n"


def test_input_table_is_written_with_sets(run, write, tmp_path: Path) -> None:
    out = tmp_path / "out.csv"
    ran = run("sets", write(table()), "-o", out, "--json")
    assert ran.code == 0, ran.err
    found = ran.json
    assert (found["n"], found["unassigned"], found["table"]) == (62, 2, str(out))
    assert [s["n"] for s in found["sets"]] == [30, 30]
    for one in found["sets"]:
        name, gap = ("bed", 1.0) if one["dip_deg"] < 60 else ("joint", 0.25)
        assert one["dip_deg"] == pytest.approx(TRUE[name][1], abs=1.0)
        assert one["dip_direction_deg"] % 180 == pytest.approx(TRUE[name][0] % 180, abs=2.0)
        assert one["spacing_m"] == pytest.approx(gap, rel=0.01)
        assert one["cone95_deg"] < 2
    lines = out.read_text().splitlines()
    assert lines[0] == "# taken in 2024"
    columns = ["set_before", "dipdir", "dip", "x", "y", "z", "set", "set_probability"]
    assert lines[1].split(",") == columns
    cells = [line.split(",") for line in lines[2:]]
    assert len(cells) == 62
    assert {(c[0], c[6]) for c in cells} in (
        {("bed", "S1"), ("joint", "S2"), ("stray", "")},
        {("bed", "S2"), ("joint", "S1"), ("stray", "")},
    )
    assert all(0 < float(c[7]) <= 1 for c in cells)
    # Its mean is that of the statistics of the written table.
    stats = run("stats", out, "--by", "set", "--json").json["sets"]
    for one in found["sets"]:
        assert stats[one["name"]]["n"] == one["n"]
        assert stats[one["name"]]["fisher"]["kappa"] == pytest.approx(one["kappa"])
        assert stats[one["name"]]["fisher"]["plunge_deg"] == pytest.approx(90 - one["dip_deg"])


def test_spacing_needs_coordinates(run, write, tmp_path: Path) -> None:
    bare = "\n".join(",".join(line.split(",")[1:3]) for line in table().splitlines()[1:])
    found = run("sets", write(bare), "-o", tmp_path / "o.csv", "--json").json
    assert [s["spacing_m"] for s in found["sets"]] == [None, None]
    assert codes(found) == []


def test_picks_with_unknown_extent_are_counted_individually_with_warning(
    run, write, tmp_path: Path
) -> None:
    head, *rows = table().splitlines()[1:]
    # Beside each other by up to twenty metres, at planes a metre apart.
    aside = [row.rsplit(",", 1) for row in rows]
    wide = [
        f"{start},{float(z) + CHANCE.uniform(0, 20):.3f}" if z else f"{start},"
        for start, z in aside
    ]
    asked = ("-o", tmp_path / "o.csv", "--force", "--json")
    found = run("sets", write("\n".join([head, *wide])), *asked).json
    assert codes(found).count("sets.each-pick-counts") == 1
    assert [s["p32_low95_1_per_m"] for s in found["sets"]] == [None, None]
    told = run("sets", write(table()), *asked).json
    assert set(codes(told)) == {"frame.assumed"}
    assert all(s["p32_low95_1_per_m"] < s["p32_high95_1_per_m"] for s in told["sets"])


def test_other_delimiters_and_missing_headers_are_read(run, write, tmp_path: Path) -> None:
    rows = [line.split(",")[1:3] for line in table().splitlines()[2:]]
    spaced = "\n".join(" ".join(row) for row in rows)
    out = tmp_path / "o.csv"
    ran = run("sets", write(spaced), "-o", out, "--azimuth", "strike", "--json")
    assert ran.code == 0, ran.err
    assert out.read_text().startswith("strike_rhr_deg,dip_deg,set,set_probability\n")
    commas = "Streichen;strike;dip\n" + "\n".join(
        ";".join(["a", *(c.replace(".", ",") for c in row)]) for row in rows
    )
    ran = run("sets", write(commas), "-o", out, "--force", "--json")
    assert ran.code == 0, ran.err
    again = run("stats", out, "--by", "set", "--json")
    assert again.code == 0, again.err
    assert len(again.json["sets"]) == 3


def test_seeds_and_maximum_number_of_sets_are_used(run, write, tmp_path: Path) -> None:
    path, out = write(table()), tmp_path / "o.csv"
    ran = run("sets", path, "-o", out, "--seeds", "40/80,110/35", "--json")
    assert [round(s["dip_deg"], -1) for s in ran.json["sets"]] == [90, 30]
    assert ran.json["criteria"] == []
    one = run("sets", path, "-o", out, "--force", "--max-sets", "1", "--json").json
    assert len(one["sets"]) == 1
    assert one["unassigned"] == 62 - one["sets"][0]["n"]


@pytest.mark.parametrize(
    ("words", "code"),
    [
        (["--seeds", "north"], "sets.seed-not-a-plane"),
        (["--seeds", "10/95"], "sets.seed-not-a-plane"),
        (["--seeds", "10/50,10/50"], "sets.equal-seeds"),
        (["--seeds", "10/50,90/50", "--max-sets", "1"], "sets.too-many-seeds"),
        (["--max-sets", "0"], "option.too-small"),
        (["--exactly", "2", "--max-sets", "3"], "option.conflict"),
        (["--exactly", "63"], "sets.too-many"),
    ],
)
def test_invalid_options_are_refused(run, write, tmp_path, words: list[str], code: str) -> None:
    ran = run("sets", write(table()), "-o", tmp_path / "o.csv", *words, "--json")
    assert ran.code == 2
    assert (ran.json["error"]["code"], ran.json["error"]["field"]) == (code, words[0])
    assert not (tmp_path / "o.csv").exists()


def test_tables_without_planes_are_refused_and_few_planes_give_no_sets(
    run, write, tmp_path: Path
) -> None:
    out = tmp_path / "o.csv"
    lines = run("sets", write("trend,plunge\n10,20\n30,40\n"), "-o", out)
    assert (lines.code, "no planes" in lines.said) == (2, True)
    few = run("sets", write("dipdir,dip\n10,20\n30,40\n"), "-o", out, "--json")
    assert (few.code, few.json["sets"], few.json["unassigned"]) == (0, [], 2)
    assert codes(few.json) == ["sets.none"]


def test_python_function_returns_same_sets_with_table(write) -> None:
    path = write(table())
    found = vs.sets(path)
    assert [s.n for s in found.sets] == [30, 30]
    assert found.unassigned == 2
    frame = found.table
    assert (frame["set"] == "").sum() == 2
    assert frame["set_probability"].between(0, 1).all()
    angles = frame[["dip_direction_deg", "dip_deg"]].set_index(np.arange(62) + 100)
    seeded = vs.sets(angles, seeds=[(40, 80), (110, 35)])
    assert seeded.table.index[0] == 100
    assert "set" not in angles
    assert [s.n for s in seeded.sets] == [30, 30]
