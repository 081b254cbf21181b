"""Robots of sizes that nobody builds: what overflows or is lost in rounding proves nothing."""

import ctypes
import ctypes.util
import sys
from pathlib import Path

import numpy as np
import pytest

from certificates import check
from certificates.arithmetic.floats import Floats, machine_rounds
from certificates.container import read, write
from certificates.verdicts import Verdict
from solvers import forward_kinematics

HERE = Path(__file__).parent
DIRECTIONS = {"down": 0x400, "up": 0x800, "towards zero": 0xC00}
"""Rounding modes of x86 processors."""


def test_a_quotient_that_overflows_is_no_lower_bound():
    sizes = np.array([1.5e154, 1e-300, 1.6004e-162, 2.0**-600, 2.0**600, np.inf, np.nan])
    with np.errstate(all="ignore"):
        assert np.all(Floats.square_quotient(sizes, sizes) == 0.0)
        assert np.all(Floats.square_quotient(np.ones(7), sizes) == 0.0)
        assert 0.999 < Floats.square_quotient(np.array([3.0]), np.array([9.0]))[0] < 1.0


def test_a_forged_certificate_of_a_huge_robot_is_refused():
    """Two static poses in cells that are claimed to be unbalanced, of cables longer than 1e76 m."""
    report = check(HERE / "data" / "huge_robot.cert")
    assert report.verdict is Verdict.NOT_PROVED and "are not checked" in report.message


@pytest.mark.parametrize("power", [40, -40, 200])
def test_lengths_out_of_range_are_refused(power, tmp_path):
    document = read(forward_kinematics("uc2", ["7.5", "8"]).certificate(tmp_path / "c"))
    for cable in document["robot"]["cables"]:
        for key in ("frame_anchor_m", "platform_anchor_m"):
            cable[key] = [f"{v}e{power}" if "e" not in v and "/" not in v else v for v in cable[key]]
    document["lengths_m"] = [[f"{v}e{power}" for v in pair] for pair in document["lengths_m"]]
    write(tmp_path / "c", document)
    assert check(tmp_path / "c").verdict is Verdict.NOT_PROVED


@pytest.mark.skipif(sys.platform != "linux", reason="the modes' numbers are those of Linux")
@pytest.mark.parametrize("mode", DIRECTIONS)
def test_another_rounding_mode_proves_nothing(mode, tmp_path):
    path = forward_kinematics("uc2", ["7.5", "8"]).certificate(tmp_path / "c")
    library = ctypes.CDLL(ctypes.util.find_library("m"))
    before = library.fegetround()
    if library.fesetround(DIRECTIONS[mode]) != 0:
        pytest.skip("no such mode here")
    try:
        rounds, report = machine_rounds(), check(path)
    finally:
        library.fesetround(before)
    assert not rounds and report.verdict is Verdict.NOT_PROVED and "rounded to nearest" in report.message
    assert machine_rounds() and check(path).complete
