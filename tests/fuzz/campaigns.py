"""What campaigns share: ending the command by signals, counting, the options and the exit code."""

from __future__ import annotations

import argparse
import os
import random
import signal
import subprocess
import sys
import time
from collections import Counter
from collections.abc import Callable, Sequence

import psutil

MAX_END_S = 3.0
"""Maximum time from a signal to the end of the command."""
Report = Callable[[str], object]
Outcome = tuple[Counter[str], list[str]]
"""Readings by the code of their answer, and the broken promises."""


def default_signals() -> None:
    """Handle the signals as a terminal does; a shell in the background may ignore them."""
    signal.signal(signal.SIGINT, signal.default_int_handler)
    for each in (signal.SIGTERM, signal.SIGHUP):
        signal.signal(each, signal.SIG_DFL)


def end_by_signal(words: Sequence[str], number: int, after_s: float) -> tuple[int, float, int]:
    """Run the command and end it by a signal.

    Returns
    -------
    int
        The exit code.
    float
        Seconds from the signal to the end; 0 if it had ended before.
    int
        How many processes that it had started are left two seconds later.
    """
    process = subprocess.Popen(
        [sys.executable, "-P", "-m", "vomstudio", *words],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        preexec_fn=default_signals,
        env={**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)},
    )
    try:
        code = process.wait(after_s)
    except subprocess.TimeoutExpired:
        children = psutil.Process(process.pid).children(recursive=True)
        begun = time.monotonic()
        process.send_signal(number)
        try:
            code = process.wait(30.0)
        except subprocess.TimeoutExpired:
            process.kill()
            code = process.wait()
        ended_s = time.monotonic() - begun
        _, alive = psutil.wait_procs(children, 2.0)
        # Whoever inherits one that has ended need not look at it.
        return code, ended_s, sum(each.status() != psutil.STATUS_ZOMBIE for each in alive)
    return code, 0.0, 0


def end_by_signals(
    count: int,
    seed: int,
    max_delay_s: float,
    prepare: Callable[[int], tuple[list[str], str]],
    report: Report = str,
) -> list[str]:
    """End the command while it reads, by each signal in turn, and return the broken promises.

    Parameters
    ----------
    prepare : callable
        Returns the words of the command and a description, for the number of a run.
    max_delay_s : float
        Longest time until the signal.
    """
    wrong: list[str] = []
    slowest, reading = 0.0, 0
    chance = random.Random(seed)
    for number in range(count):
        words, how = prepare(number)
        name = ("SIGINT", "SIGTERM", "SIGHUP")[number % 3]
        code, ended_s, left = end_by_signal(
            words, getattr(signal, name), chance.uniform(0.3, max_delay_s)
        )
        slowest, reading = max(slowest, ended_s), reading + (ended_s > 0)
        if ended_s > MAX_END_S or left or (ended_s and code not in (0, 2, 130)):
            wrong.append(f"{number} ({how}, {name}): exit {code} after {ended_s:.1f} s, {left}")
            report(wrong[-1])
    report(f"{count} signals, {reading} before the end, the slowest {slowest:.1f} s after it")
    return wrong


def parser(description: str | None) -> argparse.ArgumentParser:
    """Return the options that campaigns of bent files share."""
    made = argparse.ArgumentParser(description=str(description).splitlines()[0])
    made.add_argument("--files", type=int, default=1000)
    made.add_argument("--seed", type=int, default=0)
    made.add_argument("--signals", type=int, default=0)
    return made


def run(
    options: argparse.Namespace,
    campaign: Callable[[int, int, Report], Outcome],
    signals: Callable[[int, int, Report], list[str]],
) -> int:
    """Run a campaign and its signals, print the outcome and return the exit code."""
    counts, wrong = campaign(options.files, options.seed, print)
    print(f"{options.files} files, {sum(counts.values())} readings: {dict(counts)}")
    wrong += signals(options.signals, options.seed, print) if options.signals else []
    print(f"{len(wrong)} broken promises")
    return int(bool(wrong))
