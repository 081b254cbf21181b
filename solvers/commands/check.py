"""``cdpr-solve check``: the independent checker of certificates."""

from __future__ import annotations

import click

from cdpr_interval.errors import NotSupportedError


@click.command("check", short_help="Check a certificate (not supported yet).")
@click.argument("certificate")
def command(certificate: str) -> int:
    """Check CERTIFICATE without the solvers. Not supported yet."""
    raise NotSupportedError(f"check: certificates are not supported yet ({certificate})")
