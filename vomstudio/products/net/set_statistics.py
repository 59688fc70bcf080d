"""What is found in the sets of a net and drawn on it: girdles, densest places, averages."""

from __future__ import annotations

from collections.abc import Collection, Iterable
from dataclasses import replace

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
from vomstudio.products.net.contours import contoured_groups

_LEAST = 3
"""Of fewer neither a girdle nor a mean is found."""


def with_findings(net: NetContents, asked: Collection[str]) -> NetContents:
    """The net with what is asked for: "girdles", "maxima", "averages"."""
    if "girdles" in asked:
        girdles, others = girdles_of(net.sets, net.notation, net.decimals)
        said = tr("No girdle (K above 1): {sets}", sets=", ".join(others))
        net = replace(
            net,
            circles_typed=(*net.circles_typed, *girdles),
            notes=(*net.notes, said) if others else net.notes,
        )
    if "maxima" in asked:
        net = replace(net, marks=(*net.marks, *maxima_of(net)))
    if "averages" in asked:
        net = replace(net, averages=averages_of(net.sets, net.notation, net.decimals))
    return net


def girdles_of(
    sets: Iterable[NetSet], notation: str = "dipdir/dip", decimals: int = 0
) -> tuple[tuple[NetCircle, ...], tuple[str, ...]]:
    """The plane that the poles or lines of each set fit best, across the third axis of their
    orientation tensor; and the names of the sets that are no girdles, by Woodcock's K, which is
    above 1 in clusters (1977, Geological Society of America Bulletin 88, 1231-1236)."""
    found, others = [], []
    for s in sets:
        if not len(s):
            continue
        values, axes = orientation_tensor(s.vectors())
        shape = woodcock(values)[0]
        if len(s) < _LEAST or shape is None or shape > 1.0:
            others.append(s.name)
            continue
        across = Line.from_vector(axes[2])
        label = tr(
            "{set}, girdle {plane} (K {shape:.2f})",
            set=s.name,
            plane=format_plane(across.normal_plane(), notation, decimals),
            shape=shape,
        )
        found.append(NetCircle(across, 90.0, label, s.color))
    return tuple(found), tuple(others)


def maxima_of(net: NetContents) -> tuple[NetMark, ...]:
    """Where each set lies densest, or all together where they are contoured so; by the method of
    the contours, else by Kamb's with an exponential kernel."""
    method = net.contour or "exponential_kamb"
    look = net.contouring
    groups = (
        contoured_groups(net)
        if net.contour is not None
        else [(s, s.vectors()) for s in net.sets if len(s)]
    )
    found = []
    for of, vectors in groups:
        if len(vectors) < _LEAST:
            continue
        place, top = find_maximum(vectors, method, look.sigma)
        line = Line.from_vector(place)
        unit = "% / 1 %" if method == "schmidt" else "σ"
        label = tr(
            "max {line}, {top:.1f} {unit}", line=format_line(line, net.decimals), top=top, unit=unit
        )
        found.append(NetMark(line, label, "+", None if of is None else of.color))
    return tuple(found)


def averages_of(
    sets: Iterable[NetSet], notation: str = "dipdir/dip", decimals: int = 0
) -> tuple[str, ...]:
    """Each set in a sentence: n, the mean with its method, kappa and alpha95; of what is no cluster
    the axes of the tensor, and why there is no mean."""
    return tuple(_average(s, notation, decimals) for s in sets if len(s))


def _average(s: NetSet, notation: str, decimals: int) -> str:
    vectors, n = s.vectors(), len(s)
    directed = s.kind == "line" and bool((s.angle_deg < 0).any())

    def said(line: Line) -> str:
        if s.kind == "plane":
            return format_plane(line.normal_plane(), notation, decimals)
        return format_line(line, decimals)

    if n < 2:
        return tr("{set}: n = {n:,}", set=s.name, n=n)
    if no_fisher_reason(vectors, directed) is None:
        found = fisher(vectors, directed)
        figures = []
        if found.kappa is not None:
            # Of some planes that are as good as alike more digits are chance.
            kappa = (
                f"{found.kappa:.1f}"
                if found.kappa < 100.0
                else f"{float(f'{found.kappa:.2g}'):,.0f}"
            )
            figures.append(f"κ\N{NO-BREAK SPACE}{kappa}")
        if found.alpha95_deg is not None:
            figures.append(f"α95\N{NO-BREAK SPACE}{found.alpha95_deg:.1f}°")
        return tr(
            "{set}: n = {n:,}, Fisher mean {mean}, {figures}",
            set=s.name,
            n=n,
            mean=said(found.mean),
            figures=", ".join(figures) or tr("all alike"),
        )
    values, axes = orientation_tensor(vectors)
    _, girdle, random = vollmer(values)
    if girdle > random:
        return tr(
            "{set}: n = {n:,}, girdle (G {share:.2f}) about {axis}, by the tensor",
            set=s.name,
            n=n,
            share=girdle,
            axis=format_line(Line.from_vector(axes[2]), decimals),
        )
    return tr("{set}: n = {n:,}, scattered (R {share:.2f}): no mean", set=s.name, n=n, share=random)
