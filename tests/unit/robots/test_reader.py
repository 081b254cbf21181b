"""What a valid robot file becomes, and where a name leads."""

import json
from fractions import Fraction

import pytest

from cdpr_interval import InputError, load_robot
from cdpr_interval.exact.range import Range
from cdpr_interval.robots.cable_robot import Uncertain
from cdpr_interval.robots.formats.reader import parse_robot
from cdpr_interval.robots.shipped import shipped_robots

FULL = """\
# a comment
format: cdpr-robot/1
name: no            # a string, YAML 1.2
source: "somewhere, p. 3"
notes: {anything: [1, two]}
x_mine: true
gravity_m_s2: [0, -9.80665, 0]
platform:
  mass_kg: 80
  centre_of_mass_m: [0, 0.1, 1e-3]
cables:
  - name: c1
    frame_anchor_m: [0.1, -4, +010]
    platform_anchor_m: [.5, 5., 0x10]
    elasticity: {stiffness_N_per_m: 1.0e5}
    tension_limits_N: [0, 5000]
  - name: c_2.a-b
    x_serial: 7
    frame_anchor_m:
      - 1
      - 2
      - 3
    platform_anchor_m: [0, 0, 0]
    elasticity:
      axial_stiffness_N: 1.3e6
"""
SMALL = """\
format: cdpr-robot/1
name: small
platform: {{mass_kg: {mass}}}
cables:
  - {{name: c1, frame_anchor_m: [{x}, 0, 0], platform_anchor_m: [0, 0, 0]}}
"""


def small(mass: str = "1", x: str = "0") -> str:
    return SMALL.format(mass=mass, x=x)


def test_every_key_of_the_format():
    robot = parse_robot(FULL)
    assert robot.name == "no"
    assert robot.source == "somewhere, p. 3"
    assert robot.gravity == (0, Fraction("-9.80665"), 0)
    assert robot.platform.mass == 80
    assert robot.platform.centre_of_mass == (0, Fraction(1, 10), Fraction(1, 1000))
    first, second = robot.cables
    assert (first.name, second.name) == robot.cable_names == ("c1", "c_2.a-b")
    assert first.frame_anchor == (Fraction(1, 10), -4, 10)
    assert first.platform_anchor == (Fraction(1, 2), 5, 16)
    assert first.elasticity is not None and first.elasticity.stiffness == 100000
    assert first.tension_limits == (0, 5000)
    assert second.frame_anchor == (1, 2, 3)
    assert second.elasticity is not None and second.elasticity.axial_stiffness == 1300000
    assert second.tension_limits is None
    assert robot.uncertain == ()


def test_defaults():
    robot = parse_robot(small())
    assert robot.gravity == (0, 0, Fraction("-9.81"))
    assert robot.platform.centre_of_mass == (0, 0, 0)
    assert robot.source is None
    assert robot.is_point_mass and not robot.is_elastic


@pytest.mark.parametrize(
    ("literal", "value"),
    [
        ("0.1", Fraction(1, 10)),
        ("1e-3", Fraction(1, 1000)),
        ("-1E+3", Fraction(-1000)),
        ("010", Fraction(10)),
        ("0o10", Fraction(8)),
        ("+.5", Fraction(1, 2)),
        ("5.", Fraction(5)),
        ("-0.0", Fraction(0)),
        ("0e999999999", Fraction(0)),
        ("2.6925824035672520156253551", Fraction(26925824035672520156253551, 10**25)),
    ],
)
def test_a_number_is_the_exact_decimal(literal: str, value: Fraction):
    assert parse_robot(small(x=literal)).cables[0].frame_anchor[0] == value


def test_uncertain_scalars_stay_ranges_and_are_listed():
    robot = parse_robot(small(mass="{value: 2.0, tolerance: 0.001}", x="[0.1, 0.2]"))
    assert robot.platform.mass == Range(Fraction("1.999"), Fraction("2.001"))
    assert robot.cables[0].frame_anchor[0] == Range(Fraction(1, 10), Fraction(1, 5))
    assert robot.uncertain == (
        Uncertain("platform.mass_kg", Fraction("1.999"), Fraction("2.001")),
        Uncertain("cables[0].frame_anchor_m[0]", Fraction(1, 10), Fraction(1, 5)),
    )


def test_a_range_without_width_is_exact():
    robot = parse_robot(small(mass="{value: 2, tolerance: 0}", x="[1, 1.0]"))
    assert robot.uncertain == ()
    assert (robot.platform.mass, robot.cables[0].frame_anchor[0]) == (Fraction(2), Fraction(1))


def test_json_with_tabs_keeps_exact_literals():
    text = """{"format": "cdpr-robot/1", "name": "j", "platform": {"mass_kg": 1E0},
\t"cables": [{"name":"c1","frame_anchor_m":[0.1,0,0],"platform_anchor_m":[0,0,0]}]}"""
    json.loads(text)
    assert parse_robot(text).cables[0].frame_anchor[0] == Fraction(1, 10)


def test_byte_order_mark_and_windows_line_ends():
    text = small().replace("\n", "\r\n")
    assert parse_robot(b"\xef\xbb\xbf" + text.encode()).name == "small"


def test_file_and_digest(tmp_path):
    path = tmp_path / "robot.yaml"
    path.write_bytes(small().encode())
    by_path, by_text = load_robot(path), load_robot(str(path))
    assert by_path == by_text
    assert by_path.sha256 == parse_robot(small()).sha256
    assert len(by_path.sha256) == 64


def test_a_shipped_robot_by_name_from_anywhere(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "uc2").mkdir()
    assert load_robot("merlet_4_1") == load_robot("merlet_4_1.yaml")
    assert load_robot("uc2").name == "uc2"


def test_an_existing_file_wins_over_a_shipped_name(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "merlet_4_1").write_text(small())
    assert load_robot("merlet_4_1").name == "small"


@pytest.mark.parametrize("name", ["merlet_41", "Merlet-4-1", "some/where/merlet_41.yaml"])
def test_unknown_name_lists_near_ones(name: str):
    with pytest.raises(InputError) as caught:
        load_robot(name)
    (message,) = caught.value.messages
    assert message.startswith(f"{name}: no such file or shipped robot (did you mean 'merlet_4_1'")


def test_unknown_name_far_from_all_lists_all():
    with pytest.raises(InputError) as caught:
        load_robot("qqqq")
    assert all(name in str(caught.value) for name in shipped_robots())
