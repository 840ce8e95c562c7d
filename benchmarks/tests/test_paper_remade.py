"""The remade figures of the paper: their numbers, page, record and claims, on a coarse mesh."""

import csv
import json
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from fingerdesign_bench.cli.paper import command
from fingerdesign_bench.paper import case as paper_case
from fingerdesign_bench.paper import measurement as paper_rig
from fingerdesign_bench.paper import remade as paper_remade
from fingerdesign_bench.paper.claims import CLAIMS, claims_of
from fingerdesign_bench.paper.lifts import ROUTE_FRICTION, SQUEEZE, squeeze
from fingerdesign_bench.paper.rectangles import COUNT
from fingerdesign_bench.paper.remade import ORDER
from fingerdesign_cli.main import main

from fingerdesign.analysis.case import fundamental_scene
from fingerdesign.analysis.stages import zone_of
from fingerdesign.checks.load import load_design, with_values
from fingerdesign.runtime.threads import one_thread

pytestmark = pytest.mark.slow

QUICK = paper_remade.Effort(frictions=(0.2, 0.3, 0.5, 1.0), samples=(100,), seeds=1)
COARSE = {
    "mesh.section.contact_size_mm": 0.1,
    "mesh.section.plate_size_mm": 0.2,
    "mesh.section.plate_end_size_mm": 0.05,
    "mesh.section.far_size_mm": 2.0,
    "mesh.section.gradation": 0.5,
}


SCENE = fundamental_scene()
TEXT = (Path(__file__).parents[2] / "docs/explanation/paper.md").read_text("utf-8")


def coarse_design():
    return with_values(load_design("maeno2000"), COARSE)


@pytest.fixture(scope="module")
def reported():
    return []


@pytest.fixture(scope="module")
def found(reported):
    return paper_remade.remake(coarse_design(), lambda m, f: reported.append((m, f)), QUICK)


@pytest.fixture(scope="module")
def folder(found, tmp_path_factory):
    """All figures once: they take seconds."""
    target = tmp_path_factory.mktemp("paper") / "out"
    paper_remade.write_paper(found, target)
    return target


def claim_of(found, key):
    return next(c for c in claims_of(found) if c.figure == key)


def test_progress_goes_forward_and_every_claim_has_words_a_verdict_and_numbers(found, reported):
    fractions = [fraction for _, fraction in reported]
    assert fractions == sorted(fractions)
    assert [c.figure for c in found.claims] == list(CLAIMS)
    for each in found.claims:
        assert each.verdict in ("yes", "partly", "no")
        assert each.measured.endswith(".")
        assert each.numbers
        assert not re.search(r"\bnan\b|\binf\b", each.measured)


def test_what_holds_on_the_papers_finger_whatever_the_mesh(found):
    for key in ("fig07", "fig08", "fig10"):
        assert claim_of(found, key).verdict == "yes"
    assert claim_of(found, "fig03").verdict == "partly"  # the change tells, the shape does not


def test_claims_follow_their_numbers(found):
    """A figure made worse must lose its yes."""

    def verdict(key, **changes):
        return claim_of(replace(found, **changes), key).verdict

    assert verdict("fig07", increments=found.increments[:-1]) == "partly"  # nothing slips whole
    first, *rest = found.lifts
    lost = replace(first.ruled.result, lifted=False, gross_slip=True, safety_margin=None)
    slipped = replace(first, ruled=replace(first.ruled, result=lost))
    one = claim_of(replace(found, lifts=(slipped, *rest)), "fig10")
    assert one.verdict == "partly"
    assert "complete slip at μ = 0.2" in one.measured


def test_the_folder_holds_every_figure_three_times_a_page_and_a_record(folder):
    names = {path.name for path in folder.iterdir()}
    figures = {f"{key}.{kind}" for key in ORDER for kind in ("png", "svg", "csv")}
    assert names == {*figures, "paper.html", "paper.json"}
    for key in ORDER:
        assert (folder / f"{key}.png").read_bytes().startswith(b"\x89PNG")
        data = (folder / f"{key}.csv").read_text("utf-8")
        assert not re.search(r"\b(nan|None|True|False)\b", data), key  # empty, empty, 1, 0
        assert "var(--" not in (folder / f"{key}.svg").read_text("utf-8")  # it needs no page


