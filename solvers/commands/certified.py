"""``fk --certificate``: the proof is written, then checked, and both say what it is worth."""

from __future__ import annotations

import sys
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import click

from cdpr_interval.engine.budget import Stop
from cdpr_interval.text.literal import printable

if TYPE_CHECKING:
    from solvers.answers.result import Result
    from solvers.cli import Ending, ExitCode
    from solvers.commands.target import JsonTarget
    from solvers.proofs.check import Proof
    from solvers.proofs.claimed import Claimed
    from solvers.questions.problem import Options, Problem
    from solvers.shell.interrupt import Signals


@dataclass(frozen=True)
class Certified:
    """A certificate that was written, and what is known of it."""

    claim: Claimed
    stop: Stop | None
    """What ended the writing."""
    proof: Proof | None = None
    """What the checker says; None where it was not asked, or not let finish."""
    interrupted: str = ""
    """How far the check was when it was interrupted."""

    def line(self, file: str) -> str:
        """Return what the file claims, and what the checker says of it."""
        if self.proof is not None and self.proof.is_refused:
            return f"{file}: {self.proof}; this is a defect of the program, please report it with the file"
        line = f"{file}: {'complete' if self.claim.is_complete else 'partial'}: {self.claim.message}"
        if not self.claim.is_complete and self.stop is Stop.TIME_LIMIT:
            line += "; the time limit ended the writing"
        if self.interrupted:
            return f"{line}; not checked: {self.interrupted}"
        if self.proof is None:
            return line
        conclusion = self.proof.conclusion
        return f"{line}; {'checked' if self.is_checked else 'not checked'}: {conclusion}"

    @property
    def is_checked(self) -> bool:
        """The checker has come to its end."""
        return self.proof is not None and self.proof.conclusion is self.claim.conclusion

    def code(self, answered: ExitCode) -> ExitCode:
        """Return how a run with this answer ends: it is complete only when the certificate is, too."""
        from solvers.cli import ExitCode

        if self.proof is not None and self.proof.is_refused:
            return ExitCode.NOT_PROVED
        if answered == ExitCode.INTERRUPTED or self.stop is Stop.INTERRUPTED or self.interrupted:
            return ExitCode.INTERRUPTED
        is_open = not self.claim.is_complete or (self.proof is not None and not self.is_checked)
        return ExitCode.INCOMPLETE if is_open else answered


def certify(
    problem: Problem,
    options: Options,
    result: Result,
    target: JsonTarget,
    signals: Signals,
    *,
    quiet: bool,
    checks: bool,
) -> Certified:
    """Write a certificate with what is left of the run's budget, and check it with what is left then.

    Interrupts end both as they do a search; what is written stays.
    """
    from solvers.commands.progress import shown
    from solvers.proofs.document import certificate_of

    # What was found can be read while the certificate is made.
    sys.stdout.flush()
    assert options.record is not None
    if signals.release():
        options.record.budget.interrupt()
    with shown("certificate", quiet) as display:
        content, claim = certificate_of(problem, replace(options, progress=display), result)
    signals.hold()
    target.write_bytes(content)
    stop = Stop.INTERRUPTED if options.record.is_interrupted else options.record.budget.stop()
    found = Certified(claim, stop)
    if not checks or stop is Stop.INTERRUPTED:
        return found
    if signals.release():
        return replace(found, interrupted="interrupted")
    try:
        return replace(found, proof=_checked(problem, options, result, content, quiet))
    except KeyboardInterrupt as interrupt:
        return replace(found, interrupted=": ".join(("interrupted", *interrupt.args)))
    finally:
        signals.hold()


def _checked(problem: Problem, options: Options, result: Result, content: bytes, quiet: bool) -> Proof:
    """Return what the checker says, in the time that is left and a moment more."""
    from solvers.commands.progress import shown
    from solvers.proofs.allowance import GRACE
    from solvers.proofs.check import proof_of

    assert options.record is not None
    left = options.record.budget.seconds_left()
    with shown("check", quiet) as display:
        return proof_of(
            problem.robot,
            result,
            content,
            None if left is None else max(left, GRACE),
            None if display is None else display.cells,
            options.threads,
        )


def ended(ending: Ending, found: Certified, file: str, quiet: bool) -> Ending:
    """Return how a run ends whose certificate is written; what is not its ending goes to standard error."""
    from solvers.cli import Ending, ExitCode

    line = found.line(printable(file))
    if not quiet:
        line = "\n".join([line, *found.claim.reasons])
    answered = ExitCode(ending)
    code = found.code(answered)
    if code != answered:
        return Ending(code, f"interrupted; {line}" if code == ExitCode.INTERRUPTED else line)
    if code or not quiet:
        # The answer is one thing, its certificate another: two lines.
        click.echo(line, err=True)
    return ending
