"""The summary of a batch as text."""

from __future__ import annotations

from typing import Any, TextIO

from solvers.batch.headline import headline

WIDTH = 12


def print_summary(document: dict[str, Any], stream: TextIO) -> None:
    """Print what a ``cdpr-batch-summary/1`` document says."""
    total = sum(document["jobs"].values())
    counts = ", ".join(f"{count} {name}" for name, count in document["jobs"].items() if count)
    print(f"{total} jobs: {counts}; {headline(document)}", file=stream)
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
    if group["quantities"]:
        heads = ("mean", "min", "max", "p5", "p50", "p95")
        print("  " + " ".join([f"{'':{WIDTH}}", *(f"{head:>{WIDTH}}" for head in heads)]), file=stream)
        for name, values in group["quantities"].items():
            cells = [f"{values[head]:>{WIDTH}.6g}" for head in heads]
            print("  " + " ".join([f"{name:{WIDTH}}", *cells]), file=stream)
