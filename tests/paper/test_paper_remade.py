"""All figures, the page, the record and the claims, from one quick and coarse run; the command."""

import csv
import json
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from fingerdesign_cli.main import main

from fingerdesign.checks.load import load_design, with_values
from fingerdesign.paper import remade as paper_files
from fingerdesign.paper import remade as paper_remade
from fingerdesign.paper.claims import CLAIMS, claims_of
from fingerdesign.paper.figures import paper_figure
from fingerdesign.paper.remade import ORDER, paper_figures
from fingerdesign.records.base import ResultError
from fingerdesign.report.style import canvas, house_style

QUICK = paper_remade.Effort(frictions=(0.2, 0.3, 0.5, 1.0), samples=(100,), seeds=1)
COARSE = {
    "mesh.section.contact_size_mm": 0.1,
    "mesh.section.plate_size_mm": 0.2,
    "mesh.section.plate_end_size_mm": 0.05,
    "mesh.section.far_size_mm": 2.0,
    "mesh.section.gradation": 0.5,
}


def quick_design():
    return with_values(load_design("designs/maeno2000.toml"), COARSE)


@pytest.fixture(scope="module")
def said():
    return []


@pytest.fixture(scope="module")
def found(said):
    return paper_remade.remake(quick_design(), lambda m, f: said.append((m, f)), QUICK)


@pytest.fixture(scope="module")
def folder(found, tmp_path_factory):
    target = tmp_path_factory.mktemp("paper") / "out"
    paper_files.write_paper(found, target)
    return target


@pytest.fixture(scope="module")
def drawn(found):
    return paper_figures(found, 0.3, 0.5)


@pytest.fixture
def quickly_drawn(drawn, monkeypatch):
    """All tests but those about the drawings share one set of them: they take seconds."""
    monkeypatch.setattr("fingerdesign.paper.remade.paper_figures", lambda *_: drawn)


def claim(found, key):
    return next(c for c in found.claims if c.figure == key)


def test_progress_goes_forward(found, said):
    assert found.seconds > 0.0
    fractions = [fraction for _, fraction in said]
    assert fractions == sorted(fractions)
    assert 0.0 < fractions[0] < fractions[-1] < 1.0


def test_every_claim_has_words_a_verdict_and_numbers(found):
    assert [c.figure for c in found.claims] == list(CLAIMS)
    for each in found.claims:
        assert each.verdict in ("yes", "partly", "no")
        assert each.measured.endswith(".")
        assert each.numbers
        assert not re.search(r"\bnan\b|\binf\b", each.measured)


def test_what_holds_on_the_papers_finger_whatever_the_mesh(found):
    assert claim(found, "fig07").verdict == "yes"
    assert claim(found, "likeness").verdict == "yes"
    assert claim(found, "fig08").verdict == "yes"
    assert claim(found, "fig10").verdict == "yes"
    assert claim(found, "fig03").verdict == "partly"  # the change tells, the shape does not
    assert claim(found, "each_gage").verdict == "partly"
    assert claim(found, "fig08_relation").numbers["same_error"] < 0.05


def test_claims_follow_their_numbers(found):
    """A figure made worse must lose its yes."""
    worse = replace(found.likeness, read_correlation=np.full(8, 0.5))
    assert claim_of(replace(found, likeness=worse), "likeness").verdict == "no"
    good = replace(found.relations[1], path="same")
    better = replace(found, relations=(good,))
    assert claim_of(better, "fig08_relation").verdict == "yes"
    poor = replace(good, other_rms_mm=np.full(4, 0.07 * good.largest_mm))
    assert claim_of(replace(found, relations=(poor,)), "fig08_relation").verdict == "partly"
    lost = replace(found.lifts[0].ruled.result, lifted=False, gross_slip=True, safety_margin=None)
    slipped = replace(found.lifts[0], ruled=replace(found.lifts[0].ruled, result=lost))
    one = claim_of(replace(found, lifts=(slipped, *found.lifts[1:])), "fig10")
    assert one.verdict == "partly"
    assert "complete slip at μ = 0.2" in one.measured
    late = claim_of(replace(found, increments=found.increments[:-1]), "fig07")
    assert late.verdict == "partly"  # nothing slips as a whole


def claim_of(found, key):
    return next(c for c in claims_of(found) if c.figure == key)


def test_the_folder_holds_every_figure_three_times_a_page_and_a_record(folder):
    names = {path.name for path in folder.iterdir()}
    figures = {f"{key}.{kind}" for key in ORDER for kind in ("png", "svg", "csv")}
    assert names == {*figures, "paper.html", "paper.json"}
    assert [path.name for path in folder.parent.iterdir()] == ["out"]  # nothing left beside
    for key in ORDER:
        assert (folder / f"{key}.png").read_bytes().startswith(b"\x89PNG")
        drawing = (folder / f"{key}.svg").read_text("utf-8")
        assert "<svg" in drawing
        assert "var(--" not in drawing  # it stands alone
        assert drawing.rstrip().endswith("</svg>")


def rows_of(folder, key):
    with (folder / f"{key}.csv").open(encoding="utf-8", newline="") as stream:
        return list(csv.DictReader(stream))


