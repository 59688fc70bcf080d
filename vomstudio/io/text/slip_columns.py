"""Names of the columns of a table of faults with slip."""

from __future__ import annotations

SLIP_NAMES: dict[str, tuple[str, ...]] = {
    "dip_direction": (
        "on_plane_dip_direction_deg",
        "dip_direction_deg",
        "dip_direction",
        "dipdir",
        "dip_dir",
        "dd",
    ),
    "strike": ("strike", "strike_rhr_deg", "strike_rhr", "fault_strike"),
    "fault_azimuth": ("fault_azimuth", "fazi"),
    "dip": ("on_plane_dip_deg", "dip_deg", "dip", "fault_dip", "finc", "fault_inclination"),
    "slip_rake": ("slip_rake_deg", "slip_rake"),
    "trend": ("trend_deg", "trend", "azimuth", "striae_trend", "line_trend", "lazi"),
    "plunge": ("plunge_deg", "plunge", "striae_plunge", "line_plunge", "linc"),
    "rake": ("rake_deg", "rake", "pitch"),
    "sense": ("sense", "slip_sense", "slip", "movement"),
    "id": ("name", "label", "id"),
}
"""Names by meaning; the first match is used."""
