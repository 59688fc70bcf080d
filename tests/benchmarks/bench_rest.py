"""Memory of an empty window and its worker at rest.

    xvfb-run -a -s '-screen 0 1600x1000x24 +extension GLX' \\
        python -m tests.benchmarks.bench_rest [ROOT]

ROOT is the checkout that is measured, by default this one. The figures are proportional set sizes
(PSS), which count memory that several processes share in parts, so other programs that use the same
libraries lower them. The last column counts files as if nothing else used them: anonymous memory,
plus each file that is mapped by the window or its workers once. The kernels of this user are copied
and recorded as complete, because compiling them takes another process for some minutes.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import psutil

from vomstudio.core.paths import user_cache

ROOT = Path(__file__).resolve().parents[2]
REST_S = 15.0
WANTED_MB = 250

RECORD = """
from vomstudio.geometry.kernels.compilation_state import record_compilation
record_compilation()
"""


def mappings(pid: int) -> list[tuple[str, float, float]]:
    """File ("" for anonymous memory), PSS and resident size in MB of each mapping of a process."""
    found, name, pss, resident = [], "", 0.0, 0.0
    for line in Path(f"/proc/{pid}/smaps").read_text().splitlines():
        words = line.split()
        if not words[0].endswith(":"):
            path = words[5] if len(words) > 5 else ""
            name = path if path.startswith("/") else ""
        elif words[0] == "Rss:":
            resident = int(words[1]) / 1e3
        elif words[0] == "Pss:":
            pss = int(words[1]) / 1e3
            found.append((name, pss, resident))
    return found


def main() -> None:
    root = Path(sys.argv[1]).resolve() if len(sys.argv) > 1 else ROOT
    with tempfile.TemporaryDirectory() as home:
        environment = dict(os.environ, PYTHONPATH=str(root), XDG_STATE_HOME=home)
        environment |= {"XDG_CACHE_HOME": home, "VOMSTUDIO_SETTINGS": f"{home}/s.toml"}
        environment["NUMBA_CACHE_DIR"] = f"{home}/kernels"
        if user_cache("kernels").is_dir():
            shutil.copytree(user_cache("kernels"), environment["NUMBA_CACHE_DIR"])
        python = [sys.executable, "-P"]
        subprocess.run([*python, "-c", RECORD], env=environment, check=True, cwd=home)
        window = subprocess.Popen([*python, "-m", "vomstudio"], env=environment, cwd=home)
        try:
            process, began = psutil.Process(window.pid), time.monotonic()
            # At rest when there is a worker and nothing uses the processor.
            used, since = -1.0, began
            while time.monotonic() - since < REST_S or len(process.children()) == 0:
                family = [process, *process.children(recursive=True)]
                now = sum(sum(each.cpu_times()[:2]) for each in family)
                if now > used + 0.05:
                    used, since = now, time.monotonic()
                time.sleep(0.2)
            total, files, anonymous = 0.0, dict[str, float](), 0.0
            for each in family:
                rows = mappings(each.pid)
                pss = sum(row[1] for row in rows)
                total += pss
                sizes: dict[str, float] = {}
                for name, share, resident in rows:
                    if name:
                        sizes[name] = sizes.get(name, 0.0) + resident
                    else:
                        anonymous += share
                files |= {name: max(size, files.get(name, 0.0)) for name, size in sizes.items()}
                kind = "worker" if "--worker" in each.cmdline() else "window"
                print(f"{kind}: {pss:.0f} MB, {each.num_threads()} threads")
            print(
                f"together {total:.0f} MB PSS, wanted {WANTED_MB};"
                f" {anonymous + sum(files.values()):.0f} MB if nothing else used the files;"
                f" {used:.2f} s of processor time"
            )
        finally:
            window.terminate()
            window.wait()


if __name__ == "__main__":
    main()
