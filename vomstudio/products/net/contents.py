"""Contents of a stereonet as plain data."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import GeometryError
from vomstudio.core.words import tr
from vomstudio.geology import stereonet as nets
from vomstudio.geology.common_rotation_errors import (
    ConfidenceRegion,
    RotationErrors,
    cone,
    differentiate_vectors,
    principal_axis,
    region,
)
from vomstudio.geology.density import SIGMA
from vomstudio.geology.folds import FoldAxis
from vomstudio.geology.notation import format_line, format_plane
from vomstudio.geology.orientation import (
    Line,
    Plane,
    lines_to_vectors,
    planes_to_poles,
    sin_cos_deg,
)
from vomstudio.geology.statistics import (
    axial_mean,
    fisher,
    no_fisher_reason,
    orientation_tensor,
)
from vomstudio.geometry.rotation_errors import enlarged_semi_axes

OKABE_ITO = (
    "#0072B2",
    "#D55E00",
    "#009E73",
    "#CC79A7",
    "#E69F00",
    "#56B4E9",
    "#F0E442",
    "#000000",
)
"""Colour-blind safe palette of Okabe & Ito, the colours most visible on white first."""

MARKERS = ("o", "s", "^", "D", "v", "P", "X", "<")
"""Symbols of sets; the star is that of the fold axis."""

USER_LINE_MARKER = "d"
"""Marker of lines entered by the user; it is not used for sets or means."""

MAX_AUTOMATIC_CIRCLES = 40
"""Maximum number of planes for which great circles are drawn by default.

More would hide the poles."""


@dataclass(frozen=True, eq=False)
class NetSet:
    """Set of features that share a symbol.

    Parameters
    ----------
    name : str
    kind : {"plane", "line"}
    azimuth_deg, angle_deg : (n,) arrays
        Dip direction and dip, or trend and plunge.
    ids : tuple of str
        Ids of the features, for selection; empty if they cannot be selected.
    color, marker : str
    variant : int
        Number that distinguishes sets with the same colour and symbol: filled, open, pale, deep,
        then again from the start.
    rotation_errors : RotationErrors or None
        Rotation errors due to the registrations of the models; None if unknown.
    slips : (n, 3) array or None
        Unit vectors of the hanging-wall movement at striae; NaN if unknown.
    group : str
        Group to which the set belongs, i.e. its feature type; empty if equal to `name`.
    """

    name: str
    kind: str
    azimuth_deg: FloatArray
    angle_deg: FloatArray
    ids: tuple[str, ...] = ()
    color: str = OKABE_ITO[0]
    marker: str = MARKERS[0]
    variant: int = 0
    rotation_errors: RotationErrors | None = None
    slips: FloatArray | None = None
    group: str = ""

    @property
    def group_name(self) -> str:
        """Name of the group of sets that are contoured together."""
        return self.group or self.name

    def vectors(self) -> FloatArray:
        """Return the unit vectors (n, 3) of the lines or of the poles of the planes."""
        to_vectors = planes_to_poles if self.kind == "plane" else lines_to_vectors
        return to_vectors(self.azimuth_deg, self.angle_deg).reshape(-1, 3)

    def __len__(self) -> int:
        return len(np.atleast_1d(self.azimuth_deg))


@dataclass(frozen=True)
class NetMean:
    """Mean of a set, drawn as a labelled mark.

    Parameters
    ----------
    line : Line
    label, color, marker : str
    orientation : str
        Mean line or mean plane as text, in the notation of the net.
    total : NetLineEllipse or None
        95 % ellipse including the registration error, if known.
    is_cluster_mean : bool
        Whether the line is Fisher's mean. Otherwise it is the first axis of the orientation tensor,
        because a girdle or a scattered set has no mean.
    """

    line: Line
    label: str
    color: str
    marker: str
    orientation: str = ""
    total: NetLineEllipse | None = None
    is_cluster_mean: bool = True


@dataclass(frozen=True)
class NetEllipse:
    """95 % ellipse of a plane's pole: semi-axes, and rake of the larger one, in degrees."""

    plane: Plane
    max_angle_deg: float
    min_angle_deg: float
    rake_deg: float

    @classmethod
    def enlarge_to_total(
        cls,
        plane: Plane,
        largest_deg: float,
        smallest_deg: float,
        rake_deg: float,
        total_deg: float,
    ) -> NetEllipse:
        """Enlarge the ellipse of a fit to the total error (see `enlarged_semi_axes`)."""
        major_deg, minor_deg = enlarged_semi_axes(largest_deg, smallest_deg, total_deg)
        return cls(plane, float(major_deg), float(minor_deg), rake_deg)

    def outline(self) -> list[FloatArray]:
        """Return the outline as polylines (k, 3) on the lower hemisphere."""
        return nets.pole_ellipse(self.plane, self.max_angle_deg, self.min_angle_deg, self.rake_deg)

    def pole_ellipse(self) -> NetLineEllipse:
        """Return the ellipse of the pole as a `NetLineEllipse`."""
        pole = self.plane.pole()
        sine, cosine = sin_cos_deg(self.rake_deg)
        direction = cosine * self.plane.strike_vector() + sine * self.plane.dip_vector()
        return NetLineEllipse(pole, self.max_angle_deg, self.min_angle_deg, np.asarray(direction))


