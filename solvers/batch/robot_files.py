"""The robots of a batch with the bytes of their files, which travel with the jobs."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from cdpr_interval.errors import InputError
from cdpr_interval.files.document import Document, Node
from cdpr_interval.robots.cable_robot import Robot
from cdpr_interval.robots.formats.reader import parse_robot, read_robot
from cdpr_interval.text.literal import quote
from solvers.batch.job_schema import RobotFolder
from solvers.classes import require_supported
from solvers.questions.errors import InputErrors

SUFFIXES = (".yaml", ".yml", ".json")


@dataclass(frozen=True)
class RobotFile:
    """A robot and where it comes from."""

    robot: Robot
    source: str
    """As the job file names it."""
    data: bytes


def read_robots(
    document: Document, entries: list[str | RobotFolder], nodes: list[Node], base: Path
) -> list[RobotFile]:
    """Return the robots of a job file, errors noted in the document.

    Parameters
    ----------
    document : Document
    entries : list of str or RobotFolder
        The checked entries of ``robots``.
    nodes : list of Node
        Where they stand.
    base : Path
        Folder to which names of files are relative.
    """
    found: list[RobotFile] = []
    owner: dict[str, str] = {}
    for index, (entry, node) in enumerate(zip(entries, nodes, strict=True)):
        place = f"robots[{index}]"
        try:
            sources = [entry] if isinstance(entry, str) else _files(entry, base)
            for source in sources:
                robot = _read(source, base)
                name = robot.robot.name
                if name in owner:
                    raise InputError(f"{quote(source)}: {quote(name)} is the name of {owner[name]} already")
                owner[name] = f"{quote(source)} in {place}"
                found.append(robot)
        except InputError as error:
            for message in error.messages:
                document.report(node, place, message)
    return found


def _files(entry: RobotFolder, base: Path) -> list[str]:
    folder = base / entry.folder
    try:
        names = sorted(path.name for path in folder.iterdir() if path.suffix in SUFFIXES)
    except OSError as error:
        raise InputError(f"folder {quote(entry.folder)}: {error.strerror}") from None
    if not names:
        raise InputError(f"folder {quote(entry.folder)}: no robot file in it")
    return [str(Path(entry.folder) / name) for name in names]


def _read(source: str, base: Path) -> RobotFile:
    errors = InputErrors()
    path = base / source
    data, name = read_robot(str(path) if "\0" not in source and path.is_file() else source)
    robot = errors.read(parse_robot, data, name)
    errors.require_none()
    assert robot is not None
    require_supported(robot)
    return RobotFile(robot, source, data)
