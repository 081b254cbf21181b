"""Examples in the docstrings of public names print what they show."""

from __future__ import annotations

import doctest
import inspect
from importlib import import_module

import pytest

PUBLIC = [
    (package, name)
    for package in ("cdpr_interval", "solvers", "certificates")
    for name in import_module(package).__all__
]
WITHOUT = {"motion_picture", "result_figure", "write_certificate", "write_report"}
"""Functions that are methods of results, which have the examples."""


def thing(package: str, name: str):
    return getattr(import_module(package), name)


@pytest.mark.parametrize(("package", "name"), PUBLIC)
def test_a_public_name_has_words(package: str, name: str):
    assert inspect.getdoc(thing(package, name)).endswith(".") or "\n" in inspect.getdoc(thing(package, name))


@pytest.mark.parametrize(("package", "name"), PUBLIC)
def test_examples_run(package: str, name: str, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    one = thing(package, name)
    found = doctest.DocTestFinder(recurse=inspect.isclass(one)).find(one, name, globs={name: one})
    tests = [test for test in found if test.examples]
    report: list[str] = []
    runner = doctest.DocTestRunner(optionflags=doctest.ELLIPSIS)
    for test in tests:
        runner.run(test, out=report.append)
    assert runner.failures == 0, "".join(report)
    if inspect.isfunction(one) and name not in WITHOUT:
        assert tests, "a public function has an example"
