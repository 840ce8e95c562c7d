"""fingerdesign view: what a result holds and where its report is."""

import json

import pytest
from fingerdesign_cli.main import main

from tests.support.result_folders import write_result_folder


@pytest.fixture
def out(tmp_path, plane_strain, failed):
    for analysis in (plane_strain, failed):
        result = analysis.result
        write_result_folder(tmp_path / result.design, result, texts={"report.html": "<p>"})
    return tmp_path


def test_one_result_is_shown_with_its_report(out, capsys):
    assert main(["view", str(out / "maeno2000")]) == 0
    shown = capsys.readouterr().out
    assert f"report: {out / 'maeno2000' / 'report.html'}" in shown
    assert "YES    Does the gage area follow the stick area?" in shown
    assert "tangential force (N)" in shown
    assert "0.394" in shown  # the stick ratio of increment 6


def test_every_result_of_an_out_folder_is_shown(out, capsys):
    assert main(["view", str(out), "--json"]) == 0
    shown = json.loads(capsys.readouterr().out)
    assert [item["design"] for item in shown] == ["maeno2000", "narrow"]
    assert shown[1]["status"] == "failed"
    assert "No mesh passed" in shown[1]["failure"]


def test_the_browser_opens_only_when_requested(out, monkeypatch):
    opened = []
    monkeypatch.setattr("click.launch", opened.append)
    assert main(["view", str(out / "narrow"), "--quiet"]) == 0
    assert opened == []
    assert main(["view", str(out / "narrow"), "--quiet", "--open"]) == 0
    assert opened == [(out / "narrow" / "report.html").as_uri()]


def test_no_result_is_wrong_input_said_in_one_line(tmp_path, capsys):
    assert main(["view", str(tmp_path / "nowhere")]) == 2
    assert capsys.readouterr().err.startswith("DIR = ")
    (tmp_path / "result.json").write_text("{", encoding="utf-8")
    assert main(["view", str(tmp_path)]) == 2
    assert "result.json: JSON = " in capsys.readouterr().err
