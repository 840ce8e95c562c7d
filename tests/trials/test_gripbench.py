"""GripBench: its set is fixed, its seed committed to; scores of classes and of programs."""

import hashlib
import json
import shutil
import sys
from pathlib import Path

import pytest
from fingerdesign_cli.options import CONTROLLER_NAMES
from pydantic import TypeAdapter

from fingerdesign.errors import DesignError
from fingerdesign.records.statistics import beta_binomial_share
from fingerdesign.sensing.perturb.faults import FAULTS
from fingerdesign.trials import gripbench
from fingerdesign.trials.grid import Cell, Perturbed
from tests.support.grips import trial

ROOT = Path(__file__).parents[2]
# The move of control/controllers/rivals.py's simplest hand, in two other languages.
IN_PYTHON = """
import json, sys
for line in sys.stdin:
    given = json.loads(line)
    if "start" in given:
        grip = given["start"]["grip"]
        print("{}", flush=True)
        continue
    sample = given["sample"]
    more = sample["normal_force"] < 6.0
    dy = grip["approach_step_mm"] if more else 0.0
    dx = 0.0 if more or sample["lifted"] else grip["shear_step_mm"]
    print(json.dumps({"dx": dx, "dy": dy, "hold": more}), flush=True)
"""
IN_PERL = r"""
$| = 1;
while (<STDIN>) {
    if (/"start"/) {
        ($down) = /"approach_step_mm": ([\d.e-]+)/;
        ($side) = /"shear_step_mm": ([\d.e-]+)/;
        print "{}\n";
        next;
    }
    ($force) = /"normal_force": ([\d.e-]+)/;
    $more = $force < 6;
    $dy = $more ? $down : 0;
    $dx = $more || /"lifted": true/ ? 0 : $side;
    printf "{\"dx\": %s, \"dy\": %s, \"hold\": %s}\n", $dx, $dy, $more ? "true" : "false";
}
"""
IN_A_CLASS = """
from fingerdesign.control.command import Command

class Hand:
    name = "six"

    def __init__(self, grip, own, held):
        self.grip = grip

    def start(self, calibration, sample):
        pass

    def command(self, sample):
        more = sample.normal_force < 6.0
        dy = self.grip.approach_step_mm if more else 0.0
        dx = 0.0 if more or sample.lifted else self.grip.shear_step_mm
        return Command(dx, dy, more)
"""


@pytest.fixture
def small(monkeypatch):
    """A finger of each of two faults, two objects each."""
    monkeypatch.setattr(gripbench, "PERTURBED", Perturbed(("none", "gains"), plants=1, lifts=2))


def test_the_version_is_what_it_was():
    """A change of the set is another version: raise VERSION with these numbers."""
    own = gripbench.PERTURBED
    words = repr((own.labels, own.plants, own.lifts, gripbench.PUBLIC_SEED, gripbench.DESIGN))
    digest = hashlib.sha256(words.encode()).hexdigest()[:12]
    assert (gripbench.VERSION, digest) == (2, "e152d1312300")
    assert set(own.faults) - {"none", "all"} <= set(FAULTS)
    cells = list(gripbench.benchmark_grid(None).batches(["paper"]))
    assert len(cells) == 99
    assert all(len(batch) == 4 for batch in cells)


def test_the_published_scorecard_is_of_this_set():
    text = (ROOT / "docs/images/gripbench.json").read_text()
    card = TypeAdapter(gripbench.Scorecard).validate_json(text)
    assert (card["version"], card["set"]) == (gripbench.VERSION, "public")
    assert card["design_digest"] == gripbench.benchmark_design().digest()
    assert {each["controller"] for each in card["scores"]} == set(CONTROLLER_NAMES)
    assert {(each["grips"], each["fingers"]) for each in card["scores"]} == {(396, 99)}
    assert card["seconds"] < 600.0
    text = (ROOT / "docs/images/gripbench.csv").read_text()
    assert gripbench.scorecard_csv(card).splitlines() == text.splitlines()


def test_the_held_out_seed_needs_its_phrase(monkeypatch):
    with pytest.raises(DesignError, match="release"):
        gripbench.benchmark_grid("guess")
    digest = hashlib.sha256(b"guess").hexdigest()
    monkeypatch.setattr(gripbench, "HELD_OUT_SHA256", digest)
    grid = gripbench.benchmark_grid("guess")
    assert grid.seed != gripbench.PUBLIC_SEED
    assert grid.perturbed == gripbench.PERTURBED


