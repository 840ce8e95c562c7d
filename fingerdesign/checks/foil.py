"""Keys of a design whose plates take a gage that is sold, tried before they are reported."""

from itertools import chain

from fingerdesign.checks.load import with_values
from fingerdesign.design.schema import Design
from fingerdesign.errors import DesignError
from fingerdesign.layout.fitting import GageFit, gage_fit

_ROUNDS = 6  # A remedy may bring one other fault, of the base or the sides.


def gage_keys(design: Design, fit: GageFit) -> dict[str, float]:
    """Keys and values with which ``fit.nearest`` fits a sound design; {} where none were found.

    Plates are enlarged for the type, its grid is read, and the remedies of each fault that follows
    are taken.
    """
    type_ = fit.nearest
    if type_ is None:
        return {}
    values = {"gages.length_mm": type_.grid_length_mm, "gages.width_mm": type_.grid_width_mm}
    if fit.length > fit.room[0]:
        values["plates.length_mm"] = fit.length
    if fit.width > fit.room[1]:
        values["plates.span_mm"] = fit.width + 2.0 * abs(design.gages.z_mm)
    for _ in range(_ROUNDS):
        try:
            found = gage_fit(with_values(design, values))
            return values if found is not None and found.found is not None else {}
        except DesignError as error:
            mends = dict(chain.from_iterable(each.mends.items() for each in error.faults))
            mends = {key: value for key, value in mends.items() if key.startswith("plates.")}
            if not mends:
                return {}
            values |= mends
    return {}
