"""What ``analyse`` returns: figures and maps where arrays are, a plain word where they are not."""

from dataclasses import replace

import numpy as np
import pytest

from fingerdesign import load_result
from fingerdesign.analysis.analysed import Analysed
from fingerdesign.records.arrays import STICK, write_packed
from fingerdesign.records.base import ResultError
from fingerdesign.records.result import Result
from tests.support.result_folders import write_result_folder


@pytest.fixture
def found(plane_strain):
    return Analysed.of(plane_strain)


def test_figures_are_those_of_the_page_at_the_increments_requested(found):
    names = [each.name for each in found.plot_path().data]
    assert names == ["normal force", "tangential force", "stick ratio"]
    assert {each.name for each in found.plot_contact(2).data} == {"increment 3"}
    assert {each.name for each in found.plot_contact().data} == {"increment 8"}
    assert {each.name for each in found.plot_gages([0, -1]).data} == {"increment 1", "increment 8"}
    assert len(found.plot_gages().data) == 8
    assert found.plot_finger(1).layout.sliders[0].active == 1


def test_maps_of_the_contact_are_arrays(found, plane_strain):
    contact, maps = plane_strain.contact, found.arrays()
    k, m = contact.status.shape
    assert maps["contact_points_mm"].shape == (m, 2)
    assert maps["pressure_MPa"].shape == maps["status"].shape == (k, m)
    assert maps["shear_traction_MPa"].shape == maps["slip_mm"].shape == (k, m, 1)
    assert maps["gages"].shape == (k, 15)
    ratio = [(contact.areas * (row == STICK)).sum() for row in maps["status"]]
    assert ratio[-1] < ratio[0]
    forces = np.array([row.normal_force_N for row in found.increments])
    pressed = 10.0 * maps["pressure_MPa"] @ contact.areas
    assert pressed == pytest.approx(forces, rel=0.01)


def test_a_folder_gives_back_all_of_it_and_a_record_alone_says_what_it_lacks(
    plane_strain, tmp_path
):
    write_result_folder(tmp_path / "mine", plane_strain.result)
    alone = load_result(tmp_path / "mine")
    assert alone == plane_strain.result
    assert alone.plot_path().data
    assert alone.plot_gages().data
    for ask in (alone.plot_contact, alone.plot_finger, lambda: alone.arrays()["status"]):
        with pytest.raises(ResultError, match=r"holds no .*load_result of a folder"):
            ask()
    assert alone.arrays()["normal_force_N"].shape == (8,)
    names = ("contact", "mesh", "fields", "plates", "gages", "depth_mm")
    held = {name: getattr(plane_strain, name) for name in names}
    write_packed(tmp_path / "mine" / "arrays.npz", held)
    assert load_result(tmp_path / "mine").plot_contact().data
    status = plane_strain.contact.status.copy()
    status[3, np.flatnonzero(status[3] == STICK)[0]] = 0
    (tmp_path / "mine" / "arrays.npz").unlink()
    other = held | {"contact": replace(plane_strain.contact, status=status)}
    write_packed(tmp_path / "mine" / "arrays.npz", other)
    with pytest.raises(ResultError, match="of another analysis than its result"):
        load_result(tmp_path / "mine")


def test_what_is_not_there_is_refused(found, failed):
    with pytest.raises(ResultError, match="increment = 8 must be -8 to 7, an index"):
        found.plot_contact(8)
    with pytest.raises(ResultError, match="there are no increments"):
        Analysed.of(failed).plot_path()
    with pytest.raises(ResultError, match="no gages"):
        Analysed.of(failed).plot_gages()
    bare = Result.from_json(found.to_json())
    assert "status" not in bare.arrays()
