"""README and docs: every block of commands, TOML and Python in them runs; what they name exists."""

import re
import tomllib
from pathlib import Path

import pytest
from fingerdesign_bench.cli.bench import command as bench
from fingerdesign_bench.known.case import load_cases
from fingerdesign_bench.known.table import FILE, table
from fingerdesign_cli.main import cli, main

from fingerdesign import parse_design
from fingerdesign.analysis.fidelity.rungs import SPACE_SCALES
from fingerdesign.checks import follow
from fingerdesign.checks.load import load_design, with_values
from fingerdesign.control.controllers.rivals import OracleNear, OracleSafe
from fingerdesign.errors import DesignError
from fingerdesign.layout import pressure
from fingerdesign.layout.rows import plate_frames
from fingerdesign.mold.checks import walls
from fingerdesign.mold.plan.limits import PROFILES, limits_of
from fingerdesign.mold.plan.planning import plan_mold
from fingerdesign.search.optimise import sensitivity
from fingerdesign.sensing.identify.trace_report import TARGET
from fingerdesign.validate import assumptions
from fingerdesign.validate.record import THRESHOLDS
from tests.support import pages
from tests.support.coarser import write_coarser

ROOT = Path(__file__).parents[1]
TEXT = (ROOT / "README.md").read_text("utf-8")
DOCS = sorted(path.relative_to(ROOT).as_posix() for path in ROOT.glob("docs/*/*.md"))
PAGES = ("README.md", *DOCS)


def page(name):
    return (ROOT / name).read_text("utf-8")


def blocks(kind, name="README.md"):
    return pages.blocks(ROOT / name, kind)


def run_python(name, capsys):
    """What the one block of Python of a page prints."""
    assert len(blocks("python", name)) == 1
    capsys.readouterr()
    pages.run_python(ROOT / name)
    return capsys.readouterr().out


ANALYSE = "docs/how_to/analyse.md"


def commands(name):
    """The lines of a page's sh blocks, block by block."""
    return [[line for line in block.splitlines() if line] for block in blocks("sh", name)]


@pytest.fixture
def analysed(tmp_path, in_tmp_path):
    """A folder with the design and the scene of the page on analyses."""
    (tmp_path / "scene.toml").write_text(blocks("toml", ANALYSE)[0], encoding="utf-8")
    assert main(["new", "mine.toml", "--all"]) == 0
    write_coarser(tmp_path / "mine.toml")
    return tmp_path


def test_the_readme_leads_to_a_design(in_tmp_path):
    (five,) = commands("README.md")
    assert len(five) == 5
    for command in five[:3]:
        assert main(command.split()[1:]) == 0
    assert Path("out/mine.png").is_file()


@pytest.mark.slow
def test_the_readme_leads_to_a_mold_and_shows_what_is_printed(in_tmp_path, capsys):
    """The mold is made of fewer plates than the finger has: each is cut like the next. To draw and
    to check the design is tried above."""
    new, _, _, *others = commands("README.md")[0]
    for command in (new, *others):
        if " mold " in command:
            design = Path("mine.toml").read_text("utf-8")
            assert "\ncount = 11" in design
            Path("mine.toml").write_text(design.replace("\ncount = 11", "\ncount = 3"), "utf-8")
        assert main(command.split()[1:]) == 0
    printed = " ".join(capsys.readouterr().out.split())
    (shown,) = re.findall(r"^```\n(mine .*?)```", TEXT, flags=re.DOTALL | re.MULTILINE)
    for line in shown.splitlines()[1:]:
        assert " ".join(line.split()) in printed
    page = Path("out/mold/mine/report.html").read_text("utf-8")
    assert page.count('class="badge"') > 6  # one a part


@pytest.mark.slow
@pytest.mark.parametrize("step", commands(ANALYSE), ids=lambda step: step[0])
def test_a_command_of_the_page_on_analyses_runs(analysed, step, capsys):
    """The ladder climbs to an accuracy of 0.2: its next two models cost 15 s."""
    for command in step:
        program, *arguments = command.replace("--accuracy 0.1", "--accuracy 0.2").split()
        assert program == "fingerdesign"
        assert main(arguments) == 0, capsys.readouterr()
        out = Path(arguments[arguments.index("--out") + 1]) if "--out" in arguments else Path()
        assert (analysed / out).is_dir()


@pytest.mark.slow
def test_python_of_the_readme_and_of_the_page_on_analyses_runs(analysed, capsys):
    for name in ("README.md", ANALYSE):
        assert float(run_python(name, capsys).split()[0]) > 0


STUDY = "docs/tutorials/first_study.md"


