"""How long a redraw of the net takes: `python -m tests.benchmarks.bench_net`.

The promise on two free cores is 0.15 s for 30 poles, 0.25 s for 3,000 contoured and 0.45 s for
10,000 contoured. Emphasising a selection draws over the kept picture, which takes a few
milliseconds. The peer is mplstereonet alone: the same poles, its own contours, and no legend. Runs
of both are interleaved; the median and the range of each are printed, elapsed and processor time.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from time import perf_counter, process_time

import numpy as np

from vomstudio.geology.orientation import normals_to_planes
from vomstudio.products.net.contents import Contouring, NetContents, make_sets
from vomstudio.products.net.net_axes import import_mplstereonet
from vomstudio.products.net.style import NetStyle

_SIDE = 500
_RUNS = 7
_TARGETS_S = {
    (30, None): 0.15,
    (3_000, "exponential_kamb"): 0.25,
    (10_000, "exponential_kamb"): 0.45,
}


def clusters(n: int) -> NetContents:
    """A net with two sets of n poles in all."""
    rng = np.random.default_rng(1)
    normals = rng.normal(size=(n, 3)) + np.repeat([[3, 1, -2], [-1, 2, -4]], n // 2, axis=0)
    azimuth, dip = normals_to_planes(normals)[:2]
    halves = {name: slice(i * n // 2, (i + 1) * n // 2) for i, name in enumerate("ab")}
    names = {name: [f"{name}{i}" for i in range(n // 2)] for name in "ab"}
    sets = make_sets({name: ("plane", azimuth[h], dip[h]) for name, h in halves.items()}, names)
    return NetContents(sets, compact=True)


def interleaved(*works: Callable[[], object]) -> list[str]:
    """Median and range of the seconds of each work, run in turn after one run of each."""
    times: list[list[tuple[float, float]]] = [[] for _ in works]
    for number in range(_RUNS + 1):
        for work, seconds in zip(works, times, strict=True):
            wall, cpu = perf_counter(), process_time()
            work()
            if number:
                seconds.append((perf_counter() - wall, process_time() - cpu))
    texts = []
    for seconds in times:
        (low, low_cpu), (high, high_cpu) = np.min(seconds, axis=0), np.max(seconds, axis=0)
        wall, cpu = np.median(seconds, axis=0)
        texts.append(
            f"{wall:.4f} s ({low:.4f}..{high:.4f}), CPU {cpu:.4f} s ({low_cpu:.4f}..{high_cpu:.4f})"
        )
    return texts


def draw_peer(net: NetContents, contour: str | None) -> None:
    """Draw the poles, and contours of all of them, with mplstereonet alone."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(_SIDE / 100, _SIDE / 100), dpi=100)
    canvas = FigureCanvasAgg(figure)
    import_mplstereonet()
    ax = figure.add_axes((0.1, 0.1, 0.8, 0.8), projection="equal_area_stereonet")
    strike = np.concatenate([s.azimuth_deg for s in net.sets]) - 90.0
    dip = np.concatenate([s.angle_deg for s in net.sets])
    if contour is not None:
        ax.density_contourf(strike, dip.copy(), method=contour)  # type: ignore[attr-defined]
    ax.pole(strike, dip.copy(), "o", markersize=3)  # type: ignore[attr-defined]
    canvas.draw()


def main() -> None:
    os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")
    from dataclasses import replace

    from vomstudio.ui.panels.net.canvas import DPI, DrawnNet, NetRequest

    style = NetStyle.dock(dpi=DPI, font_px=12)

    def redraw(net: NetContents) -> DrawnNet:
        # Copies of the sets, because the contours of the same sets are computed once.
        fresh = replace(net, sets=tuple(replace(set_) for set_ in net.sets))
        drawn = DrawnNet.draw(NetRequest(fresh, style, (_SIDE, _SIDE), 1.0))
        drawn.image()
        return drawn

    for (n, method), target in _TARGETS_S.items():
        net = replace(clusters(n), contour=method)
        drawn = redraw(net)
        drawn.artists.select(net.sets[0].ids[:3])
        took, peer, emphasis = interleaved(
            lambda net=net: redraw(net),
            lambda net=net, method=method: draw_peer(net, method),
            drawn.image,
        )
        print(f"{n:>6,} {method or 'no contours'} (target {target:.2f} s)")
        print(f"       redraw       {took}")
        print(f"       mplstereonet {peer}")
        print(f"       emphasis     {emphasis}")
    net = clusters(10_000)
    for method in (None, "linear_kamb", "kamb", "schmidt"):
        shown = [
            replace(net, contour=method, contouring=Contouring(each_set=each))
            for each in (False, True)
        ]
        together, each_set = interleaved(*(lambda one=one: redraw(one) for one in shown))
        print(f"10,000 {method or 'no contours'}\n       together     {together}")
        print(f"       each set     {each_set}")


if __name__ == "__main__":
    main()
