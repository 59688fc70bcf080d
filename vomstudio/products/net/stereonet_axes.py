"""The net on axes of mplstereonet, for scripts that go on drawing there."""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np

from vomstudio.geology.orientation import lines_to_vectors
from vomstudio.geology.stereonet import density
from vomstudio.products.net.contents import NetContents, NetSet, circles_shown
from vomstudio.words import tr

_GRID = 101
_CONTOURS = "Greys"


def _library() -> Any:
    with warnings.catch_warnings():
        # It was written for an older matplotlib.
        warnings.simplefilter("ignore")
        import mplstereonet

    return mplstereonet


def new_axes(projection: str) -> Any:
    """Axes in a new figure of pyplot; projection : "area" or "angle"."""
    import matplotlib.pyplot as plt

    _library()
    figure = plt.figure(figsize=(8.0, 5.0))
    # Room for the legend beside the net.
    figure.subplots_adjust(left=0.04, right=0.66)
    ax = figure.add_subplot(projection=f"equal_{projection}_stereonet")
    ax.grid(color="0.85", linewidth=0.5)
    return ax


def are_axes(ax: Any) -> bool:
    return isinstance(ax, _library().StereonetAxes)


def draw_net(ax: Any, net: NetContents) -> None:
    """Density, great circles, poles and lines, and means, with a legend of the sets."""
    if net.contour is not None:
        _draw_density(ax, net, net.contour)
    for s in net.sets:
        if s.kind == "plane" and circles_shown(net):
            # Copies: the library writes into what it is given.
            ax.plane(_strikes(s), s.angle_deg.copy(), color=s.color, linewidth=0.7, alpha=0.6)
    for s in net.sets:
        style = {"marker": s.marker, "color": s.color, "markersize": 5, "label": _label(s)}
        if s.kind == "plane":
            ax.pole(_strikes(s), s.angle_deg.copy(), **style)
        else:
            _plot_lines(ax, s.azimuth_deg, s.angle_deg, **style)
    for mean in net.means:
        _plot_lines(
            ax,
            np.array([mean.line.trend_deg]),
            np.array([mean.line.plunge_deg]),
            marker="*",
            markersize=12,
            markerfacecolor=mean.color,
            markeredgecolor="black",
            label=tr("Mean {orientation}", orientation=mean.orientation),
        )
    ax.legend(loc="upper left", bbox_to_anchor=(1.1, 1.0), frameon=False, fontsize="small")


def _plot_lines(ax: Any, trend_deg: Any, plunge_deg: Any, **style: Any) -> None:
    """As one artist with one entry in the legend; the library's own `line` makes one of each."""
    ax.plot(*_library().line(plunge_deg.copy(), trend_deg.copy()), linestyle="None", **style)


def _strikes(s: NetSet) -> Any:
    return (s.azimuth_deg - 90.0) % 360.0


def _label(s: NetSet) -> str:
    if s.kind == "plane":
        return tr("{set}, poles (n = {count:,})", set=s.name, count=len(s))
    return tr("{set}, lines (n = {count:,})", set=s.name, count=len(s))


def _draw_density(ax: Any, net: NetContents, method: str) -> None:
    """By our own kernels, at the places of the library's axes."""
    across = np.linspace(-np.pi / 2, np.pi / 2, _GRID)
    longitude, latitude = np.meshgrid(across, across)
    plunge, bearing = _library().geographic2plunge_bearing(longitude.ravel(), latitude.ravel())
    at = lines_to_vectors(bearing, plunge)
    data = np.concatenate([s.vectors() for s in net.sets])
    values = density(data, at, method).reshape(longitude.shape)
    ax.contourf(longitude, latitude, values, 8, cmap=_CONTOURS, alpha=0.8, zorder=0)
