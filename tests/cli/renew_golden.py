"""`python -m tests.cli.renew_golden [CASE ...]` writes down anew what the commands say as JSON.

All cases of `golden_cases.CASES` without a name, the slow ones too (half a minute more); else those
that are named. What has changed is printed and is to be looked at line by line (`git diff
tests/cli/golden`) before it is committed: users script these objects, so a key may come, and none
may go or change its meaning without a word in the changelog.
"""

from __future__ import annotations

import os
import sys
import tempfile
from pathlib import Path

from tests.cli.golden_cases import CASES, GOLDEN, Runner, differences, golden, write_golden
from tests.kernel_cache import share_kernel_cache


def main() -> None:
    chosen = sys.argv[1:] or [case.name for case in CASES]
    GOLDEN.mkdir(exist_ok=True)
    share_kernel_cache()
    with tempfile.TemporaryDirectory() as folder:
        for name in ("XDG_CACHE_HOME", "XDG_CONFIG_HOME", "XDG_STATE_HOME", "LOCALAPPDATA"):
            os.environ[name] = str(Path(folder) / "user")
        runner = Runner(Path(folder) / "renewed")
        for case in CASES:
            if case.name not in chosen:
                continue
            ran = runner.ran(case.name)
            try:
                before = golden(case.name)
            except FileNotFoundError:
                print(f"{case.name}: new")
            else:
                for sentence in differences(before, ran):
                    print(f"{case.name}{sentence}")
            if ran["code"] != case.code:
                print(f"{case.name}: exit code {ran['code']}, and not {case.code}: {ran['json']}")
            write_golden(case.name, ran)
    if len(chosen) == len(CASES):
        for path in GOLDEN.glob("*.json"):
            if path.stem not in chosen:
                print(f"{path.stem}: no case any more, removed")
                path.unlink()


if __name__ == "__main__":
    main()
