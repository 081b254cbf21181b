"""Certificates of results in memory: what `Result.certificate` does."""

from __future__ import annotations

import os
import warnings
from dataclasses import replace
from pathlib import Path

from cdpr_interval.errors import InputError, NotSupportedError
from cdpr_interval.text.literal import printable
from solvers.answers.result import Result
from solvers.forward import answer_question
from solvers.questions.arguments import read_path
from solvers.questions.checked import check_budgets, require_certifiable
from solvers.questions.errors import InputErrors
from solvers.questions.problem import Method, Options, Problem


def write_certificate(result: Result, path: str | os.PathLike[str], time_limit: float | None = None) -> Path:
    """Solve the question of a result again with a record, and write the certificate."""
    from solvers.proofs.document import certificate_of
    from solvers.six_dof.record import Record

    problem, options = question_of(result)
    target, errors = read_path(path, "path"), InputErrors()
    options = replace(options, time_limit=time_limit, record=Record())
    check_budgets(options, errors, str)
    errors.require_none()
    try:
        # Before a search that may take long.
        target.open("ab").close()
        content, claim = certificate_of(problem, options, answer_question(problem, options))
        target.write_bytes(content)
    except OSError as error:
        raise InputError(f"{printable(str(target))}: cannot be written: {error.strerror}") from None
    if not claim.is_complete:
        # Level 3: the line that called `Result.certificate`.
        warnings.warn(f"{target}: the certificate is partial: {claim.message}", stacklevel=3)
    return target


def question_of(result: Result) -> tuple[Problem, Options]:
    """Return the question of a result exactly as it was solved, without its budgets.

    Raises
    ------
    InputError
        The result does not hold it: it was written before results did.
    NotSupportedError
        Tensions were given instead of lengths or limited, or data of the robot are ranges.
    """
    origin, asked = result.provenance, result.question
    if origin is None:
        raise InputError("result: the exact question is not in it")
    if asked.tensions_given is not None:
        raise NotSupportedError("certificates are for given lengths, this result is for given tensions")
    if asked.tension is not None:
        raise NotSupportedError("certificates are about poses with any tensions, this result is for limits")
    options = Options(
        ignore_slack=asked.ignore_slack,
        ignore_tension_sign=asked.ignore_tension_sign,
        method=Method(asked.method),
        precision=asked.precision,
        threads=result.statistics.threads,
    )
    problem = Problem(origin.robot, origin.lengths, origin.external_force, asked.taut)
    require_certifiable(problem)
    return problem, options