def test_a_score_is_of_its_controllers_grips_and_over_fingers():
    slipped = {"gross_slip": True, "outcome": "complete slip", "safety_margin": None}
    lifts = [("none", {}), ("none", slipped), ("tilt", {"peak_ratio": 4.0}), ("tilt", {})]
    trials = [trial(Cell("paper", 0.3, 100.0, 0.5, fault=f), **own) for f, own in lifts]
    trials += [trial(Cell("other", 0.3, 100.0, 0.5), peak_ratio=9.0)]
    found = gripbench._score(trials, "paper")
    counts = {"grips": 4, "fingers": 2, "dropped": 1, "crushed": 1, "failed": 0}
    assert {key: found[key] for key in counts} == counts
    assert found["success"] == beta_binomial_share([1, 1], [2, 2])
    assert found["held"] == beta_binomial_share([1, 2], [2, 2])
    assert found["by_fault"] == dict.fromkeys(("none", "tilt"), beta_binomial_share([1], [2]))


@pytest.mark.slow
def test_a_class_and_programs_of_two_languages_score_alike(small, in_tmp_path, tmp_path, terminal):
    (tmp_path / "hand.py").write_text(IN_PYTHON)
    (tmp_path / "own_hand.py").write_text(IN_A_CLASS)
    (tmp_path / "hand.pl").write_text(IN_PERL)
    asked = ["study", "gripbench", "--workers", "1", "--json", "--out"]
    given = {"class": ["--controller", "own_hand:Hand"]}
    given["python"] = ["--program", f"{sys.executable} hand.py"]
    if shutil.which("perl"):
        given["perl"] = ["--program", "perl hand.pl"]
    scores = []
    for name, words in given.items():
        card = json.loads(terminal(*asked, tmp_path / name, *words).out)
        (score,) = card["scores"]
        scores.append({**score, "controller": ""})
        folder = tmp_path / name / "gripbench"
        assert json.loads((folder / "gripbench.json").read_text()) == card
        assert len((folder / "gripbench.csv").read_text().splitlines()) == 2
        assert (folder / "gripbench.png").read_bytes()[1:4] == b"PNG"
    assert all(each == scores[0] for each in scores)
    assert scores[0]["grips"] == 4
    assert scores[0]["fingers"] == 2
    assert scores[0]["failed"] == 0
    shares = [scores[0]["by_fault"][fault]["count"] for fault in ("none", "gains")]
    assert sum(shares) == scores[0]["success"]["count"]


@pytest.mark.parametrize("work", [[], ["--to", "lerobot", "lifts"]], ids=["study", "lerobot"])
def test_a_programs_grips_are_not_taken_over(work, in_tmp_path, tmp_path, terminal):
    """It may have been edited since: a run that was interrupted begins again."""
    pytest.importorskip("pyarrow") if work else None
    grip = ("--friction", "0.5", "--mass-g", "200", "--noise", "0.5", "--no-tug", "--workers", "1")
    asked = ["study", "sensitive", *grip, "--program", f"{sys.executable} hand.py", *work]
    (tmp_path / "hand.py").write_text(IN_PYTHON)
    name = "lifts" if work else "out/study/sensitive"
    stale = tmp_path / f"{name}.unfinished.sqlite"
    stale.parent.mkdir(parents=True, exist_ok=True)
    stale.write_text("no journal: it would be refused if it were read")
    terminal(*asked)
    assert (tmp_path / name).is_dir()
    assert not stale.exists()


def test_the_interval_is_over_fingers():
    """Grips of one finger stand or fall together: as 5 of 10 fingers, not as 20 of 40 grips."""
    assert beta_binomial_share([4, 0] * 5, [4] * 10).low < 0.27


def test_what_would_change_the_set_is_refused(tmp_path, terminal):
    base = ["study", "gripbench", "--out", tmp_path]
    assert "leave out frictions" in terminal(*base, "--friction", "0.3", code=2).err
    assert "fidelity" in terminal(*base, "--fidelity", "3d", code=2).err
    assert "--held-out = guess" in terminal(*base, "--held-out", "guess", code=2).err
    for wrong in ("nothing_here", "'open", ""):
        assert f"--program = {wrong}: must be" in terminal(*base, "--program", wrong, code=2).err
    other = ["study", "sensitive", "--held-out", "guess", "--out", tmp_path]
    assert "gripbench" in terminal(*other, code=2).err
