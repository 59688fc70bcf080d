"""Mistakes are counted, told of once, and never go round."""

from __future__ import annotations

import logging

import pytest

from tests.messages import figures
from vomstudio.core.errors import InputError
from vomstudio.core.failures.error_collector import MIN_REPEAT_INTERVAL_S, ErrorCollector, Failure
from vomstudio.core.findings import Finding


class Clock:
    def __init__(self) -> None:
        self.now = 100.0

    def __call__(self) -> float:
        return self.now


@pytest.fixture
def clock() -> Clock:
    return Clock()


@pytest.fixture
def heard() -> list[Failure]:
    return []


@pytest.fixture
def collector(clock, heard) -> ErrorCollector:
    made = ErrorCollector(clock)
    made.listen(heard.append)
    return made


def mistake(words: str = "no such thing") -> ValueError:
    try:
        raise ValueError(words)
    except ValueError as error:
        return error


@pytest.mark.expects_log
def test_frequent_error_is_reported_once(collector, clock, heard):
    for _ in range(500):
        collector.report(mistake())
        clock.now += 0.02
    assert len(heard) == 1


@pytest.mark.expects_log
def test_error_recurring_after_pause_is_reported_with_count(collector, clock, heard):
    for _ in range(4):
        collector.report(mistake())
    clock.now += MIN_REPEAT_INTERVAL_S + 0.1
    collector.report(mistake())
    assert [failure.count for failure in heard] == [1, 5]
    assert heard[0].repetitions == ()
    assert heard[1].repetitions == (Finding("program.repeated", count=5),)


@pytest.mark.expects_log
def test_log_contains_traceback_once_and_counts_after(collector, caplog):
    detail = "secret of the trace"
    with caplog.at_level(logging.ERROR):
        for _ in range(100):
            collector.report(mistake(detail), "in a test")
    texts = [record.getMessage() for record in caplog.records]
    assert len(texts) == 3
    assert detail in texts[0]
    assert "in a test" in texts[0]
    assert figures(texts[2])[-1] == 100


@pytest.mark.expects_log
def test_error_in_listener_does_not_recurse(collector, heard):
    def tell(failure: Failure) -> None:
        heard.append(failure)
        collector.report(mistake("while telling"))
        raise RuntimeError("the one who tells is broken")

    collector.listen(tell)
    assert not collector.report(mistake())
    assert len(heard) == 1
    collector.listen(heard.append)
    collector.report(InputError("another"))
    assert len(heard) == 2, "it can tell again"


@pytest.mark.expects_log
def test_error_without_text_is_reported(collector, heard):
    class Wordless(Exception):
        def __str__(self) -> str:
            raise RuntimeError("no words")

    assert collector.report(Wordless())
    assert "Wordless" in heard[0].what


@pytest.mark.expects_log
@pytest.mark.parametrize(
    ("error", "code", "words"),
    [
        (InputError(Finding("file.missing"), file="cliff.obj"), "file.missing", "cliff.obj"),
        (InputError("is not a model", file="cliff.obj"), "uncoded", "cliff.obj: is not a model"),
        (MemoryError(), "program.memory-full", ""),
        (mistake(), "program.internal-error", "ValueError in test_error_collector.py"),
    ],
)
def test_failure_has_code_and_details(collector, heard, error, code, words):
    collector.report(error)
    assert heard[0].finding.code == code
    assert words in heard[0].finding.message
