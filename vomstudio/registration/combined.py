"""A similarity estimated by other means, as one observation with its covariance."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.registration.observations import Rows
from vomstudio.registration.similarity import Similarity, jacobian


@dataclass(frozen=True, eq=False)
class Combined:
    """Similarity as an observation, such as the fit of a model to another one.

    Attributes
    ----------
    start : Similarity
        Model to World.
    about : (3,) array
        World, centre of its errors of rotation and scale.
    whitening : (m, 7) array
        Its products with a turn about east, north and up (rad), a relative change of scale and a
        shift (m), all about `about`, are independent with the variance 1. m < 7 if directions are
        undetermined.
    size : float
        RMS distance of the fitted points from `about`, metres.
    scale_error : float
        Relative error of a fixed scale, one sigma; 0 if fitted.
    scale_response : (7,) array or None
        Change of the fit per relative error of the fixed scale; its fourth component is 1. None if
        the scale was fitted.
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
        """Return the size of rows (m,) in metres at `about` and in degrees."""
        numbers = np.linalg.pinv(self.whitening) @ error
        return float(np.linalg.norm(numbers[4:])), float(np.degrees(np.linalg.norm(numbers[:3])))


def difference(fit: Similarity, other: Similarity, about: FloatArray) -> FloatArray:
    """Return the change that transforms one similarity into another.

    Parameters
    ----------
    fit, other : Similarity
        The change transforms the result of `other` into that of `fit`.
    about : (3,) ndarray
        Place of World that the change refers to.

    Returns
    -------
    (7,) ndarray
        Turn, relative change of scale, and shift.
    """
    from scipy.spatial.transform import Rotation

    turn = Rotation.from_matrix(fit.rotation @ other.rotation.T).as_rotvec()
    shift = fit(other.inverse(about[None]))[0] - about
    return np.concatenate([turn, [np.log(fit.scale / other.scale)], shift])
