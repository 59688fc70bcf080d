"""A similarity that was found by other means, as one observation with its covariance."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.registration.observations import Rows
from vomstudio.registration.similarity import Similarity, jacobian


@dataclass(frozen=True, eq=False)
class Combined:
    """Such as the fit of a model to another one.

    start : the similarity that was found, model to World; about : (3,) World, what its errors turn
        and grow about
    whitening : (m, 7) whose products with a turn about east, north and up (rad), a relative change
        of scale and a shift (m), all about there, are independent with the variance 1; m is under
        7 where it leaves something free
    size : m, how far what was fitted typically reaches from there
    scale_error : relative error of a scale that was fixed in the fit, one sigma; 0 if fitted
    scale_response : (7,) change of the fit per relative error of the fixed scale; its fourth
        component is 1. None if the scale was fitted
    """

    labels: Sequence[str]
    start: Similarity
    about: FloatArray
    whitening: FloatArray
    size: float = 1.0
    scale_error: float = 0.0
    scale_response: FloatArray | None = None

    @property
    def scale_change(self) -> FloatArray:
        """Return the change (m,) of the residuals per relative error of the fixed scale."""
        if self.scale_response is None:
            return np.zeros(len(self.whitening))
        return np.asarray(-self.whitening @ self.scale_response)

    def rows(self, fit: Similarity, centre: FloatArray) -> Rows:
        moves: FloatArray = np.zeros((7, 7))
        moves[:4, :4] = np.eye(4)
        moves[4:] = jacobian(self.about - np.asarray(centre, np.float64).ravel())
        m = len(self.whitening)
        return Rows(
            self.whitening @ difference(fit, self.start, self.about),
            self.whitening @ moves,
            np.ones(m),
            (self.labels[0],) * m,
            (self.labels[0],) * m,
            np.zeros((m, 0)),
            np.zeros(0),
        )

    def size_of(self, error: FloatArray) -> tuple[float, float]:
        """How large rows (m,) are, in metres at `about` and degrees."""
        numbers = np.linalg.pinv(self.whitening) @ error
        return float(np.linalg.norm(numbers[4:])), float(np.degrees(np.linalg.norm(numbers[:3])))


def difference(fit: Similarity, other: Similarity, about: FloatArray) -> FloatArray:
    """(7,) turn, relative change of scale and shift about a place of World, that take what `other`
    makes of the model to what `fit` makes of it."""
    from scipy.spatial.transform import Rotation

    turn = Rotation.from_matrix(fit.rotation @ other.rotation.T).as_rotvec()
    shift = fit(other.inverse(about[None]))[0] - about
    return np.concatenate([turn, [np.log(fit.scale / other.scale)], shift])
