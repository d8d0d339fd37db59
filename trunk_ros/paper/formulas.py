"""Table 2, figures 5 and 6 of Ciofu & Stan: as printed, as the formulas give, how the print came about."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from trunk_ros.arm import Wire
from trunk_ros.compiled import Array

ARCMIN = np.pi / 180 / 60  # rad
LIMIT = np.radians(23.0)
LINK = 0.05  # m, the nominal arm's: the paper prints no value of l
FINE_SECTION = np.pi * 0.38e-3**2 / 4  # m^2, of a wire of 0.38 mm; the paper rounds it to 0.113 mm^2

PRINTED_EFFICIENCY = ("96.07", "96.30", "96.30", "96.30", "96.30")  # %
PRINTED_ELONGATION = ("5.1184", "6.5111", "7.8997", "9.2882", "10.6768")  # um
PRINTED_DEVIATION = ("0.335", "0.4262", "0.5170", "0.6079", "0.6988")  # °, in the text minutes
PRINTED_FIGURES = (50, 20)  # um, "about": the largest error of joint 5 along y and z

FORMULAS, FINE = "formulas, Table 1", "same, A_s = π·0.38²/4"
DIFFERENTLY, MODEL = "done differently", "eq. (6), nominal model"


@dataclass(frozen=True)
class Quantity:
    """A line of the paper: ``printed`` to the letter; ``rows`` maps other ways to (5,) values in ``unit``."""

    title: str
    unit: str
    digits: int
    printed: tuple[str, ...]
    rows: dict[str, Array]
    difference: str
    """What was done differently, in words."""

    def cells(self) -> dict[str, list[str]]:
        """All ways as text, with as many digits as are printed."""
        rows = {way: [f"{value:.{self.digits}f}" for value in values] for way, values in self.rows.items()}
        return {"as printed": list(self.printed)} | rows


def elongation(wire: Wire) -> Array:
    """Stretch (joints,) m by eq. (7), which is eq. (6) with T' = T_i/k_i."""
    first, second = wire.mu1 * wire.a1, wire.mu2 * wire.a2
    pulled = np.exp(first) * wire.length1 + wire.length2
    return np.asarray(wire.pull_tension * pulled / (wire.modulus * wire.section * np.exp(2 * first + second)))


def deviation(wire: Wire) -> Array:
    """Angular deviation (joints,) rad by eq. (7) and (8)."""
    return elongation(wire) / wire.cylinder_radius


def swapped_deviation(wire: Wire) -> Array:
    """What Table 2 prints as angles (joints,): eq. (8) in minutes with pi/180 for 180/pi, um over mm."""
    stretch = np.array(PRINTED_ELONGATION, dtype=float)
    return np.asarray(60 * np.pi / 180 * stretch / (wire.cylinder_radius * 1e3))


def printed_deviation() -> Array:
    """The angles of Table 2 (joints,) rad, read as minutes."""
    return np.array(PRINTED_DEVIATION, dtype=float) * ARCMIN


def positioning_error(angle: float | Array, off: Array) -> tuple[Array, Array]:
    """|dy| and |dz| (n, joints) m of each joint alone, eq. (11)-(17).

    ``angle`` (n,) rad is where it stands, ``off`` (joints,) rad how far from there.
    """
    reach = LINK * np.arange(1, len(off) + 1)
    turned = np.atleast_1d(angle)[:, None]
    dy = reach * (np.sin(turned + off) - np.sin(turned))
    dz = reach * (np.cos(turned + off) - np.cos(turned))
    return np.abs(dy), np.abs(dz)


def quantities(wire: Wire) -> list[Quantity]:
    """Table 2 line by line, then the largest values of figures 5 and 6."""
    return [_efficiency(wire), _elongation(wire), _deviation(wire), *_figures(wire)]


def _efficiency(wire: Wire) -> Quantity:
    smooth = replace(wire, mu1=np.full(5, 0.03), mu2=np.full(5, 0.02))
    return Quantity(
        "Table 2, k_i·100",
        "%",
        2,
        PRINTED_EFFICIENCY,
        {FORMULAS: 100 * wire.efficiency, DIFFERENTLY: 100 * smooth.efficiency},
        "mu1 = 0.03, mu2 = 0.02 in place of 0.10, 0.08; and it is 1/k_i of eq. (5), the force that arrives.",
    )


def _elongation(wire: Wire) -> Quantity:
    fine = replace(wire, section=FINE_SECTION)
    alike = replace(fine, a2=np.full(5, 0.4189))
    return Quantity(
        "Table 2, Δl_i",
        "µm",
        4,
        PRINTED_ELONGATION,
        {
            FORMULAS: 1e6 * elongation(wire),
            FINE: 1e6 * elongation(fine),
            DIFFERENTLY: 1e6 * elongation(alike),
            MODEL: 1e6 * wire.elongation,
        },
        "A_s = π·0.38²/4 = 0.113411 mm², and a2 = 0.4189 at joint 1 as well; mu is 0.10, 0.08 here, "
        "unlike in k_i. Eq. (7) has a factor 1/k_i more than eq. (6) with T' = T_i, which the nominal model "
        "takes.",
    )


def _deviation(wire: Wire) -> Quantity:
    fine = replace(wire, section=FINE_SECTION)
    return Quantity(
        "Table 2, Δθ_i",
        "arcmin",
        4,
        PRINTED_DEVIATION,
        {
            FORMULAS: deviation(wire) / ARCMIN,
            FINE: deviation(fine) / ARCMIN,
            DIFFERENTLY: swapped_deviation(wire),
            MODEL: wire.dead_band / ARCMIN,
        },
        "60·(π/180)·Δl[µm]/R_c[mm] of the printed Δl: degrees and radians are swapped in eq. (8), so that "
        "the angles come out too small by (180/π)²/1000 = 3.28. The table says degrees, the text minutes.",
    )


def _figures(wire: Wire) -> list[Quantity]:
    ways = {FORMULAS: deviation(wire), DIFFERENTLY: printed_deviation()}
    places = (("Fig. 5, largest Δy_i (θ = 0)", 0.0), ("Fig. 6, largest Δz_i (θ = 23°)", LIMIT))
    difference = "the Δθ as printed, taken as minutes, with l = 50 mm (no value of l is printed)."
    return [
        Quantity(
            title,
            "µm",
            1,
            ("", "", "", "", f"~{PRINTED_FIGURES[axis]}"),
            {way: 1e6 * positioning_error(angle, off)[axis][0] for way, off in ways.items()},
            difference,
        )
        for axis, (title, angle) in enumerate(places)
    ]