def rows_of(folder, key):
    with (folder / f"{key}.csv").open(encoding="utf-8", newline="") as stream:
        return list(csv.DictReader(stream))


def test_data_files_hold_what_the_figures_show(folder, found):
    def values(key, column):
        return {row[column] for row in rows_of(folder, key)}

    eight = [float(row["normal_force_N"]) for row in rows_of(folder, "fig06")]
    assert eight == pytest.approx([row.normal_force_N for row in found.increments], rel=1e-5)
    assert len(rows_of(folder, "fig07")) == 8 * len(found.contact.points)
    assert values("fig07", "status") == {"open", "stick", "slip"}
    assert values("fig08", "friction_coefficient") == {"0.2", "0.3", "0.5", "1"}
    turned = rows_of(folder, "fig03")
    assert len(turned) == 11
    assert float(turned[5]["pressed_lower_left_x_mm"]) < float(turned[5]["x_mm"])
    target = rows_of(folder, "fig02")[0]
    assert float(target["normal_force_N"]) == pytest.approx(0.5 * 9.80665 * 0.5 / 0.3, rel=1e-5)
    assert values("fig10", "rule") == {"paper", "never_holding"}
    assert values("fig12", "samples_a_step") == {"", "100"}


def test_the_record_and_the_page(folder):
    record = json.loads((folder / "paper.json").read_text("utf-8"))
    assert [each["figure"] for each in record["claims"]] == list(CLAIMS)
    assert [each["key"] for each in record["figures"]] == list(ORDER)
    page = (folder / "paper.html").read_text("utf-8")
    ids = re.findall(r'\bid="([^"]+)"', page)
    assert len(ids) == len(set(ids))
    assert {f"figure-{key}" for key in ORDER} <= set(ids)
    assert "<script" not in page
    for name in re.findall(r'href="([^"#:]+)"', page):
        assert name.startswith("data") or (folder / name).is_file(), name


def test_wrong_input_is_refused_before_any_work(tmp_path, terminal):
    out = tmp_path / "out"
    for design, words in (("homogeneous", "plates.count = 0"), ("both_ways", "plane strain")):
        assert words in terminal("paper", "--design", design, "--out", out, code=2).err
    assert not out.exists()


def test_the_whole_command(tmp_path, capsys):
    """Measured: 23 s of processor time, on one core."""
    assert main(["paper", "--out", str(tmp_path), "--json"]) == 0
    reported = {each["figure"]: each for each in json.loads(capsys.readouterr().out)["claims"]}
    verdicts = {key: each["verdict"] for key, each in reported.items()}
    documented = re.findall(r"^\| `(\w+)`: .* \| (yes|partly|no) \|", TEXT, flags=re.MULTILINE)
    assert verdicts == dict(documented)
    assert (tmp_path / "paper.html").stat().st_size > 100_000


def test_its_python_runs(capsys):
    (code,) = re.findall(r"```python\n(.*?)```", TEXT, flags=re.DOTALL)
    code = code.replace('load_design("maeno2000")', "coarse_design()")
    exec(compile(code, "docs/explanation/paper.md", "exec"), {"coarse_design": coarse_design})
    first, second = capsys.readouterr().out.splitlines()
    assert first == f"{len(CLAIMS)} partly"
    assert second == "True"


def test_every_figure_and_claim_is_reported_of():
    figures = re.findall(r"^\| `(\w+)` \|", TEXT, flags=re.MULTILINE)
    assert figures == list(ORDER)
    claims = re.findall(r"^\| `(\w+)`: .* \| (yes|partly|no) \|", TEXT, flags=re.MULTILINE)
    assert [key for key, _ in claims] == list(CLAIMS)
    options = {name for parameter in command.params for name in parameter.opts}
    assert set(re.findall(r"(--\w+)", TEXT)) <= options


@pytest.fixture(scope="module", autouse=True)
def single_thread():
    with one_thread():
        yield


@pytest.fixture(scope="module")
def case():
    requested = paper_case.check_case(coarse_design(), SCENE)
    return paper_case.build_case(requested.design, SCENE, zone_of(requested, SCENE))


