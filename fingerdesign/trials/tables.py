"""Tables of a control study, for its page: controllers by noise, fault and tug, and conditions."""

from collections.abc import Iterable, Sequence
from typing import Any

from fingerdesign.records.statistics import Rms, Share, Spread
from fingerdesign.report.table import Table
from fingerdesign.trials.findings import words
from fingerdesign.trials.record import ControlData, ControllerData, TuningData
from fingerdesign.trials.summary import NoiseSummary

NONE = "–"  # of a cell: nothing, or no grip has the value


def at_noise(controller: ControllerData, noise: float) -> NoiseSummary:
    """The summary of a controller at one noise of the grid."""
    return next(row for row in controller["by_noise"] if row.noise_microstrain == noise)


def main_tables(data: ControlData, noise: float) -> list[Table]:
    """Who lifts, and how, at one noise; on perturbed fingers by fault."""
    lifts, forces = [], []
    for each in data["controllers"]:
        own, name = at_noise(each, noise), words(each["controller"])
        dropped = f"{own.dropped}, {own.caught} caught" if own.caught else f"{own.dropped}"
        counts = (own.crushed, own.not_lifted, own.failed)
        given = "μ, m" if each["told"] else NONE
        shares = _share(own.success), _share(own.held)
        lifts.append((name, given, str(own.grips), *shares, dropped, *map(str, counts)))
        margin = own.margin_at_lift
        middle = NONE if margin is None else f"{margin.low:.2f} to {margin.high:.2f}"
        spreads = (_median(own.peak_ratio), _median(own.minimum_stick_ratio))
        last = (_median(own.slip_distance_mm, 3), _median(own.steps, 0))
        forces.append((name, _median(margin), middle, *spreads, *last))
    columns = ["controller", "given", "grips", "success %", "held %", "dropped", "crushed"]
    columns += ["not lifted", "failed"]
    how = ("controller", "margin at lift", "middle half", "peak", "least stick", "slip mm", "steps")
    found = [
        _table("controllers", f"At {noise:g} microstrain: who lifts, of all grips", columns, lifts),
        _table("forces", f"At {noise:g} microstrain: how; medians", how, forces),
    ]
    return [*found, *_fault_tables(data)]


def _fault_tables(data: ControlData) -> list[Table]:
    perturbed = data["conditions"]["perturbed"]
    if perturbed is None:
        return []
    names = [words(each["controller"]) for each in data["controllers"]]
    success, margins = [], []
    for number, label in enumerate(perturbed["faults"]):
        own = [each["by_fault"][number] for each in data["controllers"]]
        success.append((words(label), *(_share(each.success, 0) for each in own)))
        margins.append((words(label), *(_median(each.safety_margin) for each in own)))
    columns = ("fault", *names)
    return [
        _table("faults", "By fault of the finger: success %", columns, success),
        _table("fault-margins", "By fault: median margin of what succeeded", columns, margins),
    ]


def noise_tables(data: ControlData) -> list[Table]:
    """Success and margin by noise, where there are two or more."""
    noises = data["conditions"]["noises_microstrain"]
    if len(noises) < 2:
        return []
    columns = ("controller", *(f"{noise:g}" for noise in noises))
    success, margins = [], []
    for each in data["controllers"]:
        name, own = words(each["controller"]), each["by_noise"]
        success.append((name, *(_share(row.success) for row in own)))
        margins.append((name, *(_median(row.margin_at_lift) for row in own)))
    return [
        _table("noise", "By noise (microstrain): success %", columns, success),
        _table("margins", "By noise (microstrain): margin", columns, margins),
    ]


def warning_tables(data: ControlData, noise: float) -> list[Table]:
    """Warnings of slip before it came, and errors of the reported stick ratio."""
    columns = ["controller", "complete slips warned of %", "withdrawn", "lead s"]
    columns += ["F_t at the warning %", "grips with a false alarm %", "false alarms per 100 steps"]
    columns.append("error of the stick ratio, RMS")
    rows = []
    for each in data["controllers"]:
        saw = at_noise(each, noise).foreseen
        rows.append(
            (
                words(each["controller"]),
                _share(saw.warned),
                NONE if saw.withdrawn is None else str(saw.withdrawn),
                _median(saw.lead_s),
                _median(saw.lead_force_share, 0, 100.0),
                _share(saw.falsely_alarmed),
                _share(saw.false_alarms, 2),
                _rms(saw.stick_error),
            )
        )
    caption = f"At {noise:g} microstrain: warnings before slip, and the reported stick ratio"
    return [_table("foreseen", caption, columns, rows)]


