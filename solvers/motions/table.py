"""A motion as text: its sentence, a row for every segment, and its events; and as CSV."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterator, Sequence
from decimal import ROUND_CEILING, ROUND_FLOOR

import numpy as np

from cdpr_interval.text.count import counted
from solvers.answers.digits import proved_decimal, proved_significant
from solvers.motions.data import Event, MotionData, PoseData, Segment
from solvers.motions.times import between, shown_time

MOST_ROWS = 40
"""Segments that are listed; JSON and CSV have all."""
DECIMALS = 6
DIGITS = 4
"""Of tensions."""


def text_of(motion: MotionData) -> str:
    """Return the table as plain text."""
    cables = counted(len(motion.cables), "cable")
    lines = [f"{motion.robot.name} ({motion.model}, {cables}): {motion.message}"]
    span = motion.question.t[1] - motion.question.t[0]
    lines += _track(motion.cables, span, motion.segments, motion.events)
    for number, track in enumerate(motion.others, 2):
        lines += ["", f"stable pose {number} at the start, {_place(track.start)}"]
        lines += _track(motion.cables, span, track.segments, track.events)
    return "\n".join(lines)


def _track(
    names: Sequence[str], span: float, segments: Sequence[Segment], events: Sequence[Event]
) -> Iterator[str]:
    """Yield the lines about one pose."""
    if segments:
        head = ("t s", "taut", "switching", "x m", "y m", "z m", "tensions N")
        rows = [head, *(_row(names, span, one) for one in segments[:MOST_ROWS])]
        widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
        for row in rows:
            cells = (cell.ljust(width) for cell, width in zip(row, widths, strict=True) if width)
            yield "  ".join(cells).rstrip()
        if len(segments) > MOST_ROWS:
            yield f"... {counted(len(segments) - MOST_ROWS, 'more segment')}: in --json and --csv"
    for event in events:
        yield f"{between(*event.t, span)} s: {_happened(event)}"
        yield from (f"    {pose.stability} pose afterwards: {_pose(names, pose)}" for pose in event.poses)


def _row(names: Sequence[str], span: float, segment: Segment) -> tuple[str, ...]:
    tensions = [
        "0" if not hi else proved_significant(lo, hi, DIGITS) for lo, hi in segment.tube.tensions.tolist()
    ]
    return (
        _times(segment, span),
        ",".join(names[i] for i in segment.taut),
        ",".join(names[i] for i in segment.switching),
        *(proved_decimal(lo, hi, DECIMALS) for lo, hi in segment.tube.position.tolist()),
        ", ".join(tensions),
    )


def _times(segment: Segment, span: float) -> str:
    """Return when a segment holds: rounded outwards where cables switch, else inwards."""
    if segment.switching:
        return between(*segment.t, span)
    begin, end = segment.t
    return f"{shown_time(begin, span, ROUND_CEILING)}..{shown_time(end, span, ROUND_FLOOR)}"


def _happened(event: Event) -> str:
    if event.cable is not None:
        return f"{event.cable} becomes {event.kind}"
    return f"{event.kind}: {event.reason}"


def _pose(names: Sequence[str], pose: PoseData) -> str:
    return f"{_place(pose)}, taut {','.join(names[i] for i in pose.taut)}"


def _place(pose: PoseData) -> str:
    return f"({', '.join(f'{x:z.6f}' for x in pose.position.mean(axis=1))}) m"


def csv_of(motion: MotionData) -> str:
    """Return a row for every segment of every pose that is followed, under a head."""
    stream = io.StringIO()
    writer = csv.writer(stream, lineterminator="\n")
    bounds = [f"{name}_{end}" for name in ("x", "y", "z") for end in ("lo_m", "hi_m")]
    bounds += [f"r{i}{j}_{end}" for i in "123" for j in "123" for end in ("lo", "hi")]
    bounds += [f"tension_{name}_{end}_N" for name in motion.cables for end in ("lo", "hi")]
    writer.writerow(["pose", "t_begin_s", "t_end_s", "taut", "switching", *bounds])
    every = [motion.segments, *(track.segments for track in motion.others)]
    for number, segments in enumerate(every, 1):
        for one in segments:
            cables = (" ".join(motion.cables[i] for i in group) for group in (one.taut, one.switching))
            tube = one.tube
            numbers = np.concatenate([tube.position.ravel(), tube.rotation.ravel(), tube.tensions.ravel()])
            writer.writerow([number, *map(repr, one.t), *cables, *map(repr, numbers.tolist())])
    return stream.getvalue()
