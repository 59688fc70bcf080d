"""What crosses between window and worker: dataclasses of plain values, and nothing else."""

from __future__ import annotations

import json
import types
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, is_dataclass
from pathlib import Path
from typing import Any, Literal, Union, get_args, get_origin, get_type_hints

import numpy as np
import numpy.typing as npt
import pytest

from tests.messages import refused
from vomstudio.core.errors import WorkerError
from vomstudio.core.findings import Finding
from vomstudio.core.options import Options
from vomstudio.core.results import Result, to_dict
from vomstudio.photogrammetry.georeferencing.control_check import ControlCheck
from vomstudio.photogrammetry.survey.check_results import SurveyReport
from vomstudio.studio.jobs import serialisation
from vomstudio.studio.jobs.survey_tasks import ControlSummary
from vomstudio.studio.jobs.tasks import TASKS, find_task


@dataclass(frozen=True)
class Inner:
    name: str
    at: tuple[float, float] | None = None


@dataclass(frozen=True)
class Outer:
    path: Path
    kind: Literal["mesh", "cloud"]
    inner: tuple[Inner, ...]
    counts: Mapping[str, int]
    share: float
    free: Any = None
    yes: bool = False


WHOLE = Outer(Path("a/b"), "mesh", (Inner("x", (1.5, 2.0)), Inner("y")), {"n": 3}, 0.5, [1, "two"])


def test_encoded_dataclass_survives_json() -> None:
    plain = json.loads(json.dumps(serialisation.encode(WHOLE), allow_nan=False))
    assert serialisation.decode(Outer, plain) == WHOLE


def test_integer_in_a_float_field_stays_an_integer() -> None:
    """What a command prints is the same before and after it has crossed."""
    found = serialisation.decode(Outer, {**serialisation.encode(WHOLE), "share": 1})
    assert json.dumps(serialisation.encode(found)["share"]) == "1"


@pytest.mark.parametrize(
    ("field", "value", "code", "values"),
    [
        ("path", 5, "job.wrong-value", {"name": "path", "type": "Path", "value": "5"}),
        ("kind", "line", "job.wrong-value", {"name": "kind"}),
        ("inner", [{"name": 5}], "job.wrong-value", {"name": "inner[0].name", "type": "str"}),
        ("inner", [{"name": "x", "at": [1.0]}], "job.wrong-value", {"name": "inner[0].at"}),
        ("inner", [{"name": "x", "more": 1}], "job.unknown-field", {"name": "inner[0].more"}),
        ("inner", [{}], "job.missing-field", {"name": "inner[0].name", "type": "Inner"}),
        ("counts", {"n": "many"}, "job.wrong-value", {"name": "counts['n']", "type": "int"}),
        ("counts", [], "job.wrong-value", {"name": "counts"}),
        ("share", True, "job.wrong-value", {"name": "share", "type": "float"}),
        ("yes", 1, "job.wrong-value", {"name": "yes", "type": "bool"}),
    ],
)
def test_value_of_a_wrong_type_is_rejected_with_its_name(
    field: str, value: Any, code: str, values: dict[str, str]
) -> None:
    with refused(code, WorkerError, **values):
        serialisation.decode(Outer, {**serialisation.encode(WHOLE), field: value})


@pytest.mark.parametrize(
    ("free", "name", "kind"),
    [
        (float("inf"), "free", "inf"),
        ([1, np.zeros(3)], "free[1]", "ndarray"),
        ({"a": {1, 2}}, "free['a']", "set"),
    ],
)
def test_unserialisable_value_is_rejected_with_its_name(free: Any, name: str, kind: str) -> None:
    with refused("job.unsendable", WorkerError, name=name, type=kind):
        serialisation.encode(Outer(Path("a"), "mesh", (), {}, 0.5, free))


# Whoever looks for one that does not exist has looked at all.
assert find_task("missing") is None