@dataclass(frozen=True, eq=False)
class NetLineEllipse:
    """Joint 95 % ellipse of a line: semi-axes in degrees, and direction (3,) of the larger."""

    line: Line
    max_angle_deg: float
    min_angle_deg: float
    axis: FloatArray

    @classmethod
    def of(cls, vector: FloatArray, region: ConfidenceRegion) -> NetLineEllipse:
        """Build the ellipse of a confidence region about a unit vector (3,)."""
        line = Line.from_vector(vector)
        return cls(line, region.largest_deg, region.smallest_deg, region.axis)

    def outline(self) -> list[FloatArray]:
        """Return the outline as polylines (k, 3) on the lower hemisphere."""
        return nets.confidence_ellipse(
            self.line.vector(), self.axis, self.max_angle_deg, self.min_angle_deg
        )


def fold_ellipse(fold: FoldAxis) -> NetLineEllipse | None:
    """Return the 95 % ellipse of a fold axis, or None if it is unknown.

    It includes the registration error if this is known.
    """
    if fold.total is not None and fold.registration_error_deg is not None:
        return NetLineEllipse.of(fold.beta.vector(), fold.total)
    major_deg, minor_deg = fold.max_confidence95_deg, fold.min_confidence95_deg
    if major_deg is None or minor_deg is None or fold.confidence_axis is None:
        return None
    return NetLineEllipse(fold.beta, major_deg, minor_deg, fold.confidence_axis.vector())


@dataclass(frozen=True)
class NetCircle:
    """Great or small circle about an axis.

    Parameters
    ----------
    axis : Line
    half_angle_deg : float
        Half apical angle; 90 for a great circle.
    label : str
        Text in the legend.
    color : str or None
        Colour of the set to which the circle belongs; None for a circle entered by the user.
    """

    axis: Line
    half_angle_deg: float
    label: str
    color: str | None = None

    @property
    def dash(self) -> str:
        """Line style, which distinguishes great from small circles."""
        return "--" if self.half_angle_deg == 90.0 else ":"

    def outline(self) -> list[FloatArray]:
        """Return the circle as polylines (k, 3) on the lower hemisphere."""
        axis = self.axis.vector()
        first_axis = np.cross(axis, np.eye(3)[int(np.argmin(np.abs(axis)))])
        first_axis /= np.linalg.norm(first_axis)
        half_angle_deg = self.half_angle_deg
        return nets.cone_curve(
            axis, first_axis, np.cross(axis, first_axis), half_angle_deg, half_angle_deg, 361
        )


@dataclass(frozen=True, eq=False)
class NetBand:
    """Band of poles compatible with a straight trace: normals (k, 3) along its two edges."""

    edges: tuple[FloatArray, FloatArray]

    def outline(self) -> list[FloatArray]:
        """Return the edges as polylines (k, 3) on the lower hemisphere."""
        return [part for edge in self.edges for part in nets.split_at_primitive(edge)]


AnyEllipse = NetEllipse | NetLineEllipse | NetBand


@dataclass(frozen=True)
class NetMark:
    """Labelled mark of a direction.

    Parameters
    ----------
    line : Line
    label, marker : str
    color : str or None
        Colour of the set to which the mark belongs; None for a direction entered by the user.
    input_text : str
        Text that precedes the line in the label of a direction entered by the user.
    """

    line: Line
    label: str
    marker: str = "x"
    color: str | None = None
    input_text: str = ""