def test_the_twin_is_the_same_finger_without_plates(case):
    assert case.twin.model.nodes == case.finger.model.nodes
    assert len(case.gage_x) == 15
    pressed = [
        next(paper_case.follow_rows(problem, [(0.1, 0.0)])).measures.normal_force
        for problem in (case.finger, case.twin)
    ]
    assert pressed[0] == pytest.approx(pressed[1], rel=0.05)
    assert pressed[0] > pressed[1]  # plates stiffen


def test_what_slip_ends_is_the_growth_of_the_shear_not_the_shear(found):
    turned = found.rectangles
    assert len(turned.status) == len(turned.corners) == COUNT
    assert set(turned.status) == {"stick", "slip"}
    assert turned.status[0] == turned.status[-1] == "slip"  # from both edges
    pressed = turned.angle["pressed"]
    assert pressed == pytest.approx(-pressed[::-1], abs=0.02)
    assert (turned.angle["added"] > 0.0).all()
    assert turned.mean("change", "stick") > 2.0 * turned.mean("change", "slip") > 0.0
    assert turned.mean("added", "slip") > 0.7 * turned.mean("added", "stick")
    assert (turned.change_per_N > 0.0).all()
    # The angle is of the two middle lines against each other: here by the corners, of squares.
    x, y = turned.corners[..., 0], turned.corners[..., 1]
    width = x[:, 1] - x[:, 0]
    assert (width > 0.0).all()
    assert width == pytest.approx(y[:, 3] - y[:, 0])  # anticlockwise from the lower left
    moved = turned.moved["sheared"] - turned.moved["pressed"]
    by_corners = (moved[:, 3] + moved[:, 2] - moved[:, 0] - moved[:, 1])[:, 0]
    by_corners += (moved[:, 1] + moved[:, 2] - moved[:, 0] - moved[:, 3])[:, 1]
    assert np.degrees(by_corners / (2 * width)) == pytest.approx(turned.angle["added"], rel=0.2)


def test_lifts_by_the_rule_and_two_other_routes(found):
    low, high = (lift for lift in found.lifts if lift.friction in (ROUTE_FRICTION, 0.8))
    for result in (low.ruled.result, high.ruled.result):
        assert result.lifted
        assert not result.gross_slip
        assert result.safety_margin > 1.0
    assert [each.free.result.gross_slip for each in (low, high)] == [True, False]
    route = found.route
    least = 0.5 * 9.80665e-3 * 500.0 / ROUTE_FRICTION
    assert route.forces[0].max() == pytest.approx(SQUEEZE * least, rel=0.03)
    assert not route.slips
    assert route.forces[1][-1] > ROUTE_FRICTION * least


def test_a_squeeze_that_is_not_enough_slips(case):
    design = with_values(case.design, {"grip.max_approach_mm": 0.05})
    assert squeeze(replace(case, design=design)).slips


def test_the_rig_repeats_itself_and_noise_changes_it(case):
    rig = paper_rig.rig_of(case, "bronze", levels=(100,), seeds=2)
    assert rig.levels == (None, 100)
    assert rig.works(None)  # without noise
    assert [len(rig.at(None)), len(rig.at(100, 0.3))] == [2, 2]  # one a friction; one a seed
    settings = replace(case, design=with_values(case.design, paper_rig.RIG_SETTINGS))
    for first, second in zip(rig.at(100)[2:], paper_rig.measured(settings, 100, 1), strict=True):
        assert (first.seed, first.friction) == (second.seed, second.friction)
        assert first.episode.result == second.episode.result
    readings = [g.episode.trace.gage_readings[0] for g in rig.at(100, 0.3)]
    assert np.std(readings[0] - readings[1]) == pytest.approx(0.05 * np.sqrt(2), rel=0.5)


def test_a_rig_works_where_all_is_lifted_and_the_frictions_are_distinguished(case):
    low, high = paper_rig.rig_of(case, "bronze", levels=(), seeds=1).at(None)
    blind = paper_rig.Rig("blind", (low, replace(high, episode=low.episode)))
    assert blind.force_ratio(None) == 1.0
    assert not blind.works(None)
    assert blind.least_samples == ()
    slipped = replace(low.episode.result, lifted=False, gross_slip=True)
    lost = replace(low, episode=replace(low.episode, result=slipped))
    assert lost.ended == "slipped"
    rig = paper_rig.Rig("lost", (lost, high))
    assert not rig.works(None)
    assert np.isnan(rig.force_ratio(None))
