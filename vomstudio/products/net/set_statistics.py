"""Statistics of sets that are drawn on a net: girdles, maxima and averages."""

from __future__ import annotations

from collections.abc import Collection, Iterable
from dataclasses import replace

from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.geology.density import find_maximum
from vomstudio.geology.notation import format_line, format_plane
from vomstudio.geology.orientation import Line
from vomstudio.geology.statistics import (
    fisher,
    no_fisher_reason,
    orientation_tensor,
    vollmer,
    woodcock,
)
from vomstudio.products.net.contents import NetCircle, NetContents, NetMark, NetSet
from vomstudio.products.net.contours import ContourPlan, contour_groups

_MIN_FEATURES = 3
"""Minimum number of features in a set for a girdle or a mean."""


def add_statistics(net: NetContents, requested_names: Collection[str]) -> NetContents:
    """Add the requested statistics, "girdles", "maxima" or "averages", to a net."""
    if "girdles" in requested_names:
        girdles, other_sets = fit_girdles(net.sets, net.notation, net.decimals)
        note = Finding("net.no-girdle", sets=other_sets).message
        net = replace(
            net,
            user_circles=(*net.user_circles, *girdles),
            notes=(*net.notes, note) if other_sets else net.notes,
        )
    if "maxima" in requested_names:
        net = replace(net, marks=(*net.marks, *find_maxima(net)))
    if "averages" in requested_names:
        net = replace(net, averages=describe_sets(net.sets, net.notation, net.decimals))
    return net


def fit_girdles(
    sets: Iterable[NetSet], notation: str = "dipdir/dip", decimals: int = 0
) -> tuple[tuple[NetCircle, ...], tuple[str, ...]]:
    """Fit a girdle to each set, perpendicular to the third axis of its orientation tensor.

    Sets for which Woodcock's K exceeds 1 are clusters (Woodcock 1977, Geological Society of America
    Bulletin 88, 1231-1236). They have no girdle, and neither do sets of fewer than three features.

    Returns
    -------
    girdles : tuple of NetCircle
    others : tuple of str
        Names of the sets that are not girdles.
    """
    girdles, scattered_sets = [], []
    for set_ in sets:
        if not len(set_):
            continue
        eigenvalues, axes = orientation_tensor(set_.vectors())
        shape = woodcock(eigenvalues)[0]
        if len(set_) < _MIN_FEATURES or shape is None or shape > 1.0:
            scattered_sets.append(set_.name)
            continue
        girdle_axis = Line.from_vector(axes[2])
        label = tr(
            "{set}, girdle {plane} (K {shape:.2f})",
            set=set_.name,
            plane=format_plane(girdle_axis.normal_plane(), notation, decimals),
            shape=shape,
        )
        girdles.append(NetCircle(girdle_axis, 90.0, label, set_.color))
    return tuple(girdles), tuple(scattered_sets)


def find_maxima(net: NetContents) -> tuple[NetMark, ...]:
    """Find the density maximum of each set, or of all features if contoured together.

    Sets with fewer than three features are omitted. The method is that of the contours or, if there
    are none, Kamb's with an exponential kernel.
    """
    method = net.contour or "exponential_kamb"
    contouring = net.contouring
    plan = ContourPlan.of(net)
    groups = (
        [(set_, set_.vectors(), None) for set_ in net.sets if len(set_)]
        if plan is None
        else [
            (set_, vectors, part.values)
            for (set_, vectors), part in zip(contour_groups(net), plan.parts, strict=True)
        ]
    )
    maxima = []
    for contoured_set, vectors, grid in groups:
        if len(vectors) < _MIN_FEATURES:
            continue
        direction, top = find_maximum(vectors, method, contouring.sigma, grid)
        line = Line.from_vector(direction)
        unit = "% / 1 %" if method == "schmidt" else "σ"
        label = tr(
            "max {line}, {top:.1f} {unit}", line=format_line(line, net.decimals), top=top, unit=unit
        )
        maxima.append(
            NetMark(line, label, "+", None if contoured_set is None else contoured_set.color)
        )
    return tuple(maxima)


def describe_sets(
    sets: Iterable[NetSet], notation: str = "dipdir/dip", decimals: int = 0
) -> tuple[str, ...]:
    """Describe each set in a sentence with n, the mean and its method, kappa and alpha95.

    For a set without a mean, the sentence contains the third axis of the orientation tensor and G
    if the set is a girdle, or R if it is scattered. For a single feature, it contains only n.
    """
    return tuple(_describe_set(set_, notation, decimals) for set_ in sets if len(set_))


def _describe_set(net_set: NetSet, notation: str, decimals: int) -> str:
    vectors, n = net_set.vectors(), len(net_set)
    is_directed = net_set.kind == "line" and bool((net_set.angle_deg < 0).any())

    def format_orientation(line: Line) -> str:
        if net_set.kind == "plane":
            return format_plane(line.normal_plane(), notation, decimals)
        return format_line(line, decimals)

    if n < 2:
        return tr("{set}: n = {n:,}", set=net_set.name, n=n)
    if no_fisher_reason(vectors, is_directed) is None:
        fisher_mean = fisher(vectors, is_directed)
        figures = []
        if fisher_mean.kappa is not None:
            # If planes are nearly identical, further digits of kappa are random.
            kappa = (
                f"{fisher_mean.kappa:.1f}"
                if fisher_mean.kappa < 100.0
                else f"{float(f'{fisher_mean.kappa:.2g}'):,.0f}"
            )
            figures.append(f"κ\N{NO-BREAK SPACE}{kappa}")
        if fisher_mean.alpha95_deg is not None:
            figures.append(f"α95\N{NO-BREAK SPACE}{fisher_mean.alpha95_deg:.1f}°")
        return tr(
            "{set}: n = {n:,}, Fisher mean {mean}, {figures}",
            set=net_set.name,
            n=n,
            mean=format_orientation(fisher_mean.mean),
            figures=", ".join(figures) or tr("all identical"),
        )
    eigenvalues, axes = orientation_tensor(vectors)
    _, girdle, random = vollmer(eigenvalues)
    if girdle > random:
        return tr(
            "{set}: n = {n:,}, girdle (G {share:.2f}) about {axis}, from the tensor",
            set=net_set.name,
            n=n,
            share=girdle,
            axis=format_line(Line.from_vector(axes[2]), decimals),
        )
    return tr(
        "{set}: n = {n:,}, scattered (R {share:.2f}): no mean", set=net_set.name, n=n, share=random
    )
