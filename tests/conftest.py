"""Settings of every test: no files left behind, the same examples on every run."""

import tempfile

import pytest
from hypothesis import configuration, settings

from solvers.commands import progress

_scratch = tempfile.TemporaryDirectory(prefix="cdpr-hypothesis-")
configuration.set_hypothesis_home_dir(_scratch.name)
settings.register_profile("suite", database=None, deadline=None, print_blob=True, derandomize=True)
settings.register_profile("fuzz", settings.get_profile("suite"), derandomize=False)
settings.load_profile("suite")


def pytest_report_header(config: pytest.Config) -> str:
    """Say which examples the property tests draw; every other random number has its seed in the test."""
    if settings.default.derandomize:
        return "property tests: the same examples on every run (derandomised); `make fuzz` draws others"
    return f"property tests: new examples, --hypothesis-seed={config.getoption('--hypothesis-seed')}"


@pytest.fixture(autouse=True)
def no_columns(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let tables be as wide as in a pipe: who runs the tests may sit at a terminal of any width."""
    monkeypatch.delenv("COLUMNS", raising=False)


@pytest.fixture(autouse=True)
def no_lines_of_a_log(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let commands print the same on a slow machine: after ten seconds they would say how far they are."""
    monkeypatch.setattr(progress, "SECONDS_BETWEEN", 3600.0)
