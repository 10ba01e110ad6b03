"""Grazes as a study of a map of launches: the same curves, a cell fewer than values."""

import csv

import numpy as np
import pytest

import grazing as gz
from grazing.catalogue import studies
from grazing.export import to_csv
from grazing.studies.grazed import grazed
from tests.maps.test_grazes import TABLE, WIDE

POINT = 3.0, 2.0


def test_it_finds_what_grazes_does_and_tells_it():
    grid = {"angle": np.linspace(*WIDE["angle"], 17), "speed": np.linspace(*WIDE["speed"], 9)}
    found = grazed(gz.launch_map(TABLE, POINT), grid, impacts=0, objects="A, B")
    assert found.identical(gz.grazes(TABLE, POINT, **WIDE, order=0, objects=["A", "B"], cells=(16, 8)))
    study = studies()["grazes"]
    told = study.found(found)
    assert told["curves"] == found.sizes["curve"] and told["points"] == int(np.isfinite(found.angle).sum())
    assert sum(row["curves"] for row in told["grazes"]) == told["curves"]
    assert study.words(told)[-1] == f"{told['curves']} curves of {told['points']} points"


def test_its_points_and_curves_are_tables(tmp_path):
    """What said for each point which curve it is of had the name of their dimension: no table could be written."""
    found = gz.grazes(TABLE, POINT, **WIDE, order=0, objects=["A", "B"], cells=(16, 8))
    points, curves = (list(csv.DictReader(file.read_text().splitlines())) for file in to_csv(found, tmp_path / "a.csv"))
    assert [int(each["row"]) for each in points] == found.row.values.tolist()
    assert [each["object"] for each in curves] == found.object.values.tolist()
    assert gz.load(gz.save(found, tmp_path / "a.nc")).identical(found)


def test_one_without_a_curve_says_so():
    grid = {"angle": np.array([1.5, 1.6]), "speed": np.array([0.1, 0.2])}
    study = studies()["grazes"]
    assert study.words(study.found(grazed(gz.launch_map(TABLE, POINT), grid))) == [
        "no graze found",
        "0 curves of 0 points",
    ]


def test_another_map_and_one_angle_are_refused():
    with pytest.raises(
        gz.InputError, match=r"grazes need a map of launches, gz.launch_map\(table\); this is a gap map"
    ):
        grazed(gz.gap_map(lam=0.5, mu=0.1, l=0.1))
    with pytest.raises(gz.InputError, match=r"angle is always 1\.5; give a range, such as angle=1:2:65"):
        grazed(gz.launch_map(TABLE, POINT), fixed={"angle": 1.5})
