"""Lines that are proposed: known beds are found, noise is doubted, the world may be turned."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import pytest

from tests.messages import refused
from tests.tiers import first_in_default_tier
from vomstudio.core.errors import Cancelled, UsageError
from vomstudio.core.progress import CancelToken, Progress, SilentProgress
from vomstudio.extraction.proposals.traces import ProposedTraces, propose_traces
from vomstudio.extraction.surface_graph import SurfaceGraph
from vomstudio.extraction.trace_options import ProposalOptions
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Mesh

Array = npt.NDArray[np.float64]
RESOLUTION = 0.05
BEDS = {0.5: 60.0, 1.4: 30.0}


def slope(seed: int, beds: dict[float, float], ledge: float = 0.0) -> tuple[Array, Array]:
    """Points and grey values: beds level at these heights, so much darker than the noisy rest."""
    random = np.random.default_rng(seed)
    y, x = (a.ravel() * RESOLUTION for a in np.mgrid[0:60, 0:60])
    x = x + random.normal(0.0, 0.005, len(x))
    z = 0.6 * y + 0.2 * np.sin(3.0 * x) + random.normal(0.0, 0.003, len(x))
    grey = 128.0 + random.normal(0.0, 10.0, len(x))
    for height, darker in beds.items():
        grey -= darker * (np.abs(z - height) < 0.04)
    z += ledge * (y > 1.5)
    return np.column_stack([x, y, z]), grey


def proposed(
    points: Array,
    grey: Array | None,
    cost: str,
    progress: Progress | None = None,
    **requests: object,
) -> ProposedTraces:
    colours = None if grey is None else np.repeat(grey[:, None], 3, axis=1).astype(np.uint8)
    options = ProposalOptions(cost=cost, **{"min_length_m": 1.0, **requests})  # type: ignore[arg-type]
    return propose_traces(
        SurfaceGraph(PointCloud(points, colors=colours)),
        options,
        resolution=RESOLUTION,
        model="slope",
        frame="local",
        progress=progress or SilentProgress(),
    )


def test_dark_beds_are_proposed_with_darkest_first() -> None:
    result = proposed(*slope(1, BEDS), "dark").proposals
    sure = [one for one in result if one.doubt < 0.05]
    heights = [min(BEDS, key=lambda z, p=one.points: abs(z - p[:, 2].mean())) for one in sure]
    assert heights[0] == 0.5
    assert set(heights) == set(BEDS)
    for one, height in zip(sure, heights, strict=True):
        # The rows of points are 0.03 m apart in height, and a bed is 0.04 m to each side.
        off = np.abs(one.points[:, 2] - height)
        assert np.percentile(off, 90) < RESOLUTION
        assert one.length_m >= 1.0
    assert [one.doubt for one in result] == sorted(one.doubt for one in result)
    first = sure[0].plane
    assert first is not None
    assert first["dip_deg"] < max(float(first["total95_deg"]), 2.0)


@pytest.mark.full
@pytest.mark.parametrize("cost", first_in_default_tier(["dark", "gradient", "curvature"], 1))
def test_noise_gives_almost_no_confident_proposals(cost: str) -> None:
    sure = 0
    for seed in range(4):
        result = proposed(*slope(10 + seed, {}), cost, min_length_m=0.5).proposals
        sure += any(one.doubt < 0.05 for one in result)
    # One in fifty surfaces would have such a line.
    assert sure <= 1


def test_a_ledge_of_a_mesh_is_found_by_its_edges() -> None:
    points, _ = slope(3, {}, ledge=0.3)
    n = 60
    first = (np.arange(n - 1)[:, None] * n + np.arange(n - 1)).ravel()
    faces = np.concatenate(
        [
            np.stack([first, first + 1, first + n], 1),
            np.stack([first + 1, first + n + 1, first + n], 1),
        ]
    )
    result = propose_traces(
        SurfaceGraph(Mesh(points, faces)),
        ProposalOptions(cost="curvature", min_length_m=1.0, max_lines=5),
        resolution=RESOLUTION,
        model="ledge",
        frame="local",
        progress=SilentProgress(),
    )
    best = result.proposals[0]
    assert best.doubt < 0.05
    assert best.length_m > 2.5
    assert np.abs(best.points[:, 1] - 1.525).max() <= 1.5 * RESOLUTION


def test_rotating_model_rotates_the_proposals() -> None:
    points, grey = slope(1, BEDS)
    c, s = np.cos(np.radians(30.0)), np.sin(np.radians(30.0))
    # Clockwise seen from above, as azimuths grow.
    turn = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    tilt = np.array([[1.0, 0.0, 0.0], [0.0, 0.8, 0.6], [0.0, -0.6, 0.8]])
    for move in (np.eye(3), tilt):
        one = proposed(points @ move, grey, "dark").proposals
        other = proposed(points @ move @ turn, grey, "dark").proposals
        assert len(one) == len(other)
        assert [a.doubt for a in one] == [b.doubt for b in other]
        assert [a.length_m for a in one] == pytest.approx([b.length_m for b in other])
        a, b = one[0].plane, other[0].plane
        assert a is not None
        assert b is not None
        if move is tilt:
            change = float(b["dip_direction_deg"]) - float(a["dip_direction_deg"])
            assert change % 360.0 == pytest.approx(30.0, abs=1e-6)


def test_invalid_proposal_options_are_refused() -> None:
    points, grey = slope(1, BEDS)
    with refused("model.no-colours", UsageError, field="--cost"):
        proposed(points, None, "dark")
    with refused("option.not-a-choice", UsageError, value="shade", field="--cost"):
        proposed(points, grey, "shade")
    with refused("cost.needs-way-points", cost="colour"):
        proposed(points, grey, "colour")
    with refused("option.not-a-length", field="--min-length"):
        proposed(points, grey, "dark", min_length_m=float("nan"))
    with refused("option.too-small", field="--max-lines", minimum=1):
        proposed(points, grey, "dark", max_lines=0)


def test_search_is_cancellable_and_uniform_surface_has_no_proposals() -> None:
    points, grey = slope(1, BEDS)
    token = CancelToken()
    token.cancel()
    with pytest.raises(Cancelled):
        proposed(points, grey, "dark", progress=SilentProgress(token))
    assert proposed(points, np.full(len(points), 90.0), "dark").proposals == ()


@pytest.mark.full
def test_a_bed_in_the_texture_of_large_faces_is_found(tmp_path) -> None:
    """Nine squares of a metre wear a picture with a dark bed of 0.08 m."""
    from PIL import Image

    from vomstudio.geometry.mesh import Material

    size, at, half = 600, 1.3, 0.04
    up = 3.0 * (np.arange(size)[::-1, None] + 0.5) / size
    grey = 150.0 + np.random.default_rng(4).normal(0.0, 10.0, (size, size))
    grey -= 60.0 * (np.abs(up - at) < half)
    Image.fromarray(np.clip(grey, 0, 255).astype(np.uint8)).convert("RGB").save(tmp_path / "a.png")
    v, u = (a.ravel().astype(float) for a in np.mgrid[0:4, 0:4])
    first = np.array([4 * j + i for j in range(3) for i in range(3)])
    faces = np.concatenate(
        [np.stack([first, first + 1, first + 4], 1), np.stack([first + 1, first + 5, first + 4], 1)]
    )
    mesh = Mesh(
        np.column_stack([u, 0.5 * v, v]),
        faces,
        uv=np.column_stack([u, v]) / 3.0,
        materials=(Material("a", tmp_path / "a.png"),),
        material_offsets=np.array([0, len(faces)]),
    )
    result = propose_traces(
        SurfaceGraph(mesh),
        ProposalOptions(cost="dark", min_length_m=2.0, max_lines=5),
        resolution=1.0,
        model="wall",
        frame="local",
        progress=SilentProgress(),
    )
    best = result.proposals[0]
    assert best.doubt < 0.05
    assert best.length_m > 2.5
    assert np.percentile(np.abs(best.points[:, 2] - at), 90) < half


def test_line_is_split_where_it_turns_back() -> None:
    from vomstudio.extraction.proposals.lines import _split_at_turns

    there = np.column_stack([np.linspace(0.0, 5.0, 51), np.zeros(51), np.zeros(51)])
    back = there[::-1] + [0.0, 0.2, 0.0]
    places = np.concatenate([there, back])
    parts = sorted(_split_at_turns(places, np.arange(len(places))), key=lambda part: int(part[0]))
    assert int(parts[0][0]) == 0
    assert len(parts) == 2
    # The turn belongs to both.
    assert abs(int(parts[0][-1]) - 50) <= 1
    assert len(_split_at_turns(there, np.arange(51))) == 1


def test_line_is_simplified_to_way_points_and_known_lines_matched() -> None:
    from vomstudio.extraction.proposals.known_lines import match_known_lines, simplify_line

    x = np.linspace(0.0, 10.0, 201)
    line = np.column_stack([x, np.abs(x - 5.0), np.zeros(201)])
    assert simplify_line(line, 0.01, 12).tolist() == [0, 100, 200]
    wave = np.column_stack([x, np.sin(2.0 * x), 0.3 * x])
    assert len(simplify_line(wave, 0.001, 7)) == 7
    assert match_known_lines([line, line + [0.0, 0.0, 1.0], line[:40]], [line[50:]], 0.1) == [
        True,
        False,
        False,
    ]


def test_very_large_cloud_is_sampled() -> None:
    from vomstudio.extraction.proposals.thinning import sample_points

    points, grey = slope(1, BEDS)
    colours = np.repeat(grey[:, None], 3, axis=1).astype(np.uint8)
    cloud = PointCloud(points, colors=colours, fields={"grey": grey})
    part = sample_points(cloud, 1800)
    assert len(part.points) == 1800
    rows = {tuple(p): i for i, p in enumerate(points.tolist())}
    at = [rows[tuple(p)] for p in part.points.tolist()]
    assert len(set(at)) == 1800
    assert part.colors is not None
    assert (part.colors == colours[at]).all()
    assert (part.fields["grey"] == grey[at]).all()
    # From all of it alike.
    assert abs(np.mean(np.array(at) < len(points) / 2) - 0.5) < 0.05
