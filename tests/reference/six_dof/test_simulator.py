"""A physics simulator agrees: what is dropped comes to rest at a pose that is listed as stable.

MuJoCo knows nothing of taut subsets, Hessians or intervals: a body on tendons whose lengths are limited,
with damping, falls until it rests. Its limits are soft: at rest a limit is exceeded by about (1 - d) / (d k)
of the acceleration that it holds, with impedance d = 0.9999 and k = 1 / timeconst^2, some 1e-7 m here
(`EXCESS` is checked). A pose moves by less than a hundred times that, and the listed poses lie more than a
hundred times `NEAR` apart (checked), so that there is no doubt which one is meant.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import mujoco
import numpy as np
import pytest

from cdpr_interval import load_robot
from cdpr_interval.mechanics.orientation import rotation_from_quaternion
from cdpr_interval.mechanics.stability import Stability
from cdpr_interval.robots.cable_robot import Robot
from solvers import forward_kinematics, inverse_kinematics
from solvers.answers.data import Outcome
from solvers.answers.result import Result

EXCESS = 1e-6
"""m: most that a tendon may be longer than its limit at rest."""
NEAR = 1e-4
"""m, and rotation entries: a resting body is at a listed pose."""
REST = 1e-7
"""m/s and rad/s: with these dampings the rest of the way is below a hundredth of `NEAR`."""
STEP = 0.002
CHUNK, MOST_CHUNKS = 2_000, 150
UC3 = (7.5, 8.0, 7.0)
UC4 = (7.5, 8.0, 7.0, 9.0)


@dataclass(frozen=True)
class Rest:
    """Where a body came to rest: platform origin and rotation."""

    position: np.ndarray
    rotation: np.ndarray


def floats(vector) -> np.ndarray:
    return np.array([float(x) for x in vector])


def words(vector) -> str:
    return " ".join(repr(float(x)) for x in vector)


def simulated(robot: Robot, lengths) -> mujoco.MjModel:
    """Return the robot as a free body on tendons with length limits."""
    mass, centre = float(robot.platform.mass), floats(robot.platform.centre_of_mass)
    size = max(np.linalg.norm(floats(c.platform_anchor) - centre) for c in robot.cables)
    inertia = mass * size**2 / 2
    ends = [f'<site name="p{c.name}" pos="{words(c.platform_anchor)}"/>' for c in robot.cables]
    exits = [f'<site name="f{c.name}" pos="{words(c.frame_anchor)}"/>' for c in robot.cables]
    limits = 'limited="true" solreflimit="0.01 1" solimplimit="0.9999 0.9999 0.001 0.5 2"'
    cables = "".join(
        f'<spatial {limits} range="0 {length!r}"><site site="f{c.name}"/><site site="p{c.name}"/></spatial>'
        for c, length in zip(robot.cables, lengths, strict=True)
    )
    model = mujoco.MjModel.from_xml_string(
        f"""<mujoco>
        <option timestep="{STEP}" gravity="{words(robot.gravity)}" integrator="implicitfast"
                iterations="200" tolerance="1e-14"/>
        <worldbody>{"".join(exits)}
          <body><freejoint/>{"".join(ends)}
          <inertial pos="{words(centre)}" mass="{mass}" diaginertia="{words([inertia] * 3)}"/></body>
        </worldbody>
        <tendon>{cables}</tendon></mujoco>"""
    )
    # Damped so that it neither swings nor creeps for long: the pendulum's own frequency.
    rate = np.sqrt(np.linalg.norm(floats(robot.gravity)) / max(lengths))
    model.dof_damping[:] = [mass * rate] * 3 + [inertia * rate] * 3
    return model


def dropped(model: mujoco.MjModel, rng: np.random.Generator, around) -> Rest:
    """Drop the body from a random pose near a place and wait until it rests."""
    data = mujoco.MjData(model)
    q = rng.normal(size=4)
    data.qpos[:3] = np.asarray(around) + rng.normal(size=3)
    data.qpos[3:] = q / np.linalg.norm(q)
    for _ in range(MOST_CHUNKS):
        mujoco.mj_step(model, data, CHUNK)
        if np.abs(data.qvel).max() < REST:
            break
    else:
        raise AssertionError(f"still moving: {data.qvel}")
    assert np.max(data.ten_length - model.tendon_range[:, 1]) < EXCESS
    return Rest(data.qpos[:3].copy(), rotation_from_quaternion(data.qpos[3:].copy()))


def gap(solution, rest: Rest) -> float:
    """Return how far a resting body is from a listed pose: position in m and rotation entries."""
    position, rotation = solution.position.mean(axis=-1), solution.rotation.mean(axis=-1)
    return float(max(np.abs(position - rest.position).max(), np.abs(rotation - rest.rotation).max()))


def resting_places(result: Result, rests, stability: Stability = Stability.STABLE) -> list[int | None]:
    """Return for each resting body which listed pose of that stability it is at; None for none."""
    places: list[int | None] = []
    for rest in rests:
        near = [k for k, s in enumerate(result.solutions) if s.stability is stability and gap(s, rest) < NEAR]
        places.append(near[0] if near else None)
    return places


@cache
def answered(name: str, lengths: tuple[float, ...]) -> Result:
    result = forward_kinematics(load_robot(name), list(lengths))
    assert result.outcome is Outcome.COMPLETE
    return result


def apart(result: Result) -> float:
    """Return the least gap between two stable poses."""
    stable = [s for s in result.solutions if s.stability is Stability.STABLE and s.family is None]
    gaps = [
        gap(a, Rest(b.position.mean(axis=-1), b.rotation.mean(axis=-1)))
        for k, a in enumerate(stable)
        for b in stable[:k]
    ]
    return min(gaps, default=np.inf)


@cache
def rests(name: str, lengths: tuple[float, ...], drops: int, seed: int) -> tuple[Rest, ...]:
    model, rng = simulated(load_robot(name), lengths), np.random.default_rng(seed)
    lowest = answered(name, lengths).solutions[0].position.mean(axis=-1)
    return tuple(dropped(model, rng, lowest + np.array([0.0, 0.0, 2.0])) for _ in range(drops))


@pytest.mark.parametrize(("name", "lengths"), [("uc3", UC3), ("uc4", UC4)])
def test_a_dropped_platform_rests_at_a_stable_pose(name: str, lengths: tuple[float, ...]) -> None:
    result = answered(name, lengths)
    assert apart(result) > 100 * NEAR
    assert None not in resting_places(result, rests(name, lengths, 4, 17))


@cache
def cogiro_lengths(taut: str) -> tuple[float, ...]:
    """Return the lengths of CoGiRo hanging on four of its eight cables, the others 5 % longer."""
    pose = {"position": [0.5, -0.4, 1.5], "rpy": [0.0, 0.0, 0.0]}
    result = inverse_kinematics(
        load_robot("cogiro"), pose["position"], taut=taut, slack_margin=0.05, settle=True, settle_within=6.0
    )
    return tuple(float(x) for x in result.lengths)


@pytest.mark.slow
@pytest.mark.parametrize("taut", ["c1,c3,c5,c7", "c2,c4,c6,c8"])
def test_cogiro_on_four_of_eight_cables_rests_at_a_stable_pose(taut: str) -> None:
    lengths = cogiro_lengths(taut)
    result = answered("cogiro", lengths)
    assert apart(result) > 100 * NEAR
    assert None not in resting_places(result, rests("cogiro", lengths, 6, 18))


def test_the_comparison_can_fail() -> None:
    """Neither an unstable pose nor the stable pose of other lengths passes for the resting place."""
    result, fallen = answered("uc3", UC3), rests("uc3", UC3, 4, 17)
    assert set(resting_places(result, fallen, Stability.UNSTABLE)) == {None}
    other = answered("uc3", (UC3[0], UC3[1], UC3[2] + 0.001))
    assert set(resting_places(other, fallen)) == {None}
