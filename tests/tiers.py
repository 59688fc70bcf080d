"""Tiers of the test suite: measure the processor time of each test and limit the default tier.

=======  ================================  ====================================================
tier     run by                            contains
=======  ================================  ====================================================
default  ``packaging/test``, CI            every law once, quickly
full     ``packaging/test --all``          journeys, simulations, mutants, examples of documents
slow     ``packaging/test -m slow``        long simulations and real data
=======  ================================  ====================================================

Tests of the full tier carry the marker ``full``, those of the slow tier ``slow``; all others form
the default tier. The hooks are imported by ``conftest.py``.
"""

from __future__ import annotations

import os
from collections import defaultdict
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from typing import Any

import pytest
from _pytest.mark.structures import ParameterSet

REPORT_CPU_S = 3.0
"""A default-tier test above this processor time is reported."""
MAX_CPU_S = 15.0
"""A default-tier test above this processor time fails the run, unless it is in `EXPENSIVE`."""
BUDGET_CPU_S = 1000.0
"""A default tier above this processor time is reported: two cores would need over 9 minutes."""
MAX_WINDOW_TESTS = 400
"""More default-tier tests with a window fail the run. Windows are a third of its processor time,
and their number, unlike a time, is the same on every machine."""
WINDOW_FIXTURES = frozenset(["window", "new_window"])
SLOWEST_COUNT = 30
COSTLIEST_COUNT = 20

EXPENSIVE: dict[str, str] = {
    "tests/journeys/test_facets_in_window.py"
    "::test_accepting_a_facet_keeps_the_colors_of_the_others": (
        "the only journey of facets in the default tier"
    ),
    "tests/journeys/test_every_panel_and_tool.py"
    "::test_every_tool_activates_by_its_key_and_responds_to_clicks": (
        "the only journey with every tool"
    ),
}
"""Node ids of default-tier tests that may exceed `MAX_CPU_S`, with the reason."""


@dataclass
class Costs:
    """Processor seconds of the tests of this session, by node id."""

    seconds: dict[str, float] = field(default_factory=dict)
    default_tier: set[str] = field(default_factory=set)
    window_tests: set[str] = field(default_factory=set)

    def add(
        self, node_id: str, seconds: float, *, is_default: bool, has_window: bool = False
    ) -> None:
        """Store the processor time of one test."""
        self.seconds[node_id] = seconds
        if is_default:
            self.default_tier.add(node_id)
            if has_window:
                self.window_tests.add(node_id)

    def slowest(self) -> list[tuple[str, float]]:
        """Return the `SLOWEST_COUNT` most expensive tests, the most expensive first."""
        ranked = sorted(self.seconds.items(), key=lambda item: -item[1])
        return ranked[:SLOWEST_COUNT]

    def above(self, limit_s: float) -> list[str]:
        """Return the default-tier tests above a limit, the most expensive first."""
        ranked = sorted(self.default_tier, key=lambda node_id: -self.seconds[node_id])
        return [node_id for node_id in ranked if self.seconds[node_id] > limit_s]

    def by_folder(self) -> list[tuple[str, float]]:
        """Return the `COSTLIEST_COUNT` costliest folders of default-tier tests, costliest first."""
        totals: defaultdict[str, float] = defaultdict(float)
        for node_id in self.default_tier:
            totals[node_id.partition("::")[0].rpartition("/")[0]] += self.seconds[node_id]
        ranked = sorted(totals.items(), key=lambda item: -item[1])
        return ranked[:COSTLIEST_COUNT]

    def default_total(self) -> float:
        """Return the processor seconds of all default-tier tests."""
        return sum(self.seconds[node_id] for node_id in self.default_tier)

    def has_too_many_windows(self) -> bool:
        """Return whether more than `MAX_WINDOW_TESTS` default-tier tests use a window."""
        return len(self.window_tests) > MAX_WINDOW_TESTS

    def over_limit(self) -> list[str]:
        """Return the default-tier tests that fail the run."""
        return [node_id for node_id in self.above(MAX_CPU_S) if node_id not in EXPENSIVE]


_COSTS = pytest.StashKey[Costs]()
_ITEM_START_S = pytest.StashKey[float]()


def cpu_seconds() -> float:
    """Return the processor time of this process and its finished child processes, in seconds."""
    times = os.times()
    return times.user + times.system + times.children_user + times.children_system


def is_default_tier(item: pytest.Item) -> bool:
    """Return whether `packaging/test` runs a test without further arguments."""
    return not any(item.get_closest_marker(name) for name in ("full", "slow"))


def pytest_configure(config: pytest.Config) -> None:
    config.stash[_COSTS] = Costs()


