"""What a machine and a cutter hold, as a file of one's own.

It is written beside each mold, to be measured on its parts and corrected; ``--profile`` reads it.
"""

from pathlib import Path

from fingerdesign.checks.load import parse_toml, read_text, with_values
from fingerdesign.design.mold import Comb, MoldLimits
from fingerdesign.design.schema import Design
from fingerdesign.mold.plan.plan import comb_tolerance, limits_of

PROFILE_FILE = "profile.toml"
_HEAD = """\
# What this mold was planned with, mm. Measure it on its parts, cast once with plates that carry
# no gages, correct it here, and plan the next mold: fingerdesign mold DESIGN --profile FILE
"""


def profile_text(design: Design) -> str:
    """The profile that a mold is planned with, as TOML; each key with its meaning."""
    mold = design.mold
    limits = {key: getattr(limits_of(mold), key) for key in MoldLimits.model_fields}
    comb = mold.comb.model_dump() | {"tolerance_mm": comb_tolerance(mold)}
    lines = [_HEAD, f'process = "{mold.process}"']
    for name, table, values in (("limits", MoldLimits, limits), ("comb", Comb, comb)):
        lines.append(f"\n[{name}]")
        for key, field in table.model_fields.items():
            meaning = (field.description or "").partition(";")[0]
            lines.append(f"{key} = {values[key]:g}  # {meaning}")
    return "\n".join(lines) + "\n"


def with_profile(design: Design, file: Path) -> Design:
    """The design with a profile's keys in its [mold] table; DesignError with every fault of it."""
    data = parse_toml(read_text(file), str(file))
    values: dict[str, object] = {}
    for key, value in data.items():
        inner = value if isinstance(value, dict) else {"": value}
        values |= {f"mold.{key}.{name}".rstrip("."): each for name, each in inner.items()}
    return with_values(design, values)
