"""Elastomers and plate metals by name; each value with its source, or marked as assumed.

The elastomers' values are small-strain ones and typical only: batches, cure and age move them by
tens of percent, so measure yours (``fingerdesign identify``) and give it in the file's
``[materials.NAME]`` table. Where a
maker gives only a Shore A hardness S, Young's modulus follows Gent's relation (A. N. Gent, "On the
relation between indentation hardness and Young's modulus", Rubber Chem. Technol. 31 (1958) 896).
Poisson's ratio of an elastomer is below 0.5 by about E / (6 K), K = 1 to 2 GPa: 0.4995 and above;
0.49 is what displacement elements carry without locking and what the literature usually assumes.
"""

from dataclasses import dataclass

# Sources disagree if the greatest published modulus is more than this multiple of the least.
DISAGREEMENT = 1.25
_PSI = 0.00689476  # MPa
_ASSUMED_RATIO = "Poisson's ratio assumed: nearly incompressible"


@dataclass(frozen=True)
class MaterialData:
    """Isotropic linear elasticity: Young's modulus in MPa, Poisson's ratio, where both are from.

    published_MPa: the least and the greatest modulus of its sources, where these differ;
    published_by: the sources of the others.
    """

    youngs_modulus_MPa: float
    poissons_ratio: float
    source: str
    published_MPa: tuple[float, float] | None = None
    published_by: str = ""

    @property
    def modulus_ratio(self) -> float:
        """The greatest published modulus over the least; 1 where there is only one."""
        return 1.0 if self.published_MPa is None else self.published_MPa[1] / self.published_MPa[0]


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


def stretched_youngs_modulus(stress_at_double_MPa: float) -> float:
    """Young's modulus in MPa of a neo-Hookean rubber by its "100 % modulus".

    The nominal stress (MPa) at stretch 2 is G (2 - 1/4), and E = 3 G.

    >>> round(stretched_youngs_modulus(0.593), 3)
    1.017
    """
    return 3.0 * stress_at_double_MPa / 1.75


def _shore(name: str, shore_a: float, stretched_psi: float | None = None) -> MaterialData:
    """A rubber by its Shore A hardness; its modulus at 100 % (psi) gives another one."""
    source = f"{name}, Shore A {shore_a:g} by its maker, E by Gent 1958; {_ASSUMED_RATIO}"
    modulus = round(gent_youngs_modulus(shore_a), 3)
    if stretched_psi is None:
        return MaterialData(modulus, 0.49, source)
    other = round(stretched_youngs_modulus(stretched_psi * _PSI), 3)
    published = (min(modulus, other), max(modulus, other))
    words = f"{other:g} MPa by its maker's {stretched_psi:g} psi at 100 %, neo-Hookean"
    return MaterialData(modulus, 0.49, source, published, words)


def _stretched(name: str, hardness: str, stretched_psi: float) -> MaterialData:
    """A rubber too soft for Shore A, by its modulus at 100 % (psi)."""
    modulus = round(stretched_youngs_modulus(stretched_psi * _PSI), 3)
    source = (
        f"{name}, {hardness} by its maker, E neo-Hookean by its {stretched_psi:g} psi at 100 %; "
        f"{_ASSUMED_RATIO}"
    )
    return MaterialData(modulus, 0.49, source)


MATERIALS: dict[str, MaterialData] = {
    # Elastomers
    "silicone": MaterialData(
        4.96, 0.49, f"E from Maeno, Hiromitsu and Kawai 2000; {_ASSUMED_RATIO}"
    ),
    "ecoflex_00_30": _stretched("Smooth-On Ecoflex 00-30", "Shore 00-30", 10.0),
    "ecoflex_00_50": _stretched("Smooth-On Ecoflex 00-50", "Shore 00-50", 12.0),
    "dragon_skin_10": _shore("Smooth-On Dragon Skin 10", 10.0, 22.0),
    "dragon_skin_20": _shore("Smooth-On Dragon Skin 20", 20.0, 49.0),
    "dragon_skin_30": _shore("Smooth-On Dragon Skin 30", 30.0, 86.0),
    "mold_star_15": _shore("Smooth-On Mold Star 15", 15.0, 55.0),
    "mold_star_30": _shore("Smooth-On Mold Star 30", 30.0, 96.0),
    "sorta_clear_40": _shore("Smooth-On SORTA-Clear 40", 40.0, 90.0),
    "smooth_sil_950": _shore("Smooth-On Smooth-Sil 950", 50.0, 272.0),
    "rtv_615": _shore("Momentive RTV615", 44.0),
    "sylgard_184": MaterialData(
        1.8,
        0.49,
        "Dow Sylgard 184 at 10:1 cured near 65 degrees C, typical; Johnston et al., "
        f"J. Micromech. Microeng. 24 (2014) 035017 (1.3 to 3 MPa by cure); {_ASSUMED_RATIO}",
        (1.3, 3.0),
        "1.3 to 3 MPa by cure, Johnston et al.",
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
# Linear thermal expansion, 1/K near 25 degrees C, and where it is from: figures in common
# use, these documents being their origin; measure a filled silicone, whose filler decides.
_ASSUMED_EXPANSION = "assumed: makers of filled silicones publish 2.5e-4 to 3.4e-4"
_CDA = "Copper Development Association data, 20 to 300 degrees C"
EXPANSION: dict[str, tuple[float, str]] = {
    **dict.fromkeys(MATERIALS, (3.0e-4, _ASSUMED_EXPANSION)),
    "sylgard_184": (3.4e-4, "Dow data sheet, 340 ppm/K"),
    "rtv_615": (2.7e-4, "Momentive data sheet, 27e-5 per K"),
    "polyurethane_60a": (2.0e-4, "typical of casting polyurethanes; assumed"),
    "phosphor_bronze": (1.78e-5, _CDA),
    "beryllium_copper": (1.78e-5, _CDA),
    "spring_steel": (1.2e-5, "EN 1993-1-1 clause 3.2.6"),
    "stainless_steel": (1.6e-5, "EN 10088-1, 1.4301, 20 to 100 degrees C"),
    "abs": (9.0e-5, "typical of printed ABS; assumed"),
    "pla": (6.8e-5, "typical of printed PLA; assumed"),
    "aluminium": (2.3e-5, "EN 1999-1-1 clause 3.2.5"),
    "polyimide": (2.0e-5, "DuPont Kapton HN data sheet, 20 ppm/K"),
}


def disagreement_of(name: str, youngs_modulus_MPa: float) -> str | None:
    """Describe the disagreement of a library material's sources, if it is more than a quarter. None
    where they agree, or the modulus is not the library's."""
    known = MATERIALS.get(name)
    if (
        known is None
        or known.modulus_ratio <= DISAGREEMENT
        or known.youngs_modulus_MPa != youngs_modulus_MPa
    ):
        return None
    published = known.published_MPa
    assert published is not None
    return (
        f"{name} of {youngs_modulus_MPa:g} MPa: its sources give {published[0]:g} to "
        f"{published[1]:g} MPa ({known.published_by}); measure yours: fingerdesign identify"
    )
