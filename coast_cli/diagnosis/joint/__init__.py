"""Diagnosis of a joint: bend over stroke or tension, run by run."""

from __future__ import annotations

from coast_cli.diagnosis.joint.judge import diagnose_joint

__all__ = ["diagnose_joint"]
