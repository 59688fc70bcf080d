"""The page on the Python interface: its code is run, from the first line to the last."""

from __future__ import annotations

import re
import warnings
from pathlib import Path

import matplotlib.pyplot as plt
import pytest

import vomstudio as vs

PAGE = Path(__file__).resolve().parents[2] / "docs" / "api.md"


def test_the_code_of_the_page_runs(
    tmp_path: Path,
    own_folders: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    blocks = re.findall(r"```python\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)
    assert len(blocks) > 8
    monkeypatch.chdir(tmp_path)
    names: dict[str, object] = {}
    with warnings.catch_warnings():
        # They are what the page says they are.
        warnings.simplefilter("ignore", vs.errors.VomWarning)
        for block in blocks:
            exec(compile(block, str(PAGE), "exec"), names)
    plt.close("all")
    out = capsys.readouterr().out
    assert "PlaneFit(315.2/38.2, 95 % 0.32 x 0.06 deg, good)" in out
    for name in ("net.png", "cliff.glb", "along_the_fold.tif", "layers.gpkg", "cliff.vom"):
        assert (tmp_path / name).exists()


def test_the_page_names_all_that_is_offered() -> None:
    said = PAGE.read_text(encoding="utf-8")
    functions = [n for n in vs.__all__ if n[0].islower() and n not in ("errors",)]
    assert [name for name in functions if f"vs.{name}" not in said] == []