def tug_tables(data: ControlData) -> list[Table]:
    """Effects of the tug at the lifted object, and the reactions of the hand."""
    tug, rate = data["conditions"]["tug"], data["hardware"].get("sample_rate_Hz", 100.0)
    if tug is None:
        return []
    assert not isinstance(rate, list)
    rows, ms = [], 1000.0 / rate
    for each in data["controllers"]:
        own = each["tugged"]
        assert own is not None
        found = own.reaction_steps
        times = (NONE, NONE, NONE)
        if found is not None:
            times = (_median(found, 0, ms), f"{ms * found.high:.0f}", f"{ms * found.most:.0f}")
        held, answered = _share(own.held), _share(own.answered)
        name = words(each["controller"])
        rows.append((name, str(own.grips), held, answered, *times, _median(own.peak_ratio)))
    columns = ("controller", "grips", "held %", "answered %", "reaction ms", "three in four")
    caption = (
        f"Tugged with {100.0 * tug['share']:g} % of the weight: risen in {tug['rise_s']:g} s, held "
        f"for {tug['stay_s']:g} s, at {tug['noise_microstrain']:g} microstrain"
    )
    return [_table("tug", caption, (*columns, "slowest", "peak"), rows)]


def tuning_tables(tuning: TuningData | None) -> list[Table]:
    """Gains of the tuning, on its own grips."""
    if tuning is None:
        return []
    rows = []
    for name, found in tuning["controllers"].items():
        best, default = found["best"], found["default"]
        rates = (f"{100.0 * each['success_rate']:.1f}" for each in (best, default))
        takes = [f"{key.removeprefix('grip.')} {each:g}" for key, each in best["values"].items()]
        rows.append((words(name), *rates, ", ".join(takes)))
    caption = f"Tuned before the study, on {len(tuning['cells'])} other grips"
    return [_table("tuning", caption, ("controller", "success %", "before", "takes"), rows, (0, 3))]


def condition_tables(data: ControlData) -> list[Table]:
    """Conditions, hardware and model, one value a row."""
    own = data["conditions"]
    values: dict[str, Any] = {
        "friction coefficients": own["friction_coefficients"],
        "weights (g)": own["object_masses_g"],
        "gage noise (microstrain)": own["noises_microstrain"],
        "held on after the lift (s)": own["hold_s"],
        "seed": own["seed"],
    }
    if (perturbed := own["perturbed"]) is not None:
        values["fingers of each fault"] = perturbed["plants"]
        values["objects a finger"] = perturbed["lifts_a_plant"]
    for table in (data["hardware"], data["model"]):
        values |= {words(name): each for name, each in table.items()}
    rows = [(name, _plain(each)) for name, each in values.items()]
    return [_table("conditions", "Conditions", ("what", "value"), rows, (0, 1))]


def _plain(value: Any) -> str:
    if isinstance(value, float):
        return f"{value:.4g}"
    if isinstance(value, list | tuple):
        return ", ".join(f"{each:g}" for each in value) or "none"
    return str(value)


def _table(
    key: str,
    caption: str,
    columns: Iterable[str],
    rows: Sequence[tuple[str, ...]],
    texts: Iterable[int] = (0,),
) -> Table:
    return Table(key, caption, tuple(columns), tuple(rows), frozenset(texts))


def _share(share: Share | None, digits: int = 1) -> str:
    """The rate in %."""
    if share is None:
        return NONE
    return _with_interval((share.rate, share.low, share.high), share.of, digits, 100.0)


def _median(spread: Spread | None, digits: int = 2, factor: float = 1.0) -> str:
    if spread is None:
        return NONE
    values = (spread.median, spread.median_low, spread.median_high)
    return _with_interval(values, spread.count, digits, factor)


def _rms(error: Rms | None) -> str:
    if error is None:
        return NONE
    return _with_interval((error.value, error.low, error.high), error.count, 3)


def _with_interval(
    values: Iterable[float | None], of: int, digits: int, factor: float = 1.0
) -> str:
    """A value, the ends of its 95 % interval, and the number of cases."""
    value, *ends = (None if each is None else f"{factor * each:.{digits}f}" for each in values)
    interval = "" if None in ends else f"{ends[0]} to {ends[1]}, "
    return NONE if value is None else f"{value} ({interval}of {of:,})"
