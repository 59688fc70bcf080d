"""Similarity estimated by other means, as a single observation with its covariance."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.registration.observations import Rows
from vomstudio.registration.similarity import Similarity, jacobian


@dataclass(frozen=True, eq=False)
class SimilarityObservation:
    """Similarity as an observation, such as the fit of a model to another model.

    Attributes
    ----------
    start : Similarity
        Similarity from the model to the World frame.
    rotation_centre : (3,) array
        Centre of the errors of rotation and scale, in the World frame.
    whitening : (m, 7) array
        Matrix whose products with a rotation about east, north and up (rad), a relative change of
        scale and a translation (m), all about `rotation_centre`, are independent with variance 1.
        m < 7 if directions are undetermined.
    size : float
        RMS distance of the fitted points from `rotation_centre`, metres.
    scale_error : float
        Relative one-sigma error of a fixed scale; 0 if the scale was fitted.
    scale_response : (7,) array or None
        Change of the fit per relative error of the fixed scale, with a fourth component of 1; None
        if the scale was fitted.
    """

    labels: Sequence[str]
    start: Similarity
    rotation_centre: FloatArray
    whitening: FloatArray
    size: float = 1.0
    scale_error: float = 0.0
    scale_response: FloatArray | None = None

    @property
    def scale_derivative(self) -> FloatArray:
        """Change (m,) of the residuals per relative error of the fixed scale."""
        if self.scale_response is None:
            return np.zeros(len(self.whitening))
        return np.asarray(-self.whitening @ self.scale_response)

    def rows(self, fit: Similarity, centre: FloatArray) -> Rows:
        design: FloatArray = np.zeros((7, 7))
        design[:4, :4] = np.eye(4)
        design[4:] = jacobian(self.rotation_centre - np.asarray(centre, np.float64).ravel())
        m = len(self.whitening)
        return Rows(
            self.whitening @ difference(fit, self.start, self.rotation_centre),
            self.whitening @ design,
            np.ones(m),
            (self.labels[0],) * m,
            (self.labels[0],) * m,
            np.zeros((m, 0)),
            np.zeros(0),
        )

    def error_sizes(self, error: FloatArray) -> tuple[float, float]:
        """Return the size of errors (m,) in metres at `rotation_centre` and in degrees."""
        components = np.linalg.pinv(self.whitening) @ error
        return float(np.linalg.norm(components[4:])), float(
            np.degrees(np.linalg.norm(components[:3]))
        )


def difference(fit: Similarity, other: Similarity, centre: FloatArray) -> FloatArray:
    """Return the change that transforms one similarity into another.

    Parameters
    ----------
    fit, other : Similarity
        The change transforms the result of `other` into that of `fit`.
    centre : (3,) ndarray
        Centre of the change in the World frame.

    Returns
    -------
    (7,) ndarray
        Rotation, relative change of scale, and translation.
    """
    from scipy.spatial.transform import Rotation

    rotation = Rotation.from_matrix(fit.rotation @ other.rotation.T).as_rotvec()
    shift = fit(other.inverse(centre[None]))[0] - centre
    return np.concatenate([rotation, [np.log(fit.scale / other.scale)], shift])
