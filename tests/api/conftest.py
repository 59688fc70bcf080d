"""What the tests of the Python interface share."""

from __future__ import annotations

import json
from collections.abc import Callable
from typing import Any

import matplotlib
import pandas
import pytest

import vomstudio as vs
from vomstudio.cli import main

matplotlib.use("agg")


@pytest.fixture
def command(capsys: pytest.CaptureFixture[str]) -> Callable[..., dict[str, Any]]:
    """What a command answers with --json, its success supposed."""

    def run(*words: object) -> dict[str, Any]:
        capsys.readouterr()
        code = main([*map(str, words), "--json"])
        out, err = capsys.readouterr()
        assert code == 0, err
        found: dict[str, Any] = json.loads(out)
        return found

    return run


@pytest.fixture(scope="session")
def picks() -> Any:
    """The points of the embedded sample: pick, kind, set, horizon, x, y, z."""
    return pandas.read_csv(vs.sample("picks.csv"), comment="#")


@pytest.fixture(scope="session")
def cliff() -> vs.Mesh:
    model = vs.read(vs.sample("sample.obj"))
    assert isinstance(model, vs.Mesh)
    return model
