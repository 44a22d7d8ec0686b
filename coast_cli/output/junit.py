"""JUnit XML of checks, as CI systems read it: a suite a configuration, a test case a limit, an error where none ran.

A row of ``coast validate`` is a case too: the configuration, or one mistake in it.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import groupby
from typing import IO
from xml.etree import ElementTree as ET

from coast_cli.output.answer import Answer, Row


def render(answer: Answer, stream: IO[str]) -> None:
    """Write the rows of ``coast check`` or ``coast validate`` as a JUnit report."""
    root = ET.Element("testsuites", _counts(answer.rows))
    for config, group in groupby(answer.rows, key=lambda row: row["config"]):
        rows = list(group)
        suite = ET.SubElement(root, "testsuite", {"name": str(config), **_counts(rows), "skipped": "0"})
        for row in rows:
            broken = fault(row)
            name = f"{row['pair']} {row['check']} {row['bound']}" if "check" in row and not broken else "configuration"
            case = ET.SubElement(suite, "testcase", {"classname": str(config), "name": name, "time": "0"})
            if broken:
                ET.SubElement(case, "error", {"message": reason_of(row), "type": "configuration"}).text = reason_of(row)
            elif failed(row):
                failure = ET.SubElement(case, "failure", {"message": reason_of(row), "type": "limit"})
                failure.text = f"{row['config']}:{row['line']}: {reason_of(row)}"
    ET.indent(root)
    stream.write('<?xml version="1.0" encoding="UTF-8"?>\n')
    stream.write(ET.tostring(root, encoding="unicode") + "\n")


def fault(row: Row) -> str:
    """Return what is wrong with the configuration itself, or an empty string."""
    return str(row.get("error") or row.get("message") or "")


def failed(row: Row) -> bool:
    """Return whether a limit does not hold, or a configuration cannot be used."""
    return not row["passed" if "passed" in row else "valid"]


def reason_of(row: Row) -> str:
    """Return what a row says."""
    if fault(row):
        return fault(row)
    relation = "within" if row["passed"] else "past"
    return f"{row['pair']}: {row['check']} is {row['value']:.5g}, {relation} its {row['bound']} of {row['limit']:.5g}"


def _counts(rows: Sequence[Row]) -> dict[str, str]:
    errors = sum(bool(fault(row)) for row in rows)
    failures = sum(map(failed, rows)) - errors
    return {"tests": str(len(rows)), "failures": str(failures), "errors": str(errors), "time": "0"}