@pytest.mark.parametrize("name", sorted(TASKS))
def test_job_requests_and_results_are_frozen_dataclasses(name: str) -> None:
    job = find_task(name)
    assert job is not None
    assert job.name == name
    for cls in (job.request, job.result):
        assert is_dataclass(cls)
        assert cls.__dataclass_params__.frozen  # type: ignore[attr-defined]
        assert set(get_type_hints(cls)) >= {field.name for field in fields(cls)}


PLAIN = {
    Any: {"any": [1, "text", None]},
    Finding: Finding("path.invalid", reason="a reason"),
    Path: Path("folder/file"),
    str: "text",
    int: 3,
    float: 0.25,
    bool: True,
    np.ndarray: np.arange(16.0).reshape(4, 4),
}


def example(hint: Any, *, is_full: bool) -> Any:
    """Return a value of a type hint; full, with a value for each optional field and item."""
    origin, kinds = get_origin(hint), get_args(hint)
    if origin in (Union, types.UnionType):
        if type(None) in kinds and not is_full:
            return None
        return example(next(kind for kind in kinds if kind is not type(None)), is_full=is_full)
    if origin is Literal:
        return kinds[0]
    if origin is tuple and kinds[1:] != (Ellipsis,):
        return tuple(example(kind, is_full=is_full) for kind in kinds)
    if origin in (tuple, list, Sequence):
        items = [example(kinds[0], is_full=is_full)] if is_full else []
        return items if origin is list else tuple(items)
    if origin in (dict, Mapping):
        return {"key": example(kinds[1], is_full=is_full)} if is_full else {}
    if is_dataclass(hint):
        if issubclass(hint, Options):  # type: ignore[arg-type]
            # Other values may exclude one another.
            return hint()  # type: ignore[operator]
        hints = get_type_hints(hint)
        values = {
            field.name: example(hints[field.name], is_full=is_full)
            for field in fields(hint)
            if field.init
        }
        return hint(**values)  # type: ignore[operator]
    return PLAIN[hint if origin is None else origin]


def restored(cls: type[Any], sent: Any) -> Any:
    return serialisation.decode(cls, json.loads(json.dumps(sent, allow_nan=False)))


@pytest.mark.parametrize("is_full", [True, False])
@pytest.mark.parametrize("part", ["request", "result"])
@pytest.mark.parametrize("name", sorted(TASKS))
def test_job_requests_and_results_survive_serialisation(
    name: str, part: str, is_full: bool
) -> None:
    cls = getattr(find_task(name), part)
    sent = serialisation.encode(example(cls, is_full=is_full))
    assert serialisation.encode(restored(cls, sent)) == sent


@pytest.mark.parametrize("is_full", [True, False])
@pytest.mark.parametrize(
    ("cls", "to"), [(SurveyReport, SurveyReport), (ControlCheck, ControlSummary)]
)
def test_printed_objects_survive_serialisation(
    cls: type[Result], to: type[Any], is_full: bool
) -> None:
    """Of `report.json` and of jobs that return what a command prints."""
    printed = example(cls, is_full=is_full).to_dict()
    assert to_dict(restored(to, printed)) == printed


def test_small_array_is_serialised_and_non_finite_values_are_rejected() -> None:
    sent = Turned(np.array([[1.0, 2.5], [-3.0, 1e-9]]))
    there = serialisation.decode(Turned, json.loads(json.dumps(serialisation.encode(sent))))
    assert there.matrix.dtype == np.float64
    assert np.array_equal(there.matrix, sent.matrix)
    with refused("job.unsendable", WorkerError, name="matrix[0][1]"):
        serialisation.encode(Turned(np.array([[1.0, np.nan]])))
    with refused("job.wrong-value", WorkerError, name="matrix"):
        serialisation.decode(Turned, {"matrix": [[1.0], "x"]})


@dataclass(frozen=True, eq=False)
class Turned:
    matrix: npt.NDArray[np.float64]
