"""How kernels are compiled, and what they are given."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numba
import numpy as np
import pytest

from vomstudio.geometry.kernels.jit import fastmath_part, kernel, part, step, to_kernel_array


@pytest.fixture(params=["machine code", "numba"])
def way(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> str:
    """Both ways on which a kernel can run; nothing was compiled before."""
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    if request.param == "numba":
        monkeypatch.setattr("sys.platform", "where nobody has tried machine code")
    return str(request.param)


@pytest.fixture
def asked(monkeypatch: pytest.MonkeyPatch) -> list[dict[str, Any]]:
    """What numba is asked for; it can keep nothing on disk."""
    compiled_function, options = numba.njit, []

    def njit(*signature: str, **wanted: Any) -> Any:
        options.append(wanted)
        if wanted.get("cache"):
            raise RuntimeError("cannot cache function: no locator available")
        return compiled_function(*signature, **wanted)

    monkeypatch.setattr(numba, "njit", njit)
    return options


def test_kernel_is_compiled_without_cache_if_cache_is_unavailable(
    asked: list[dict[str, Any]],
) -> None:
    assert kernel("f8(f8)", fastmath=True)(lambda x: 2.0 * x).compile_with_numba()(1.5) == 3.0
    kept, anew = asked[:2]
    assert kept == {"nogil": True, "fastmath": True, "cache": True}
    assert anew == {"nogil": True, "fastmath": True}


@pytest.mark.usefixtures("way")
@pytest.mark.parametrize("piece", [part, step])
def test_sums_are_evaluated_in_source_order(piece: Any) -> None:
    """A sum of which the small part is lost in rounding tells."""
    added = piece(lambda a, b: a + b)
    assert kernel("f8(f8, f8)")(lambda a, b: added(a, b) - a)(1e16, 1.0) == 0.0


def test_kernels_release_the_gil() -> None:
    for piece in (part, step, fastmath_part):
        assert piece(lambda x: x).compiled_function().targetoptions["nogil"]
    assert fastmath_part(lambda x: x).compiled_function().targetoptions["fastmath"]


@pytest.mark.usefixtures("way")
def test_kernels_modify_arrays_in_place_and_return_numbers() -> None:
    def work(table, rows, flag, factor, out):  # type: ignore[no-untyped-def]
        for i in range(rows.shape[0]):
            for j in range(table.shape[1]):
                out[i, j] = table[rows[i], j] * factor if flag else -1.0
        return rows.shape[0], table.shape[1], out.shape[0]

    signature = "Tuple((i8, i8, i8))(f8[:,::1], i4[:], boolean, float64, f4[:,::1])"
    table, out = np.arange(12.0).reshape(4, 3), np.zeros((2, 3), np.float32)
    rows = np.array([3, 9, 1, 9], np.int32)[::2]
    assert kernel(signature)(work)(table, rows, True, 0.5, out) == (2, 3, 2)
    assert np.array_equal(out, table[[3, 1]] * 0.5)
    assert kernel(signature)(work)(table, rows, False, 0.5, out) == (2, 3, 2)
    assert (out == -1).all()


@pytest.mark.usefixtures("way")
@pytest.mark.parametrize(
    "wrong",
    [
        np.zeros((2, 2), np.float32),
        np.zeros(4),
        np.zeros((4, 4))[::2, ::2],
        np.asfortranarray(np.arange(4.0).reshape(2, 2)),
        [[1.0, 2.0], [3.0, 4.0]],
        None,
    ],
)
def test_arguments_not_matching_the_signature_are_rejected(wrong: Any) -> None:
    def first(a, n):  # type: ignore[no-untyped-def]
        return a[0, 0]

    sound = kernel("f8(f8[:,::1], i8)")(first)
    assert sound(np.full((2, 2), 7.0), 3) == 7.0
    locked = np.zeros((2, 2))
    locked.flags.writeable = False
    for args in [(wrong, 3), (locked, 3), (np.zeros((2, 2)),), (np.zeros((2, 2)), 3, 3)]:
        with pytest.raises(TypeError):
            sound(*args)
    with pytest.raises(OverflowError):
        sound(np.zeros((2, 2)), 1 << 64)


@pytest.mark.usefixtures("way")
def test_exception_inside_kernel_propagates() -> None:
    with pytest.raises(ZeroDivisionError):
        kernel("i8(i8, i8)")(lambda a, b: a // b)(1, 0)


@pytest.mark.usefixtures("way")
def test_kernel_can_allocate_memory() -> None:
    """Which machine code alone does not get: numba's runtime gives it."""

    def doubled(a):  # type: ignore[no-untyped-def]
        return (a + a).sum()

    assert kernel("f8(f8[::1])")(doubled)(np.arange(4.0)) == 12.0


def test_an_array_is_copied_for_a_kernel_only_where_it_must_be() -> None:
    sound = np.arange(6.0).reshape(3, 2)
    assert to_kernel_array(sound, np.float64) is sound
    locked = sound.copy()
    locked.flags.writeable = False
    for other in (locked, sound[::-1], np.asfortranarray(sound), np.float32(sound), sound.tolist()):
        found = to_kernel_array(other, np.float64)
        assert found.flags.c_contiguous
        assert found.flags.writeable
        assert found.dtype == np.float64
        assert np.array_equal(found, other)
