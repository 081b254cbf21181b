"""The summary of a batch as text."""

from __future__ import annotations

from typing import Any, TextIO

from cdpr_interval.text.count import counted
from solvers.batch.headline import headline

WIDTH = 12
HEADS = ("mean", "std", "min", "p50", "max")
"""As many as 80 columns hold."""
MOST_BRANCHES = 8
"""That are printed; ``summary.json`` has all."""


def print_summary(document: dict[str, Any], stream: TextIO) -> None:
    """Print what a ``cdpr-batch-summary/1`` document says."""
    total = sum(document["jobs"].values())
    counts = ", ".join(f"{count} {name}" for name, count in document["jobs"].items() if count)
    named = f"{document['name']}: " if document["name"] else ""
    print(f"{named}{counted(total, 'job')}: {counts}; {headline(document)}", file=stream)
    for group in document["groups"]:
        _print_group(group, stream)


def _print_group(group: dict[str, Any], stream: TextIO) -> None:
    print(f"\nproblems[{group['problem']}]  {group['robot']}", file=stream)
    found = ", ".join(f"{count} with {n}" for n, count in group["solutions_per_job"].items())
    if found:
        print(f"  solutions: {found}", file=stream)
    for title, key in (("taut", "taut_subsets"), ("stability", "stability")):
        if group[key]:
            print(f"  {title}: " + ", ".join(f"{n} {name}" for name, n in group[key].items()), file=stream)
    if pools(group):
        _print_quantities(group["quantities"], stream)
        return
    for branch in group["branches"][:MOST_BRANCHES]:
        print(f"  {branch_title(branch)}", file=stream)
        _print_quantities(branch["quantities"], stream)
    if (more := len(group["branches"]) - MOST_BRANCHES) > 0:
        print(f"  {counted(more, 'more branch', 'more branches')} in summary.json", file=stream)


def pools(group: dict[str, Any]) -> bool:
    """Return whether the statistics over all solutions mean something: no job has more than one."""
    return all(int(count) <= 1 for count in group["solutions_per_job"])


def branch_title(branch: dict[str, Any]) -> str:
    """Return what a branch is called, and how often it was met."""
    poses = f"{counted(branch['solutions'], 'pose')} in {counted(branch['jobs'], 'job')}"
    return f"branch {branch['branch']}, {branch['stability']}, taut {branch['taut'] or '-'}: {poses}"


def _print_quantities(quantities: dict[str, dict[str, float]], stream: TextIO) -> None:
    if not quantities:
        return
    first = max(map(len, quantities))
    print("  " + " ".join([" " * first, *(f"{head:>{WIDTH}}" for head in HEADS)]), file=stream)
    for name, values in quantities.items():
        cells = [f"{values[head]:>{WIDTH}.6g}" for head in HEADS]
        print("  " + " ".join([f"{name:{first}}", *cells]), file=stream)
