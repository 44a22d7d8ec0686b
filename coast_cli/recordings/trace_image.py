"""Photographs as arrays of grey levels, and the errors of frames that show no tube to trace.

Pixel coordinates everywhere in the tracing: x is the column and y the row, the centre of the first pixel is (0, 0), and
rows count downwards.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from coast_cli.errors import BadInput, UsageError

if TYPE_CHECKING:
    from numpy.typing import NDArray
    from PIL.Image import Image

LARGEST = 25_000_000  # pixels; tracing takes up to forty bytes for each


class BadFrame(BadInput):
    """A frame without exactly one whole tube: the word for its row's ``flag``, and the sentence for the user."""

    def __init__(self, flag: str, message: str, *, file: str | Path | None = None, hint: str | None = None) -> None:
        self.flag = flag
        super().__init__(message, file=file, hint=hint)

    def of_file(self, file: str | Path) -> BadFrame:
        """Return the same error with the name of its image."""
        return BadFrame(self.flag, self.message, file=file, hint=self.hint)


def require_vision() -> None:
    """Raise `UsageError` naming the extra to install when scikit-image is not there."""
    from importlib.util import find_spec

    if find_spec("skimage") is None or find_spec("PIL") is None:
        message = "Tracing photographs needs scikit-image: pip install 'coast-cli[vision]'."
        raise UsageError(message)


def read_grey(path: Path) -> NDArray[np.float32]:
    """Return the grey levels of one image, of shape (rows, columns), turned upright as its EXIF tag says.

    Transparent pixels are laid on white. Levels are those of the file: 0 to 255, or 0 to 65535 of a 16-bit image.

    Raises:
        BadInput: the file is missing, no image, several frames in one, or larger than `LARGEST`.
    """
    import warnings

    from PIL import Image

    if path.is_dir():
        raise BadInput("is a folder", file=path, allowed="an image file")
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", Image.DecompressionBombWarning)  # the bound below is ours
            with Image.open(path) as picture:
                _check_size(picture, path)
                levels = _grey(picture)
    except FileNotFoundError as error:
        raise BadInput("there is no such image", file=path) from error
    except BadInput:
        raise
    except Exception as error:  # a damaged file makes a decoder raise anything
        known = f"PNG, TIFF, JPEG or another file that Pillow reads, at most {LARGEST // 10**6} megapixels"
        raise BadInput("cannot be read as an image", file=path, allowed=known) from error
    if not np.isfinite(levels).all():
        raise BadInput("some pixels are not finite numbers", file=path)
    return levels


def _check_size(picture: Image, path: Path) -> None:
    columns, rows = picture.size
    size = f"{columns} x {rows} pixels"
    if columns * rows > LARGEST:
        raise BadInput(
            "the image is too large", file=path, found=size, allowed=f"{LARGEST // 10**6} megapixels", hint="Crop it."
        )
    if min(columns, rows) < 32:
        raise BadInput("the image is too small to show a tube", file=path, found=size, allowed="32 x 32 or more")
    frames = getattr(picture, "n_frames", 1)
    if frames > 1:
        raise BadInput("holds several frames", file=path, found=frames, allowed="one", hint="Save one image a frame.")


def _grey(picture: Image) -> NDArray[np.float32]:
    from PIL import Image, ImageOps

    upright = ImageOps.exif_transpose(picture)
    if upright.mode in {"I;16", "I;16B", "I;16L", "I", "F"}:
        return np.asarray(upright, dtype=np.float32)
    if "A" in upright.getbands() or "transparency" in upright.info:
        over = upright.convert("RGBA")
        upright = Image.alpha_composite(Image.new("RGBA", over.size, "white"), over)
    return np.asarray(upright.convert("L"), dtype=np.float32)
