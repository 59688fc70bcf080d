"""How kernels are compiled, and what they are given."""

from __future__ import annotations

from typing import Any

import numba
import numpy as np
import pytest

from vomstudio.geometry.kernels.jit import fast_part, for_kernels, kernel, part, step


@pytest.fixture
def asked(monkeypatch: pytest.MonkeyPatch) -> list[dict[str, Any]]:
    """What numba is asked for; it can keep nothing on disk."""
    compiled, options = numba.njit, []

    def njit(*signature: str, **wanted: Any) -> Any:
        options.append(wanted)
        if wanted.get("cache"):
            raise RuntimeError("cannot cache function: no locator available")
        return compiled(*signature, **wanted)

    monkeypatch.setattr(numba, "njit", njit)
    return options


def test_where_nothing_can_be_kept_a_kernel_is_compiled_anew_and_the_same(
    asked: list[dict[str, Any]],
) -> None:
    assert kernel("f8(f8)", fastmath=True)(lambda x: 2.0 * x)(1.5) == 3.0
    kept, anew = asked[:2]
    assert kept == {"nogil": True, "fastmath": True, "cache": True}
    assert anew == {"nogil": True, "fastmath": True}


@pytest.mark.usefixtures("asked")
@pytest.mark.parametrize("piece", [part, step])
def test_sums_are_made_in_the_order_in_which_they_stand(piece: Any) -> None:
    """A sum of which the small part is lost in rounding tells."""
    added = piece(lambda a, b: a + b)
    assert kernel("f8(f8, f8)")(lambda a, b: added(a, b) - a)(1e16, 1.0) == 0.0


@pytest.mark.usefixtures("asked")
def test_no_kernel_keeps_other_threads_waiting() -> None:
    for piece in (part, step, fast_part):
        assert piece(lambda x: x).targetoptions["nogil"]
    assert fast_part(lambda x: x).targetoptions["fastmath"]


def test_an_array_is_copied_for_a_kernel_only_where_it_must_be() -> None:
    sound = np.arange(6.0).reshape(3, 2)
    assert for_kernels(sound, np.float64) is sound
    locked = sound.copy()
    locked.flags.writeable = False
    for other in (locked, sound[::-1], np.asfortranarray(sound), np.float32(sound), sound.tolist()):
        found = for_kernels(other, np.float64)
        assert found.flags.c_contiguous
        assert found.flags.writeable
        assert found.dtype == np.float64
        assert np.array_equal(found, other)