@dataclass(frozen=True)
class LiveFeature:
    """Feature being picked: its plane or line, with the 95 % ellipse if known."""

    plane: Plane | None = None
    line: Line | None = None
    ellipse: AnyEllipse | None = None

    @property
    def place(self) -> Line | None:
        """Pole of the plane, or the line itself; None if there is neither."""
        return self.line if self.plane is None else self.plane.pole()


@dataclass(frozen=True)
class Contouring:
    """Settings of density contours.

    Parameters
    ----------
    levels : tuple of float
        Contour levels in ascending order, in the unit of the method; empty for round levels.
    filled : bool or None
        Whether contours are filled. If None, they are filled for all features together and drawn as
        lines for each set.
    each_set : bool
        Whether each set has its own contours.
    sigma : float
        Kamb's sigma, which determines the counting circle; Schmidt's method does not use it.
    set_name : str or None
        Group of sets (`NetSet.group_name`) to contour; None for all sets.
    """

    levels: tuple[float, ...] = ()
    filled: bool | None = None
    each_set: bool = False
    sigma: float = SIGMA
    set_name: str | None = None

    @property
    def is_filled(self) -> bool:
        return not self.each_set if self.filled is None else self.filled


@dataclass(frozen=True, eq=False)
class NetContents:
    """Contents of a stereonet.

    Parameters
    ----------
    sets : tuple of NetSet
    projection : {"area", "angle"}
    circles : bool or None
        Whether to draw great circles of planes. If None, they are drawn for up to
        `MAX_AUTOMATIC_CIRCLES` planes.
    poles : bool
        Whether to draw the poles of planes, and the lines.
    means : tuple of NetMean
    fold : FoldAxis or None
    fold_not_good_count : int or None
        Number of planes of the fold axis that are not rated good; None if unknown.
    selected : frozenset of str
        Ids of highlighted features; their great circles are always drawn.
    ellipses : tuple
        95 % ellipses of the selected features.
    contour : str or None
        Density method of the contours, one of `density.DENSITY_METHODS`; None for no contours.
    contouring : Contouring
    user_circles : tuple of NetCircle
        Great and small circles entered by the user, and girdles.
    marks : tuple of NetMark
        Marked directions: density maxima, and slip lines entered by the user.
    errors : tuple
        95 % ellipses of all features with known errors.
    averages : tuple of str
        Sentences about each set, shown below the legend.
    live : LiveFeature or None
    notation, decimals
        Format of orientations.
    title, notes
        Text above the net, and text above its caption (frame, north, omissions).
    compact : bool
        Whether to use the short legend for the screen. It does not mention the ellipse of the
        selection, because the net would move at every click.
    brief : bool
        Whether the net is small. Its legend is omitted if it needs more than two rows, the
        projection and the averages are omitted, and a row at the bottom is left for the selection.
    north : bool
        Whether azimuths are from north; False in a local frame, where they are measured from the y
        axis.
    """

    sets: tuple[NetSet, ...] = ()
    projection: str = "area"
    circles: bool | None = None
    poles: bool = True
    means: tuple[NetMean, ...] = ()
    fold: FoldAxis | None = None
    fold_not_good_count: int | None = None
    selected: frozenset[str] = frozenset()
    ellipses: tuple[AnyEllipse, ...] = ()
    contour: str | None = None
    contouring: Contouring = Contouring()
    user_circles: tuple[NetCircle, ...] = ()
    marks: tuple[NetMark, ...] = ()
    errors: tuple[AnyEllipse, ...] = ()
    averages: tuple[str, ...] = ()
    live: LiveFeature | None = None
    notation: str = "dipdir/dip"
    decimals: int = 0
    title: str = ""
    notes: tuple[str, ...] = ()
    compact: bool = False
    brief: bool = False
    north: bool = True

    def replace_selection(
        self, selected_ids: Iterable[str], ellipses: Sequence[AnyEllipse] = ()
    ) -> NetContents:
        """Return a copy of the net with another selection."""
        return replace(self, selected=frozenset(selected_ids), ellipses=tuple(ellipses))