@pytest.mark.parametrize("count", [1, pytest.param(3, marks=pytest.mark.slow)])
def test_commands_of_the_first_study_run(in_tmp_path, capsys, count):
    """Of coarse meshes: that the commands run is tested, not what they find."""
    coarse = {"contact_size_mm": 0.2, "plate_size_mm": 0.3, "plate_end_size_mm": 0.1}
    fixed = "".join(f'"mesh.section.{key}" = {size}\n' for key, size in coarse.items())
    study = blocks("toml", STUDY)[0] + f"[fixed]\n{fixed}"
    Path("angles.toml").write_text(study, "utf-8")
    for (command,) in commands(STUDY)[:count]:
        assert main(command.split()[1:]) == 0, capsys.readouterr()


@pytest.mark.slow
def test_the_commands_of_the_page_on_the_command_line_run(tmp_path, in_tmp_path, capsys):
    """Meshes are drawn by the page on analyses."""
    for block in blocks("sh", "docs/reference/cli.md") + blocks("sh", "docs/how_to/install.md"):
        for command in block.splitlines():
            words = command.split()[1:]
            words += ["--no-picture"] * (words[0] == "mesh")
            assert main(words) == 0, (command, capsys.readouterr())
    assert (tmp_path / "out/first.svg").is_file()


# A tenth of the elements: commands run, and answers are other tests' matter.
COARSE = """mesher = "sweep"
layers = 2
contact_size_mm = 1.2
plate_size_mm = 1.5
section = { contact_size_mm = 0.3, plate_size_mm = 0.3, plate_end_size_mm = 0.15 }
"""
FIRST = [block.split()[1:] for block in blocks("sh", "docs/tutorials/first_finger.md")]


@pytest.fixture
def first_finger(in_tmp_path):
    """The folder of the page on a first finger, where its file has been written."""
    assert main(FIRST[0]) == 0
    assert "[plates]" in Path("mine.toml").read_text("utf-8")
    design = blocks("toml", "docs/tutorials/first_finger.md")[0]
    Path("mine.toml").write_text(f"{design}[mesh]\n{COARSE}", "utf-8")


@pytest.mark.parametrize(
    "words",
    [
        pytest.param(
            each,
            id=each[0],
            marks=[pytest.mark.slow] * (each[0] == "mold" or (each[-1] == "--open" and n > 1)),
        )
        for n, each in enumerate(FIRST[1:])
    ],
)
def test_a_command_for_the_first_finger_runs(first_finger, words, capsys):
    assert main([word for word in words if word != "--open"]) == 0, capsys.readouterr()


def test_every_design_of_the_fingers_page_is_sound_and_its_python_runs(own_cache, capsys):

    designs = [parse_design(block) for block in blocks("toml", "docs/reference/fingers.md")]
    assert [design.design.name for design in designs] == ["pad", "rows", "skin"]
    assert designs[0].body.core is not None
    assert {frame.along for frame in plate_frames(designs[1])} == {"x", "z"}
    assert all(frame.holes and frame.bend_radius for frame in plate_frames(designs[2]))
    printed = run_python("docs/reference/fingers.md", capsys).split()
    assert [float(value) for value in printed] == pytest.approx([12.0, 9.0])


def test_python_of_the_method_page_runs(capsys):
    *rows, others = run_python("docs/explanation/method.md", capsys).splitlines()
    pressed, sheared, forced = ([float(value) for value in row.split()] for row in rows)
    assert pressed[1] == pytest.approx(0.0, abs=0.05)
    assert pressed[2] > sheared[2] > 0.5
    assert forced[:2] == pytest.approx([2.0, 0.5], rel=1e-6)
    assert int(others) == 0


def test_the_page_on_three_dimensions_shows_what_its_python_prints(capsys):
    printed = run_python("docs/explanation/three_d.md", capsys)
    for depth, *areas in (re.findall(r"[\d.]+", line) for line in printed.splitlines()):
        assert f"| {depth} mm" in page("docs/explanation/three_d.md")
        assert " ".join(areas) in page("docs/explanation/three_d.md")


def test_the_molds_page_plans_its_mold_and_reports_profiles_as_they_are(capsys):

    text = page("docs/how_to/molds.md")
    (table,) = blocks("toml", "docs/how_to/molds.md")
    design = parse_design(table)
    assert limits_of(design.mold).slot_mm == 0.25
    assert len(plan_mold(design).legs) == 10
    first, sentence = run_python("docs/how_to/molds.md", capsys).splitlines()
    assert first.endswith(" True")
    assert 0.01 < float(first.split()[0]) < 0.02
    assert sentence.startswith("Plates off their places change a reading by up to ")
    for name, sizes in PROFILES.items():
        (row,) = re.findall(rf"^\| `{name}` .*$", text, flags=re.MULTILINE)
        reported = [float(cell.split()[0]) for cell in row.strip("| ").split("|")[1:]]
        assert reported == list(sizes)