def test_data_files_hold_what_the_figures_show(folder, found):
    eight = rows_of(folder, "fig06")
    assert [float(row["normal_force_N"]) for row in eight] == pytest.approx(
        [row.normal_force_N for row in found.increments], rel=1e-5
    )
    marks = rows_of(folder, "fig07")
    assert {row["status"] for row in marks} == {"open", "stick", "slip"}
    assert len(marks) == 8 * len(found.contact.points)
    assert {row["status"] for row in marks if row["step"] == "8"} == {"open", "slip"}
    assert {row["friction_coefficient"] for row in rows_of(folder, "fig08")} == {
        *("0.2", "0.3", "0.5", "1"),
    }
    assert {row["path"] for row in rows_of(folder, "fig08_relation")} == {
        *("similar", "same", "growing"),
    }
    turned = rows_of(folder, "fig03")
    assert len(turned) == 11
    assert float(turned[5]["pressed_lower_left_x_mm"]) < float(turned[5]["x_mm"])
    target = rows_of(folder, "fig02")[0]
    assert target["route"] == "target"
    assert float(target["normal_force_N"]) == pytest.approx(0.5 * 9.80665 * 0.5 / 0.3, rel=1e-5)
    assert {row["rule"] for row in rows_of(folder, "fig10")} == {"paper", "never_holding"}
    noisy = rows_of(folder, "fig12_noise")
    assert {row["samples_a_step"] for row in noisy} == {"", "100"}
    assert len({row["finger"] for row in noisy}) == 2


def test_the_record_and_the_page(folder, found):
    record = json.loads((folder / "paper.json").read_text("utf-8"))
    assert record["design"] == "maeno2000"
    assert [each["figure"] for each in record["claims"]] == list(CLAIMS)
    assert [each["key"] for each in record["figures"]] == list(ORDER)
    page = (folder / "paper.html").read_text("utf-8")
    assert page.count("<svg") == len(ORDER)
    assert "<script" not in page
    assert "http:" not in page.replace("http://www.w3.org", "")
    for each in found.claims:
        assert f'id="figure-{each.figure}"' in page
    for name in re.findall(r'href="([^"#:]+)"', page):
        if not name.startswith("data"):
            assert (folder / name).is_file(), name


def test_ids_of_the_page_are_unique(folder):
    ids = re.findall(r'\bid="([^"]+)"', (folder / "paper.html").read_text("utf-8"))
    assert len(ids) == len(set(ids))


@pytest.mark.usefixtures("quickly_drawn")
def test_other_files_in_the_folder_are_left_alone_and_figures_replaced(found, tmp_path):
    (tmp_path / "mine.txt").write_text("mine", encoding="utf-8")
    (tmp_path / "fig02.png").write_text("older", encoding="utf-8")
    files = paper_files.write_paper(found, tmp_path)
    assert files[-1].name == "paper.html"
    assert (tmp_path / "mine.txt").read_text("utf-8") == "mine"
    assert (tmp_path / "fig02.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.usefixtures("quickly_drawn")
def test_a_folder_in_the_way_is_a_named_failure(found, tmp_path):
    (tmp_path / "fig02.png").mkdir()
    with pytest.raises(ResultError, match="cannot write into"):
        paper_files.write_paper(found, tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == ["fig02.png"]


def test_cells_of_a_data_file(tmp_path):
    with house_style():
        made = paper_figure(
            canvas(1.0, 1.0),
            "each_gage",
            ("a", "b"),
            [(np.float64(1.0 / 3.0), None), (np.int64(3), float("nan")), ("x", np.bool_(True))],
            places=(),
        )
    made.write(tmp_path)
    text = (tmp_path / "each_gage.csv").read_text("utf-8")
    assert text == "a,b\n0.333333,\n3,\nx,1\n"


def test_two_runs_draw_the_same(folder, drawn):
    for figure in drawn:
        assert (folder / f"{figure.key}.png").read_bytes() == figure.png
        assert (folder / f"{figure.key}.svg").read_text("utf-8") == figure.svg


@pytest.mark.usefixtures("quickly_drawn")
def test_the_command_writes_reports_and_says(found, tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(paper_remade, "remake", lambda design, report: found)
    assert main(["paper", "--out", str(tmp_path / "a"), "--json"]) == 0
    reported = json.loads(capsys.readouterr().out)
    assert len(reported["claims"]) == len(CLAIMS)
    assert reported["files"][-1].endswith("paper.html")
    assert main(["paper", "--out", str(tmp_path / "a")]) == 0
    assert "Rhomboids under stick" in capsys.readouterr().out
    assert main(["paper", "--out", str(tmp_path / "b"), "--quiet"]) == 0
    assert capsys.readouterr().out == ""


def test_wrong_input_is_refused_before_any_work(tmp_path, capsys):
    out = tmp_path / "out"
    assert main(["paper", "--design", "homogeneous", "--out", str(out)]) == 2
    assert "plates.count = 0" in capsys.readouterr().err
    assert main(["paper", "--design", "nothing", "--out", str(out)]) == 2
    assert main(["paper", "--design", "both_ways", "--out", str(out)]) == 2
    assert "plane-strain" in capsys.readouterr().err
    (tmp_path / "file").write_text("", encoding="utf-8")
    assert main(["paper", "--out", str(tmp_path / "file")]) == 2
    assert not out.exists()


@pytest.mark.slow
def test_the_whole_command(tmp_path, capsys):
    """Measured: 23 s of processor time, on one core."""
    assert main(["paper", "--out", str(tmp_path), "--json"]) == 0
    reported = {each["figure"]: each for each in json.loads(capsys.readouterr().out)["claims"]}
    verdicts = {key: each["verdict"] for key, each in reported.items()}
    text = Path("docs/paper.md").read_text("utf-8")
    documented = re.findall(r"^\| `(\w+)`: .* \| (yes|partly|no) \|", text, flags=re.MULTILINE)
    assert verdicts == dict(documented)
    relation = reported["fig08_relation"]["numbers"]
    assert relation["same_error"] < 0.03
    assert relation["growing_error"] > 0.05
    assert (tmp_path / "paper.html").stat().st_size > 100_000
