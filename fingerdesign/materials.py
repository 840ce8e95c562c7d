"""Elastomers and plate metals by name; each value with its source, or said to be assumed.

The elastomers' values are small-strain ones and typical only: batches, cure and age move them by
tens of percent, so measure yours and give it in the file's ``[materials.NAME]`` table. Where a
maker gives only a Shore A hardness S, Young's modulus follows Gent's relation (A. N. Gent, "On the
relation between indentation hardness and Young's modulus", Rubber Chem. Technol. 31 (1958) 896).
Poisson's ratio of an elastomer is below 0.5 by about E / (6 K), K = 1 to 2 GPa: 0.4995 and above;
0.49 is what displacement elements carry without locking and what the literature usually assumes.
"""

from dataclasses import dataclass


@dataclass(frozen=True)
class MaterialData:
    """Isotropic linear elasticity: Young's modulus in MPa, Poisson's ratio, where both are from."""

    youngs_modulus_MPa: float
    poissons_ratio: float
    source: str


def gent_youngs_modulus(shore_a: float) -> float:
    """Young's modulus in MPa of a rubber of Shore A hardness ``shore_a``.

    Gent 1958: E = 0.0981 (56 + 7.62336 S) / (0.137505 (254 - 2.54 S)), for 20 <= S <= 80 good to
    about 20 %. Raises ValueError outside (0, 100).

    >>> round(gent_youngs_modulus(30.0), 2)
    1.14
    """
    if not 0.0 < shore_a < 100.0:
        raise ValueError(f"Shore A hardness {shore_a} is outside (0, 100)")
    return 0.0981 * (56.0 + 7.62336 * shore_a) / (0.137505 * (254.0 - 2.54 * shore_a))


def gent_shore_a(youngs_modulus_MPa: float) -> float:
    """The Shore A hardness at which Gent's relation gives a Young's modulus (MPa, above 0.09).

    >>> round(gent_shore_a(gent_youngs_modulus(30.0)), 6)
    30.0
    """
    scale = 0.137505 * youngs_modulus_MPa
    return (254.0 * scale - 0.0981 * 56.0) / (0.0981 * 7.62336 + 2.54 * scale)


_ASSUMED_RATIO = "Poisson's ratio assumed: nearly incompressible"


def _shore(name: str, shore_a: float) -> MaterialData:
    source = f"{name}, Shore A {shore_a:g} by its maker, E by Gent 1958; {_ASSUMED_RATIO}"
    return MaterialData(round(gent_youngs_modulus(shore_a), 3), 0.49, source)


MATERIALS: dict[str, MaterialData] = {
    # Elastomers
    "silicone": MaterialData(
        4.96, 0.49, f"E from Maeno, Hiromitsu and Kawai 2000; {_ASSUMED_RATIO}"
    ),
    "dragon_skin_20": _shore("Smooth-On Dragon Skin 20", 20.0),
    "dragon_skin_30": _shore("Smooth-On Dragon Skin 30", 30.0),
    "sylgard_184": MaterialData(
        1.8,
        0.49,
        "Dow Sylgard 184 at 10:1 cured near 65 degrees C, typical; Johnston et al., "
        f"J. Micromech. Microeng. 24 (2014) 035017 (1.3 to 3 MPa by cure); {_ASSUMED_RATIO}",
    ),
    "polyurethane_60a": _shore("casting polyurethane", 60.0),
    # Plate materials
    "phosphor_bronze": MaterialData(
        1.35e5,
        0.33,
        "E from Maeno, Hiromitsu and Kawai 2000; Poisson's ratio assumed: typical of C51000",
    ),
    "spring_steel": MaterialData(
        2.1e5, 0.30, "typical of carbon steels, EN 1993-1-1 clause 3.2.6 (210 GPa, 0.3)"
    ),
    "stainless_steel": MaterialData(
        2.0e5, 0.30, "typical of austenitic grades, EN 1993-1-4 clause 2.1.3 (200 GPa, 0.3)"
    ),
    "beryllium_copper": MaterialData(
        1.31e5, 0.30, "typical of C17200, Copper Development Association data (19 Mpsi)"
    ),
    # Cores, nails and backings
    "abs": MaterialData(2.2e3, 0.37, "typical of printed ABS; assumed, take your filament's value"),
    "pla": MaterialData(3.3e3, 0.36, "typical of printed PLA; assumed, take your filament's value"),
    "aluminium": MaterialData(7.0e4, 0.30, "EN 1999-1-1 clause 3.2.5 (70 GPa, 0.3)"),
    "polyimide": MaterialData(
        2.5e3, 0.34, "DuPont Kapton HN data sheet at 23 degrees C (2.5 GPa, 0.34)"
    ),
}
