"""How elastomers are mixed and cured: their makers' usual advice, to be held against your tin."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType


@dataclass(frozen=True)
class Mixing:
    """Parts A and B by mass; how long it can be poured; how it cures. source: of the numbers."""

    part_a: float
    part_b: float
    pot_life: str
    cure: str
    source: str

    def shares(self, mass_g: float) -> tuple[float, float]:
        """Masses of A and B, g, that make ``mass_g``.

        >>> Mixing(10.0, 1.0, "", "", "").shares(11.0)
        (10.0, 1.0)
        """
        whole = self.part_a + self.part_b
        return mass_g * self.part_a / whole, mass_g * self.part_b / whole


# Typical figures of the makers' data sheets at about 23 degrees C.
KNOWN: Mapping[str, Mixing] = MappingProxyType(
    {
        "dragon_skin_20": Mixing(1, 1, "25 min", "4 h at room temperature", "Smooth-On"),
        "dragon_skin_30": Mixing(1, 1, "45 min", "16 h at room temperature", "Smooth-On"),
        "sylgard_184": Mixing(
            10, 1, "1.5 h", "48 h at room temperature, or 4 h at 60 degrees C", "Dow"
        ),
    }
)
# What is usual where the material is not known by name: said to be so in the notes.
USUAL: Mapping[str, Mixing] = MappingProxyType(
    {
        "platinum": Mixing(
            1, 1, "20 to 60 min", "4 to 24 h at room temperature", "usual of platinum silicones"
        ),
        "condensation": Mixing(
            100,
            5,
            "30 to 90 min",
            "24 h at room temperature, in moist air",
            "usual of tin silicones",
        ),
    }
)
POLYURETHANE = Mixing(
    1, 1, "10 to 20 min", "16 to 24 h at room temperature", "usual of casting polyurethanes"
)


def mixing_of(material: str, cure: str) -> tuple[Mixing, bool]:
    """How a material is mixed, and whether it is known by name (else what is usual of its cure)."""
    known = KNOWN.get(material)
    if known is None and material.startswith("polyurethane"):
        return POLYURETHANE, False
    return (known, True) if known is not None else (USUAL[cure], False)
