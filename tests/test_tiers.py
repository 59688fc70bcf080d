"""The processor time of tests is measured, reported and limited by tier."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests import tiers

pytest_plugins = ["pytester"]
ROOT = Path(__file__).resolve().parents[1]

CONFTEST = """
    from tests import tiers
    from tests.tiers import (
        pytest_configure,
        pytest_runtest_makereport,
        pytest_runtest_protocol,
        pytest_sessionfinish,
        pytest_sessionstart,
        pytest_terminal_summary,
    )
    tiers.REPORT_CPU_S, tiers.MAX_CPU_S = 0.05, 0.25
"""
TESTS = """
    import subprocess, sys, time
    import pytest

    def burn(seconds):
        end = time.process_time() + seconds
        while time.process_time() < end:
            pass

    def test_cheap():
        pass

    def test_waiting():
        time.sleep(0.5)

    def test_costly():
        burn(0.1)

    @pytest.mark.full
    def test_of_full_tier():
        burn(0.4)
"""
EXPENSIVE = """
    @pytest.fixture
    def model():
        burn(0.2)
        yield
        burn(0.2)

    def test_expensive_in_fixture(model):
        pass

    def test_expensive_in_child():
        code = "import time\\nwhile time.process_time() < 0.4: pass"
        subprocess.run([sys.executable, "-c", code], check=True)
"""
WINDOW = """
    @pytest.fixture
    def window():
        pass

    @pytest.fixture
    def studio(window):
        pass

    def test_window(window):
        pass

    def test_studio(studio):
        pass

    @pytest.mark.full
    def test_window_of_full_tier(window):
        pass
"""
ALLOWED = """
    names = ("test_expensive_in_fixture", "test_expensive_in_child")
    tiers.EXPENSIVE.update({f"test_it.py::{name}": "reason" for name in names})
"""


@pytest.fixture(autouse=True)
def importable_plugin(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let the processes of the inner runs import `tests.tiers`."""
    monkeypatch.setenv("PYTHONPATH", str(ROOT))


def run(pytester: pytest.Pytester, *arguments: str, more: str = "", conftest: str = CONFTEST):
    pytester.makeini("[pytest]\nmarkers =\n    full: full tier\n    slow: slow tier")
    pytester.makeconftest(conftest)
    pytester.makepyfile(test_it=TESTS + more)
    return pytester.runpytest_subprocess("-p", "no:cacheprovider", "-p", "no:dash", *arguments)


def test_processor_time_is_reported_and_only_the_default_tier_is_limited(
    pytester: pytest.Pytester,
) -> None:
    done = run(pytester)
    assert done.ret == pytest.ExitCode.OK
    reported = done.stdout.str().partition("default tier: ")[2]
    assert "test_costly" in reported
    assert "test_waiting" not in reported
    assert "test_of_full_tier" not in reported


@pytest.mark.full
def test_expensive_tests_fail_the_run(pytester: pytest.Pytester) -> None:
    check_failure(run(pytester, more=EXPENSIVE))


@pytest.mark.full
def test_expensive_tests_in_parallel_processes_fail_the_run(pytester: pytest.Pytester) -> None:
    check_failure(run(pytester, "--numprocesses", "1", more=EXPENSIVE))


def check_failure(done: pytest.RunResult) -> None:
    assert done.ret == pytest.ExitCode.TESTS_FAILED
    done.assert_outcomes(passed=6)
    for name in ("test_expensive_in_fixture", "test_expensive_in_child"):
        done.stdout.fnmatch_lines([f"ERROR test_it.py::{name} took *"])


@pytest.mark.full
def test_expensive_tests_with_a_reason_are_allowed(pytester: pytest.Pytester) -> None:
    done = run(pytester, more=EXPENSIVE, conftest=CONFTEST + ALLOWED)
    assert done.ret == pytest.ExitCode.OK


def test_more_windows_than_allowed_fail_the_run(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(tiers, "MAX_WINDOW_TESTS", 1)
    costs = tiers.Costs()
    for number in range(2):
        assert not costs.has_too_many_windows()
        costs.add(f"full {number}", 1.0, is_default=False, has_window=True)
        costs.add(f"default {number}", 1.0, is_default=True, has_window=True)
        costs.add(f"other {number}", 1.0, is_default=True)
    assert costs.has_too_many_windows()
    assert costs.default_total() == 4.0


@pytest.mark.full
def test_tests_with_a_window_are_counted(pytester: pytest.Pytester) -> None:
    done = run(pytester, more=WINDOW, conftest=CONFTEST + "    tiers.MAX_WINDOW_TESTS = 1\n")
    assert done.ret == pytest.ExitCode.TESTS_FAILED
    done.stdout.fnmatch_lines(["ERROR 2 tests of the default tier use a window*"])


def test_every_reason_belongs_to_a_test() -> None:
    from tests.tiers import EXPENSIVE

    assert all(EXPENSIVE.values())
    for node_id in EXPENSIVE:
        file, _, name = node_id.partition("::")
        assert f"def {name.partition('[')[0]}(" in (ROOT / file).read_text()
