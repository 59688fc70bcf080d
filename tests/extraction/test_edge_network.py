"""Edges of a network whose answer is known: a derivative, written as ONNX by hand."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.extraction.small_onnx import convolution
from tests.messages import refused
from vomstudio.core.errors import Cancelled, UsageError
from vomstudio.core.progress import CancelToken, SilentProgress
from vomstudio.extraction.proposals.edge_network import EdgeNetwork
from vomstudio.extraction.proposals.edge_pictures import colour_by_edges, write_edges
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Material, Mesh

# Half of the difference of grey between the pixels to either side.
SOBEL = np.zeros((1, 3, 3, 3))
SOBEL[0, :, 1, 0], SOBEL[0, :, 1, 2] = -1.0 / 6.0, 1.0 / 6.0


def network(folder: Path, raw: bytes) -> Path:
    path = folder / "net.onnx"
    path.write_bytes(raw)
    return path


def by_hand(picture: np.ndarray) -> np.ndarray:
    grey = picture.astype(np.float64).mean(axis=2) / 255.0
    return np.abs(grey[1:-1, 2:] - grey[1:-1, :-2]) / 2.0


@pytest.mark.parametrize("size", [("h", "w"), (64, 96)])
@pytest.mark.parametrize("shape", [(40, 50), (64, 96), (700, 1130)])
def test_probability_of_every_pixel_matches_closed_form(tmp_path, size, shape) -> None:
    picture = np.random.default_rng(2).integers(0, 256, (*shape, 3), np.uint8)
    net = EdgeNetwork(network(tmp_path, convolution(SOBEL, after=["Abs"], size=size)))
    result = net.compute_probability(picture, SilentProgress())
    assert result.shape == shape
    # Also where tiles meet.
    np.testing.assert_allclose(result[1:-1, 1:-1], by_hand(picture), atol=1e-5)


def test_single_channel_network_is_supported(tmp_path) -> None:
    picture = np.full((64, 64, 3), 90, np.uint8)
    weights = np.zeros((1, 1, 1, 1)) + 0.5
    net = EdgeNetwork(network(tmp_path, convolution(weights)))
    assert net.compute_probability(picture, SilentProgress()) == pytest.approx(
        np.full((64, 64), 45 / 255.0)
    )


@pytest.mark.parametrize(
    ("raw", "code", "values"),
    [
        (b"", "file.other-format", {"format": "ONNX"}),
        (b"not a network at all" * 50, "file.other-format", {"format": "ONNX"}),
        (convolution(SOBEL)[:90], "file.other-format", {"format": "ONNX"}),
        (convolution(np.zeros((1, 4, 3, 3))), "network.input-shape", {"shape": "1 x 4 x ? x ?"}),
        (convolution(SOBEL, size=(8, 8)), "network.input-size", {"side": 8, "minimum": 16}),
        (convolution(SOBEL, after=["NoSuchOperator"]), "network.not-loaded", {}),
    ],
)
def test_invalid_networks_are_refused(tmp_path, raw, code, values) -> None:
    with refused(code, file=tmp_path / "net.onnx", **values):
        EdgeNetwork(network(tmp_path, raw)).compute_probability(
            np.zeros((64, 64, 3), np.uint8), SilentProgress()
        )


@pytest.mark.parametrize(
    ("raw", "code", "values"),
    [
        (
            convolution(np.zeros((2, 3, 3, 3))),
            "network.output-shape",
            {"shape": "1 x 2 x 64 x 64", "width": 64, "height": 64},
        ),
        (convolution(SOBEL, pads=0), "network.output-shape", {"shape": "1 x 1 x 62 x 62"}),
        (convolution(SOBEL, after=["Log"]), "network.not-finite", {}),
        (convolution(SOBEL, bias=7.0), "network.not-probabilities", {"low": 7.0, "high": 7.0}),
    ],
)
def test_invalid_network_output_is_refused(tmp_path, raw, code, values) -> None:
    net = EdgeNetwork(network(tmp_path, raw))
    with refused(code, **values):
        net.compute_probability(np.zeros((64, 64, 3), np.uint8), SilentProgress())


def test_missing_and_huge_networks_are_refused_and_run_is_cancellable(tmp_path) -> None:
    with refused("file.unreadable", file=tmp_path / "none.onnx"):
        EdgeNetwork(tmp_path / "none.onnx")
    huge = tmp_path / "huge.onnx"
    with huge.open("wb") as stream:
        stream.truncate(1 << 30)
    with refused("file.too-large", limit_mb=512):
        EdgeNetwork(huge)
    token = CancelToken()
    token.cancel()
    net = EdgeNetwork(network(tmp_path, convolution(SOBEL, after=["Abs"])))
    with pytest.raises(Cancelled):
        net.compute_probability(np.zeros((64, 64, 3), np.uint8), SilentProgress(token))


def test_textures_are_replaced_by_edges(tmp_path) -> None:
    from PIL import Image

    picture = np.zeros((64, 64, 3), np.uint8)
    picture[:, 32:] = 200
    Image.fromarray(picture).save(tmp_path / "t.png")
    mesh = Mesh(
        np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], float),
        np.array([[0, 1, 2]]),
        uv=np.array([[0, 0], [1, 0], [0, 1]], np.float32),
        materials=(Material("t", tmp_path / "t.png"), Material("plain")),
        material_offsets=np.array([0, 1, 1]),
    )
    net = network(tmp_path, convolution(SOBEL, after=["Abs"]))
    output = colour_by_edges(
        mesh, 1.0, lambda p, f: write_edges(net, p, f, SilentProgress()), tmp_path / "e"
    )
    worn = np.asarray(Image.open(output.materials[0].texture))
    assert worn.shape == (64, 64)
    assert output.materials[1].texture is None
    edge = round(255 * (1.0 - 200 / 255 / 2.0))
    assert set(worn[:, [31, 32]].ravel().tolist()) == {edge}
    assert (np.delete(worn, [31, 32], axis=1)[:, :60] == 255).all()


def test_visible_points_are_coloured_by_edges(tmp_path) -> None:
    y, x = (a.ravel() * 0.1 for a in np.mgrid[0:40, 0:60])
    colours = np.where(x[:, None] < 2.95, 40, 240) * np.ones(3)
    behind = np.flatnonzero((np.abs(y - 2.0) < 0.01) & (x > 1.5) & (x < 4.5))
    hidden = np.column_stack([x, y, np.full(len(x), -5.0)])[behind]
    points = np.concatenate([np.column_stack([x, y, 0.01 * y]), hidden, [[np.nan] * 3]])
    shades = np.concatenate([colours, colours[behind], [[0, 0, 0]]]).astype(np.uint8)
    cloud = PointCloud(points, colors=shades)
    net = network(tmp_path, convolution(SOBEL, after=["Abs"]))
    find = lambda p, f: write_edges(net, p, f, SilentProgress())  # noqa: E731
    output = colour_by_edges(cloud, 0.1, find, tmp_path / "e").colors
    grey = output[:, 0].astype(int)
    inner = (y > 0.35) & (y < 3.55) & (x > 0.35) & (x < 5.55)
    # The picture may lie a little askew to the rows of points.
    assert np.median(grey[: len(x)][inner & (np.abs(x - 2.95) < 0.1)]) < 200
    assert grey[: len(x)][inner & (np.abs(x - 2.95) > 0.25)].min() >= 250
    assert (grey[len(x) :] == 255).all()
    with refused("model.no-colours", UsageError, field="--cost"):
        colour_by_edges(replace(cloud, colors=None), 0.1, find, tmp_path / "e")
