"""Diagnosis of shapes: photographed tubes and assembled pairs, compared point by point along their arc length."""

from __future__ import annotations

from coast_cli.diagnosis.shapes.judge import diagnose_shapes

__all__ = ["diagnose_shapes"]
