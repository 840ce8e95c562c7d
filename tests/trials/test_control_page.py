"""What the page of a control study says, from made-up grips; no model."""

from dataclasses import asdict, replace
from pathlib import Path

import numpy as np
import pytest
from fingerdesign_cli.trials import _show

from fingerdesign.report.style import canvas
from fingerdesign.runtime.registry import CONTROLLERS
from fingerdesign.trials.bench import ControlGrid, Tug
from fingerdesign.trials.page import (
    _draw_paths,
    answers,
    force_figure,
    look_of,
    map_figure,
    success_figure,
)
from fingerdesign.trials.record import ControlStudy, control_data
from tests.support.grips import judged, path_of

GRID = ControlGrid((0.3, 0.6), (100.0, 200.0), (0.0, 0.5), tug=None)
DROPPED = {"lifted": False, "dropped": True, "margin_at_lift": None, "ending": "complete slip"}


def study(**controllers):
    """Grips of controllers: what is changed in all of a controller's, and in its last one."""
    outcomes = []
    for name, (every, last) in controllers.items():
        cells = [cell for batch in GRID.batches([name]) for cell in batch]
        for k, cell in enumerate(cells):
            changes = {**every, **(last if k == len(cells) - 1 else {})}
            outcomes.append(judged(**asdict(cell) | changes))
    return recorded(outcomes, controllers, GRID)


def recorded(outcomes, names, grid):
    facts = {key: {} for key in ("model", "versions")}
    numbers = {"workers": 1, "peak_memory_MB": 0.0, "seconds": {"whole": 1.0}}
    hardware = {"sample_rate_Hz": 100.0}
    data = control_data(
        outcomes, names, grid, design="made up", digest="0", hardware=hardware, **facts, **numbers
    )
    return ControlStudy(data, tuple(outcomes))


def kinds(made):
    return [each.answer for each in answers(made.data)]


def test_all_is_well():
    gentle = {"peak_ratio": 1.4}
    made = study(
        paper=({"peak_ratio": 2.0}, {}),
        regulator=(gentle, {}),
        **{"oracle_1.2": ({"peak_ratio": 1.2}, {})},
    )
    assert kinds(made) == ["yes"] * 4
    best = answers(made.data)[-1].words
    assert "paper, success 100.0 %, median peak 2.00 times" in best  # no oracle: it is given


@pytest.mark.parametrize(
    ("paper", "regulator", "expected"),
    [
        # one grip of four dropped: held 75 %, no more often a success than the rival
        (({"peak_ratio": 2.0}, {}), ({}, DROPPED), ["yes", "no", "yes", "partly"]),
        (({"peak_ratio": 1.3}, {}), ({"peak_ratio": 2.0}, {}), ["yes", "yes", "yes", "partly"]),
        (({"peak_ratio": 1.3}, {}), ({"peak_ratio": 2.0}, DROPPED), ["yes", "no", "yes", "no"]),
        (({}, {}), ({"margin_at_lift": 1.6}, {}), ["yes", "yes", "no", "partly"]),
        ((DROPPED, {}), ({}, {}), ["no", "yes", "yes", "yes"]),
    ],
)
def test_what_is_not_well_is_said(paper, regulator, expected):
    assert kinds(study(paper=paper, regulator=regulator)) == expected


def test_without_paper_and_regulator_the_best_is_named():
    made = study(reactive=({}, DROPPED), fixed_force=({}, {}))
    (only,) = answers(made.data)
    assert only.answer == "best"
    assert only.words.startswith("fixed force: 100.0 %")


def test_the_best_is_not_one_that_is_reported_unless_all_are():
    oracles = {"oracle_1.2": (DROPPED, {}), "oracle_1.5": ({}, {})}
    (only,) = answers(study(**oracles, reactive=({}, DROPPED)).data)
    assert only.words.startswith("reactive: ")
    assert "Oracles" in only.words
    (only,) = answers(study(**oracles).data)
    assert only.words.startswith("oracle 1.5, which is given friction and weight: 100.0 %")
    assert answers(study(reactive=({}, {})).data) == []


def test_an_answer_is_of_the_grid_and_says_what_its_interval_leaves_open():
    held = answers(study(regulator=({}, {})).data)[0]
    assert held.answer == "yes"
    assert "99 % of this grid" in held.question
    assert "4 of 4 grips (100.0 %), one each on 2 frictions (0.3 to 0.6) by 2 weights" in held.words
    assert held.words.endswith("does not exclude less than 99 %.")
    lost = answers(study(regulator=(DROPPED, {})).data)[0]
    assert lost.words.endswith("lies wholly below 99 %.")


def test_figures_say_in_words_what_they_show():
    nothing = {"reactive": (DROPPED, {})}
    made = study(paper=({}, DROPPED), regulator=({"peak_ratio": 3.5}, {}), **nothing)
    data = made.data
    rows = [{**asdict(each), "crushed": each.crushed} for each in made.outcomes]
    assert (
        "paper: 0 microstrain 100.0 %, 0.5 microstrain 75.0 %." in success_figure(data).alternative
    )
    reported = map_figure(data, rows, 0.5).alternative
    assert "paper: 3 of 4 succeed; 1 dropped." in reported
    assert "regulator: 0 of 4 succeed; 4 crushed." in reported
    assert "reactive: 0 of 4 succeed; 4 dropped." in reported
    reported = force_figure(data, rows, 0.5).alternative
    assert "regulator: median 3.50" in reported
    assert "reactive lifts nothing" in reported


def test_the_tables_on_the_terminal_fit_80_columns(capsys):
    made = study(**{name: ({}, DROPPED) for name in CONTROLLERS.names()})
    tugs = [replace(each, tug=0.3, reaction_steps=k) for k, each in enumerate(made.outcomes, 1)]
    made = recorded((*made.outcomes, *tugs), CONTROLLERS.names(), replace(GRID, tug=Tug()))
    _show(made, Path("judged"))
    lines = capsys.readouterr().out.splitlines()
    rows = [line for line in lines if line[:1] in "┏┃│└"]
    assert len(rows) == 3 * (3 + len(CONTROLLERS.names()))
    assert max(map(len, rows)) <= 80
    assert sum("7 of 7" in row for row in rows) == len(
        CONTROLLERS.names()
    )  # the eighth is not lifted


def test_every_path_is_within_its_axes_and_every_hand_has_its_look():
    force = np.array([0.5, 20.0, 80.0])  # far beyond what 100 g at 0.8 needs
    trace = path_of(force, [0.0, 0.3, 0.49], force, 0.8, 100.0, 2)
    axes = canvas(4.0, 3.0).subplots()
    _draw_paths(axes, [trace])
    assert axes.get_xlim()[1] > 80.0
    names = CONTROLLERS.names()
    assert len({look_of(name)[0] for name in names}) == len(names)
