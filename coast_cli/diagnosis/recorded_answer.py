"""A diagnosis beside what it was made from, so that its model can be used: as text, and asked what it predicts."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from typing import TYPE_CHECKING

import numpy as np

from coast_cli.diagnosis.answer import Diagnosis
from coast_cli.recordings.model import Recordings
from coast_cli.rows import Drawn
from coast_cli.spec.config import Config

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from coast_cli.recordings.arrays import RecordingSource

    Floats = NDArray[np.float64]


@dataclass(frozen=True, repr=False)
class RecordedDiagnosis(Diagnosis, Drawn):
    """A diagnosis with the configuration and the recordings it was made from; units as of ``Diagnosis``.

    Attributes:
        config: as it was diagnosed: as given, or corrected by what shapes taught. recordings: as read.
    """

    config: Config = field(kw_only=True, compare=False)
    recordings: Recordings = field(kw_only=True, compare=False)

    @classmethod
    def of(cls, found: Diagnosis, config: Config, recordings: Recordings) -> RecordedDiagnosis:
        """Return a diagnosis beside what it was made from."""
        answers = {one.name: getattr(found, one.name) for one in fields(Diagnosis)}
        return cls(**answers, config=found.config_used(config), recordings=recordings)

    def model(self) -> Config:
        """Return the corrected model: the configuration with refitted numbers and ``[corrections]``.

        Raises:
            BadInput: a fitted number lies outside what a configuration may hold.
        """
        from coast_cli.spec.load import load_config_text

        return load_config_text(self.model_text(), "<model>")

    def model_text(self) -> str:
        """Return the corrected model as ``coast diagnose`` saves it, the comments of the file kept."""
        from coast_cli.diagnosis.model_file import model_text

        return model_text(self.config, self, self.recordings)

    def predict(self, drive: Recordings | RecordingSource) -> Mapping[str, Floats]:
        """Return what the corrected model predicts, by the name of each run.

        Args:
            drive: recordings as read; or a file, arrays or a DataFrame, in which the response may be left out, e.g.
                ``{"stroke_mm": [0.5, 1.0, 2.0], "bending_length_mm": 30.0}``.

        Returns:
            Of a joint's run the response (n, k): curvature in 1/m, or bend in rad; of a shape x and y in m, (2, n).

        Raises:
            BadInput: the drive cannot be read, or does not go with the tubes.
        """
        from coast_cli.diagnosis.compare import compare
        from coast_cli.recordings.model import Recording
        from coast_cli.recordings.read import read_protocol

        model = self.model()
        if not isinstance(drive, Recordings):
            runs, _ = read_protocol(drive, model)
            drive = Recordings(joint=Recording("joint", runs))
        found = compare(model, drive)
        shapes = {one.run.name: np.stack((one.x, one.y)) for one in found.shape}
        return {one.run.name: one.predicted for one in found.joint} | shapes