@pytest.hookimpl(wrapper=True, tryfirst=True)
def pytest_runtest_protocol(item: pytest.Item) -> Iterator[None]:
    item.stash[_ITEM_START_S] = cpu_seconds()
    return (yield)


@pytest.hookimpl(wrapper=True, trylast=True)
def pytest_runtest_makereport(item: pytest.Item, call: pytest.CallInfo[None]) -> Iterator[None]:
    report = yield
    if call.when == "teardown":
        # Attributes of a report travel from the processes of pytest-xdist to the controller.
        report.cpu_s = cpu_seconds() - item.stash[_ITEM_START_S]
        report.is_default_tier = is_default_tier(item)
        report.has_window = not WINDOW_FIXTURES.isdisjoint(getattr(item, "fixturenames", ()))
    return report


class Collector:
    """Collects the costs in the process that prints the summary."""

    def __init__(self, config: pytest.Config) -> None:
        self._costs = config.stash[_COSTS]

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        if hasattr(report, "cpu_s"):
            self._costs.add(
                report.nodeid,
                report.cpu_s,
                is_default=report.is_default_tier,
                has_window=report.has_window,
            )


@pytest.hookimpl(tryfirst=True)
def pytest_sessionstart(session: pytest.Session) -> None:
    if not hasattr(session.config, "workerinput"):
        session.config.pluginmanager.register(Collector(session.config), "tier-costs")


@pytest.hookimpl(tryfirst=True)
def pytest_sessionfinish(session: pytest.Session) -> None:
    costs = session.config.stash[_COSTS]
    failed = costs.over_limit() or costs.has_too_many_windows()
    if failed and session.exitstatus == pytest.ExitCode.OK:
        session.exitstatus = pytest.ExitCode.TESTS_FAILED


def pytest_terminal_summary(
    terminalreporter: pytest.TerminalReporter, config: pytest.Config
) -> None:
    costs = config.stash[_COSTS]
    # A few tests that somebody named are not ranked, only checked.
    rows = costs.slowest() if len(costs.seconds) >= 2 * SLOWEST_COUNT else []
    write = terminalreporter.write_line
    if rows:
        terminalreporter.section(f"{len(rows)} slowest tests (processor seconds)")
    for node_id, seconds in rows:
        write(f"{seconds:8.1f}  {node_id}")
    if slow := [each for each in costs.above(REPORT_CPU_S) if each not in EXPENSIVE]:
        terminalreporter.section(f"default tier: {len(slow)} tests above {REPORT_CPU_S:g} s")
        for node_id in slow:
            write(f"{costs.seconds[node_id]:8.1f}  {node_id}")
    if rows:
        terminalreporter.section("default tier: costliest folders")
        for folder, seconds in costs.by_folder():
            write(f"{seconds:8.0f}  {folder}")
        total = sum(costs.seconds.values())
        write(f"{len(costs.seconds)} tests took {total:.0f} processor seconds")
        total = costs.default_total()
        write(
            f"default tier: {total:.0f} of at most {BUDGET_CPU_S:.0f} processor seconds, "
            f"{len(costs.window_tests)} of at most {MAX_WINDOW_TESTS} tests with a window",
            yellow=total > BUDGET_CPU_S,
        )
    if costs.has_too_many_windows():
        write(
            f"ERROR {len(costs.window_tests)} tests of the default tier use a window; at most"
            f" {MAX_WINDOW_TESTS} may. Mark the costliest `full`.",
            red=True,
        )
    for node_id in costs.over_limit():
        write(
            f"ERROR {node_id} took {costs.seconds[node_id]:.1f} processor seconds; the default tier"
            f" allows {MAX_CPU_S:g}. Mark it `full`, make it cheaper, or add it to EXPENSIVE in"
            " tests/tiers.py with a reason.",
            red=True,
        )


def first_in_default_tier(values: Iterable[Any], count: int = 1) -> list[Any]:
    """Return parameters of which only the first, or the first few, belong to the default tier.

    For simulations that repeat one law with other seeds, sizes or shapes.

    Parameters
    ----------
    values : iterable
        Values, tuples of values, or results of `pytest.param`.
    count : int
        How many stay in the default tier; the others are marked ``full``.
    """
    marked = []
    for number, value in enumerate(values):
        if number < count:
            marked.append(value)
            continue
        if isinstance(value, ParameterSet):
            arguments, marks, id_ = value.values, list(value.marks), value.id
        else:
            arguments = value if isinstance(value, tuple) else (value,)
            marks, id_ = [], None
        marked.append(pytest.param(*arguments, marks=[*marks, pytest.mark.full], id=id_))
    return marked
