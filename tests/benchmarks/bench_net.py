"""How long the dock's net of 10,000 poles takes, contoured: `python -m tests.benchmarks.bench_net`.

0.3 s on two free cores is what is promised.
"""

from __future__ import annotations

import os
from time import perf_counter

import numpy as np

from vomstudio.geology.orientation import normals_to_planes
from vomstudio.products.net.contents import Contouring, NetContents, make_sets
from vomstudio.products.net.style import NetStyle

_SIDE = 500
_TIMES = 5


def main() -> None:
    os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")
    from vomstudio.ui.panels.net.canvas import DPI, DrawnNet, NetRequest

    rng = np.random.default_rng(1)
    normals = rng.normal(size=(10_000, 3)) + np.repeat([[3, 1, -2], [-1, 2, -4]], 5_000, axis=0)
    azimuth, dip = normals_to_planes(normals)[:2]
    halves = {name: slice(i * 5_000, (i + 1) * 5_000) for i, name in enumerate("ab")}
    sets = make_sets({name: ("plane", azimuth[h], dip[h]) for name, h in halves.items()})
    style = NetStyle.dock(dpi=DPI, font_px=12)
    for method in (None, "exponential_kamb", "linear_kamb", "kamb", "schmidt"):
        for each in (False, True):
            net = NetContents(
                sets, contour=method, contouring=Contouring(each_set=each), compact=True
            )
            took = []
            for _ in range(_TIMES):
                start = perf_counter()
                DrawnNet.draw(NetRequest(net, style, (_SIDE, _SIDE), 1.0)).image()
                took.append(perf_counter() - start)
            what = "each set" if each else "together"
            print(f"{method or 'no contours':<17} {what:<9} {min(took):.3f} s")


if __name__ == "__main__":
    main()