@pytest.mark.slow
def test_the_molds_page_reports_refusals_as_they_are():

    rows = re.findall(
        r"^\| `(\w+)` \| `(mold\.\S+) = (.+?)` \| (.*) \|$", page("docs/how_to/molds.md"), re.M
    )
    assert len(rows) == 5
    for name, key, value, reported in rows:
        parsed = tomllib.loads(f"value = {value}")["value"]
        design = with_values(load_design(name), {key: parsed})
        with pytest.raises(DesignError) as error:
            plan_mold(design)
        message = str(error.value)
        blamed = re.match(r"[a-z_.]+ = ", reported)
        assert (blamed[0] if blamed else f"{key} = ") in message
        for number in re.findall(r"\d+\.\d+", reported):
            assert number in message, (number, message)


@pytest.mark.parametrize(
    ("name", "words", "value"),
    [
        ("explanation/accuracy.md", r"elements ([\d.]+) times smaller", SPACE_SCALES[0] / 2.8),
        ("explanation/accuracy.md", r"pressure of ([\d.]+) \(less for a slender", pressure._EDGES),
        ("explanation/accuracy.md", r"contact pressure over (\d) shear", pressure._FACE),
        ("how_to/control.md", r"closes to ([\d.]+) or 1.5 times", OracleNear.margin),
        ("how_to/control.md", r"closes to 1.2 or ([\d.]+) times", OracleSafe.margin),
        ("how_to/identify.md", r"modulus, gains \| (\d+) %", 100.0 * TARGET["modulus"]),
        ("how_to/identify.md", r"modulus, gains \| (\d+) %", 100.0 * TARGET["gain"]),
        ("how_to/identify.md", r"friction coefficient \| (\d+) %", 100.0 * TARGET["friction"]),
        ("how_to/identify.md", r"by pressure \| ([\d.]+)", TARGET["exponent"]),
        ("how_to/identify.md", r"stage zero \| ([\d.]+) mm", TARGET["touch"]),
        ("how_to/identify.md", r"share; time \| ([\d.]+) of", TARGET["share"]),
        ("how_to/identify.md", r"of all forces; (\d+) %", 100.0 * TARGET["time"]),
        ("how_to/molds.md", r"outer combs \| ([\d.]+) mm clear", walls.CLEAR_MM),
        ("how_to/optimise.md", r"less than (\d+) % of the variance", 100.0 * sensitivity.WEAK),
        ("how_to/validate.md", r"design's value \| (\d+) % less", 100.0 * assumptions.E_BAND),
        ("how_to/validate.md", r"zeroing \| (\d+) K more", assumptions.KELVIN),
        ("how_to/validate.md", r"error of (\d+) % it recommends", 100.0 * THRESHOLDS.keep),
        ("how_to/validate.md", r"Above (\d+) % it advises", 100.0 * THRESHOLDS.limit),
        ("reference/fingers.md", r"([\d.]+) times the forecast approach", follow._TRAVEL),
    ],
)
def test_bounds_that_pages_state_are_those_of_the_code(name, words, value):
    (found,) = re.findall(words, page(f"docs/{name}"))
    assert float(found) == pytest.approx(value, rel=0.03)  # 1.4 stands for a root of 2


def test_the_suites_table_is_that_of_its_cases():
    """The table shows each case's `regression`, the value of `fingerdesign bench suite`."""
    assert FILE.read_text("utf-8") == table()
    text = page("docs/reference/suite.md")
    for case in load_cases():
        assert not case.known_miss or case.known_miss in text


@pytest.mark.parametrize("name", PAGES)
def test_what_a_page_names_exists(name):
    """Files that it links to, commands, benchmarks."""
    text = page(name)
    for target in re.findall(r"\]\(([^)#]+)\)", text):
        there = (ROOT / name).parent / target
        assert target.startswith("http") or there.exists() or "examples" in target, target
    for command in re.findall(r"(?:^ {4}|^|`)fingerdesign ([a-z-]+)", text, flags=re.MULTILINE):
        assert command in cli.commands, command
    finished = page("docs/reference/finished_studies.md")
    for command in re.findall(r"fingerdesign bench ([a-z][a-z-]*)", text):
        assert command in bench.commands or f"`bench {command}`" in finished, command
