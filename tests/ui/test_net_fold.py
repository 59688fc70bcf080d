"""The fold axis: one choice of planes for the net, the statistics and the view direction."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.ui.conftest import add_bed, add_cliff
from vomstudio.geology.common_rotation_errors import RotationErrors
from vomstudio.geology.fold_planes import FoldFilter
from vomstudio.geology.folds import fold_axis
from vomstudio.products.net.contents import NetContents
from vomstudio.project import edits, fold_planes
from vomstudio.project.edit import change
from vomstudio.project.fold_planes import FoldPlanes
from vomstudio.ui.panels.net.source import add_fold_axis
from vomstudio.ui.panels.statistics.statistics_panel import StatisticsPanel

DIPS = np.array([30.0, 35.0, 28.0, 40.0, 33.0, 27.0])
AZIMUTHS = np.array([100.0, 110.0, 95.0, 280.0, 270.0, 290.0])


@pytest.fixture
def found(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """One entry for each time that an axis was computed."""
    times: list[int] = []

    def counted(*words: object, **more: object) -> object:
        times.append(1)
        return fold_axis(*words, **more)

    fold_planes._axis.cache_clear()
    monkeypatch.setattr(fold_planes, "fold_axis", counted)
    return times


class Bed:
    name, id, overturned = "B", "b", False


BEDS = FoldPlanes((Bed(),) * 6, AZIMUTHS, DIPS, None, None, 1, ())


def beta(beds: FoldPlanes) -> tuple[float, float]:
    net = add_fold_axis(NetContents(sets=()), beds)
    assert net.fold is not None
    assert net.fold_not_good_count == beds.not_good
    return net.fold.beta.trend_deg, net.fold.error95_deg or 0.0


@pytest.mark.full
def test_fold_axis_is_cached_for_identical_beds(found: list[int]) -> None:
    first = beta(BEDS)
    assert beta(replace(BEDS, azimuth_deg=BEDS.azimuth_deg.copy())) == first
    assert len(found) == 1
    turned = beta(replace(BEDS, azimuth_deg=(BEDS.azimuth_deg + 30.0) % 360.0))
    assert (turned[0] - first[0]) % 360.0 == pytest.approx(30.0)
    assert len(found) == 2


def test_fold_axis_error_depends_on_the_registration(found: list[int]) -> None:
    group = np.zeros(6, np.int64)
    errors = [
        beta(
            replace(
                BEDS,
                rotation_errors=RotationErrors(group, np.eye(3)[None] * np.radians(degrees) ** 2),
            )
        )[1]
        for degrees in (1.0, 5.0)
    ]
    assert errors[0] < errors[1]
    assert len(found) == 2


@pytest.fixture
def beds(window, studio):
    """Six beds of two sets; those of the set "straight" are picked along lines."""
    add_cliff(studio)
    made = [add_bed(studio, f"t{k}", dip=0.3 + 0.3 * k, set_name="bent") for k in range(4)]
    bed = made[0]
    straight = [
        replace(
            bed,
            id=f"s{k}",
            name=f"S{k}",
            set_name="straight",
            vertices=tuple(
                (float(i), 0.1 * k * (-1) ** i, 5.0 + 0.1 * (i * 7 % 3)) for i in range(9)
            ),
        )
        for k in range(1, 3)
    ]
    studio.session.apply(change(studio.records, "Add straight", {t.id: t for t in straight}))
    window._add_stereonet()
    window.workspaces.switch("results")
    window.docks.bring_forward("statistics")
    return made


def axes(window, studio) -> list[tuple[float, float, int]]:
    """Beta and its count, by the net, the view direction and the planes of the statistics."""
    net = window.net.contents().fold
    view = window.view_panel._bedding.find_axis()
    statistics = studio.fold.planes().axis()
    return [(a.beta.trend_deg, a.beta.plunge_deg, a.n) for a in (net, view, statistics)]


def test_net_statistics_and_view_use_the_same_fold_axis(window, studio, beds) -> None:
    counts = []
    for which in (
        FoldFilter(),
        FoldFilter("doubtful"),
        FoldFilter(set_name="bent"),
        FoldFilter("doubtful", "bent"),
    ):
        studio.fold.choose(which, is_selected=False)
        net, view, statistics = axes(window, studio)
        assert net == view == statistics
        counts.append(net[2])
    assert counts[0] == 6
    assert counts[1] < 6
    assert counts[2] == 4
    measured = studio.measured([f.id for f in studio.fold.features()])
    bad = sum(m.verdict.quality != "good" for m in measured.values())
    studio.fold.choose(FoldFilter(), is_selected=False)
    assert studio.fold.planes().not_good == window.net.contents().fold_not_good_count == bad > 0
    text = window.findChild(StatisticsPanel)
    text.update_widgets()
    assert f"{bad} not rated good" in text.figures.toPlainText()


@pytest.mark.full
def test_fold_axis_can_use_only_the_selected_planes(window, studio, beds) -> None:
    studio.selection.set(["t0", "t1", "t2"])
    studio.fold.choose(FoldFilter(), is_selected=True)
    assert [each[2] for each in axes(window, studio)] == [3, 3, 3]
    assert window.view_panel.selected_only_box.isChecked()
    studio.selection.set(["t0", "t1", "t2", "t3"])
    assert [each[2] for each in axes(window, studio)] == [4, 4, 4]


@pytest.mark.full
def test_fold_filter_is_shared_by_all_panels(window, studio, beds) -> None:
    first = window.view_panel.fold_box
    second = window.findChild(StatisticsPanel).fold_box
    first.set.setCurrentIndex(first.set.findData("bent"))
    quality = first.options.fields["quality"]
    quality.setCurrentIndex(quality.findData("good"))
    quality.activated.emit(quality.currentIndex())
    assert studio.fold.fold_filter == FoldFilter("good", "bent")
    assert (second.options.options().quality, second.set.currentData()) == ("good", "bent")
    assert studio.attempt(edits.delete, ["t3"])
    assert second.set.currentData() == "bent"
