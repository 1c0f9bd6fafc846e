"""The verb `gecos doctor`."""

from __future__ import annotations

import sys
from dataclasses import asdict

import click

from gecos.cli.exit_codes import ExitCode
from gecos.cli.options import json_option, print_json


@click.command()
@json_option
def doctor(as_json: bool) -> None:
    """Finds the reasons why programs cannot reach each other, and says how to correct them.

    Ends with 0 if nothing must be corrected, else with 1. A warning matters only for some uses.
    """
    from gecos.cli.doctor.examination import examine
    from gecos.cli.doctor.finding import Finding, Level
    from gecos.cli.report import printable

    def line(of: Finding) -> str:
        place = f" ({of.where})" if of.where else ""
        mend = f"\n         mend: {of.mend}" if of.mend else ""
        return f"{of.level:<8} {of.check}: {of.what}{place}{mend}"

    findings = examine()
    sick = any(finding.level is Level.ERROR for finding in findings)
    if as_json:
        print_json({"healthy": not sick, "findings": [asdict(each) for each in findings]})
    else:
        for finding in findings:
            print(printable(line(finding)))
    if sick:
        sys.exit(ExitCode.ENVIRONMENT)