def make_sets(
    groups: Mapping[str, tuple[str, Sequence[float] | FloatArray, Sequence[float] | FloatArray]],
    ids: Mapping[str, Sequence[str]] | None = None,
    rotation_errors: Mapping[str, RotationErrors] | None = None,
) -> tuple[NetSet, ...]:
    """Build sets from {name: (kind, azimuths, angles)} with default colours and symbols.

    Features with NaN or infinite angles are omitted.

    Raises
    ------
    ValueError
        If a kind is neither "plane" nor "line".
    """
    sets = []
    for i, (name, (kind, azimuth, angle)) in enumerate(groups.items()):
        if kind not in ("plane", "line"):
            raise ValueError(kind)
        azimuths, angles = (
            np.asarray(azimuth, dtype=np.float64),
            np.asarray(angle, dtype=np.float64),
        )
        is_finite = np.isfinite(azimuths) & np.isfinite(angles)
        names = tuple(ids[name]) if ids and name in ids else ()
        finite_ids = (
            tuple(name for name, is_kept in zip(names, is_finite, strict=True) if is_kept)
            if names
            else ()
        )
        color = OKABE_ITO[i % len(OKABE_ITO)]
        marker = MARKERS[(i + i // len(OKABE_ITO)) % len(MARKERS)]
        selected_rotation_errors = (
            rotation_errors[name].of(is_finite)
            if rotation_errors and name in rotation_errors
            else None
        )
        sets.append(
            NetSet(
                name,
                kind,
                azimuths[is_finite],
                angles[is_finite],
                finite_ids,
                color,
                marker,
                rotation_errors=selected_rotation_errors,
            )
        )
    return tuple(sets)


def compute_means(
    sets: Iterable[NetSet], notation: str = "dipdir/dip", decimals: int = 0
) -> tuple[NetMean, ...]:
    """Compute the mean of every set with at least three features.

    For a cluster, this is Fisher's mean, otherwise the first axis of the orientation tensor. Sets
    for which neither is defined are omitted. Planes are averaged by their poles, and the mean plane
    is given as text.
    """
    set_list = list(sets)
    means = []
    for net_set in set_list:
        if len(net_set) < 3:
            continue
        vectors = net_set.vectors()
        is_directed = net_set.kind == "line" and bool((net_set.angle_deg < 0).any())
        has_mean = no_fisher_reason(vectors, is_directed) is None
        try:
            line = fisher(vectors, is_directed).mean if has_mean else axial_mean(vectors)
        except GeometryError:
            continue
        if net_set.kind == "plane":
            text = format_plane(line.normal_plane(), notation, decimals)
        else:
            text = format_line(line, decimals)
        # The colour and symbol identify the set. With many sets, names would not fit.
        label = text
        if len(set_list) == 1:
            label = (
                tr("Mean {orientation}", orientation=text)
                if has_mean
                else tr("Axis 1 {orientation}", orientation=text)
            )
        total_region = _total(net_set, line.vector())
        means.append(
            NetMean(line, label, net_set.color, net_set.marker, text, total_region, has_mean)
        )
    return tuple(means)


def describe_means(means: Sequence[NetMean]) -> str:
    """Describe the meaning of the open symbols of a net."""
    kinds = {mean.is_cluster_mean for mean in means}
    if kinds == {True}:
        return tr("Open symbol: Fisher mean")
    if kinds == {False}:
        return tr("Open symbol: axis 1 of the tensor")
    return tr("Open symbol: Fisher mean, or axis 1 of a girdle")


def _total(net_set: NetSet, mean: FloatArray) -> NetLineEllipse | None:
    """Return the 95 % ellipse of a mean (3,), from the registration and Fisher's cone.

    Returns None if the registration errors are unknown.
    """
    if net_set.rotation_errors is None or not net_set.rotation_errors.has_known_errors:
        return None
    vectors = net_set.vectors()
    eigenvalues, axes = orientation_tensor(vectors)
    covariance = principal_axis(
        differentiate_vectors(vectors, net_set.rotation_errors), eigenvalues, axes, 0
    ).covariance()[0]
    fisher_cone = None
    if no_fisher_reason(vectors, False) is None:
        alpha = fisher(vectors, False).alpha95_deg
        fisher_cone = None if alpha is None else cone(mean, alpha)
    return NetLineEllipse.of(mean, region(mean, covariance, fisher_cone))


def shows_all_circles(net: NetContents) -> bool:
    """Return whether the great circles of all planes are drawn."""
    if net.circles is not None:
        return net.circles
    return sum(len(set_) for set_ in net.sets if set_.kind == "plane") <= MAX_AUTOMATIC_CIRCLES
