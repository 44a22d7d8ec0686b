"""What is fuzzed: for each target the command lines that read the file, seeds, and mutations that keep its structure.

Only the standard library and what the project itself needs takes part, so that the kept cases replay in any test run.
"""

import io
import random
import re
import tomllib
import zlib
from collections.abc import Callable, Sequence
from contextlib import closing, redirect_stderr, redirect_stdout
from copy import deepcopy
from dataclasses import dataclass
from json import loads
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import tomli_w

from coast_cli.cli.app import refusal, run
from coast_cli.errors import CoastError

ROOT = Path(__file__).parents[2]
CONFIG = ROOT / "configs" / "tubes.toml"
RECORDING = ROOT / "examples" / "diagnose" / "recording.csv"
LONGEST_MESSAGE = 2000
VALUES = [
    0,
    1,
    -1,
    2,
    3,
    7,
    10**9,
    -(10**9),
    10**18,
    2**63,
    10**30,
    0.0,
    -0.0,
    1e-308,
    5e-324,
    1e308,
    -1e308,
    1e-9,
    1e9,
    0.2,
    0.25,
    0.3,
    0.314,
    0.36,
    0.4,
    0.4999999,
    0.5,
    1.0,
    5.0,
    100.0,
    1000.0,
    float("nan"),
    float("inf"),
    float("-inf"),
    True,
    False,
    "",
    "x",
    "none",
    "table",
    "chord",
    "sector",
    "OT4/MT1",
    "MT1",
    "OT4/",
    "/",
    "a/b/c",
    "é\u202e\x00\x1b[31m",
    "x" * 5000,
    "1",
    [],
    {},
    [[]],
    [0.3] * 188,
    [0.3] * 125,
    [1e308, -1e308],
    {"value": 1.0, "min": 0.5, "max": 2.0},
    {"value": 1.0},
    {"min": 0.1, "max": 0.2},
    {"min": 0.1, "max": 0.2, "step": 1e-6},
    {"a": {"b": {"c": 1}}},
]
CELLS = [
    "",
    " ",
    "0",
    "-0",
    "1",
    "-1",
    "1e308",
    "-1e308",
    "5e-324",
    "1e-320",
    "1e999",
    "nan",
    "inf",
    "NaN",
    "-inf",
    "1_0",
    "0x1",
    "1,5",
    '"',
    '""',
    '"1"',
    "é",
    "\x00",
    "9" * 400,
    "x" * 200,
    "1e-9",
    "1e9",
    "up",
    "down",
    "OT4",
    "MT1",
    "OT4/MT1",
    "OT1",
    "/",
    "run",
]
HEADERS = [
    "s_mm",
    "arc_length_m",
    "kappa_per_mm",
    "kappa",
    "x_m",
    "run",
    "time_s",
    "outer",
    "middle",
    "tube",
    "natural",
    "bending_length_mm",
    "bending_length_um",
    "stroke_mm",
    "stroke_m",
    "tension_n",
    "tension_mn",
    "curvature_per_m",
    "curvature_per_mm",
    "bend_deg",
    "bend_rad",
    "notch_1_deg",
    "notch_2_deg",
    "notch_0_deg",
    "notch_" + "9" * 5000 + "_deg",
    "x_mm",
    "y_mm",
    "x_um",
    "frame",
    "stroke",
    "bend_furlong",
    "",
    '"',
    "é" * 50,
]


class Finding(AssertionError):
    """The program broke a promise that is not the absence of an exception."""


def attempt(words: Sequence[str]) -> int | None:
    """Run one command line; return its exit code, or None where it refused in one sentence. Anything else is raised."""
    out, err = io.StringIO(), io.StringIO()
    try:
        with redirect_stdout(out), redirect_stderr(err):
            code = run(list(words))
    except (CoastError, refusal()) as error:
        text = str(error)
        if any(not character.isprintable() for character in text):
            raise Finding(f"not one printable sentence: {text[:300]!r}") from error
        if len(text) > LONGEST_MESSAGE:
            raise Finding(f"a sentence of {len(text)} characters: {text[:300]!r}") from error
        if out.getvalue():
            raise Finding("refused, and yet something on stdout") from error
        return None
    if out.getvalue().startswith("{"):
        loads(out.getvalue(), parse_constant=_not_json)
    return code


def _not_json(text: str) -> None:
    raise Finding(f"{text} in JSON")


@dataclass(frozen=True)
class Target:
    """Command lines, with ``{file}`` where the fuzzed file goes; its name's suffix; seeds; and a mutation."""

    suffix: str
    commands: tuple[tuple[str, ...], ...]
    seeds: Callable[[], list[bytes]]
    mutate: Callable[[bytes, random.Random], bytes]

    def command(self, data: bytes) -> tuple[str, ...]:
        """The one command line that a fuzzing run tries on these bytes: the same each time."""
        return self.commands[zlib.crc32(data) % len(self.commands)]

    def try_one(self, path: Path) -> int | None:
        """Try that command line on a file."""
        return attempt([word.replace("{file}", str(path)) for word in self.command(path.read_bytes())])

    def replay(self, path: Path) -> None:
        """Try every command line on one file."""
        for command in self.commands:
            attempt([word.replace("{file}", str(path)) for word in command])


def _config_seeds() -> list[bytes]:
    text = CONFIG.read_text(encoding="utf-8")
    explored = (ROOT / "examples" / "explore.toml").read_text(encoding="utf-8")
    tolerances = (
        "\n[tolerances]\ncut_mm = { plus_minus = 0.01, distribution = 'uniform' }\nroll_deg = { plus_minus = 2.0 }\n"
    )
    ended = text.replace("count = 188 }", 'count = 188 }\nend_effect = "table"\nsection = "chord"')
    one = re.sub(r"(?s)\[outer\].*?\[middle\]", "[middle]", text).replace("OT4/MT1", "MT1")
    return [part.encode() for part in (text, explored, text + tolerances, ended, one)]


def _model_seeds() -> list[bytes]:
    from coast_cli.effects.catalogue import CATALOGUE
    from coast_cli.effects.corrections import correction_parameters

    text = CONFIG.read_text(encoding="utf-8")
    tables = {}
    for effect, parameters in correction_parameters(CATALOGUE).items():
        middle = {name: 0.5 * (low + high) for name, (low, high) in parameters.items()}
        tables[effect] = tomli_w.dumps({"corrections": {effect: middle}})
    tables["unnamed_1"] = (
        '[corrections.unnamed_1]\nstage = "structure"\nvariable = "curvature"\nmemory = "friction"\n'
        "setting = 1e-4\nlow = 0.0\nhigh = 60.0\nweights = [1.5, 0.2]\n"
    )
    single = [f"{text}\n{table}" for table in tables.values()]
    return [part.encode() for part in (text, *single, "\n".join([text, *tables.values()]))]


def mutate_toml(data: bytes, chance: random.Random) -> bytes:
    """Change, remove, add or move values of a TOML document; text that is none comes back as a damaged reference."""
    try:
        document = tomllib.loads(data.decode())
    except (ValueError, RecursionError):
        document = tomllib.loads(CONFIG.read_text(encoding="utf-8"))
    for _ in range(chance.choice((1, 1, 1, 2, 4))):
        places = list(_places(document))
        if not places:
            break
        holder, key = chance.choice(places)
        _change(holder, key, chance, [h[k] for h, k in places])
    try:
        return tomli_w.dumps(document).encode("utf-8", "surrogatepass")
    except (TypeError, ValueError, AttributeError, RecursionError):
        return data


def _places(node: object) -> list[tuple[dict | list, object]]:
    found = []
    if isinstance(node, dict | list):
        for key in node if isinstance(node, dict) else range(min(len(node), 12)):
            found += [(node, key), *_places(node[key])]
    return found


def _change(holder: dict | list, key: object, chance: random.Random, others: list) -> None:
    kind = chance.randrange(8)
    value = holder[key]
    if kind == 0 and isinstance(holder, dict):
        del holder[key]
    elif kind == 1 and isinstance(holder, dict):
        holder[chance.choice(("", "a.b", "é\n", "value", "min", "<number>", "[key]", "x" * 200, str(key) + "x"))] = (
            value
        )
    elif kind == 2:
        holder[key] = deepcopy(chance.choice(others))
    elif kind == 3 and isinstance(value, int | float) and not isinstance(value, bool):
        holder[key] = value * chance.choice((-1.0, 0.5, 0.9, 1.1, 2.0, 10.0, 1e3, 1e-3))
    elif kind == 4 and isinstance(value, list):
        value.extend(value[:1] * chance.choice((1, 3, 200)))
    else:
        holder[key] = deepcopy(chance.choice(VALUES))


def _recording_seeds() -> list[bytes]:
    lines = RECORDING.read_text(encoding="utf-8").splitlines()
    short = "\n".join([lines[0], *lines[1:60:4], *lines[120:160:5]]) + "\n"
    notches = "run,stroke_mm,bending_length_mm,notch_1_deg,notch_2_deg\n" + "".join(
        f"a,{0.6 + 0.2 * min(i, 20 - i):.2f},1.2,{0.1 * min(i, 20 - i):.2f},{0.09 * min(i, 20 - i):.3f}\n"
        for i in range(21)
    )
    tension = "tension_n,time_s,bend_deg,bending_length_mm,outer,middle\n" + "".join(
        f"{0.1 * min(i, 20 - i):.2f},{i},{1.7 * min(i, 20 - i):.2f},30,,MT1\n" for i in range(21)
    )
    shape = "run,tube,natural,x_mm,y_mm\n" + "".join(
        f"{way},OT4,{way},{x},{sign * 0.001 * x * x:.4f}\n"
        for way, sign in (("up", 1), ("down", -1))
        for x in range(0, 112, 8)
    )
    foreign = "stroke_mm;tension_n;curvature_per_m;bending_length_mm\n" + "".join(
        f"{0.5 * i:.1f};{0.1 * i:.1f};{2 * i:.1f};20\n".replace(".", ",") for i in range(9)
    )
    texts = (short, notches, tension, shape, foreign, short.replace(",", "\t"), re.sub(r"([^,\n]+)", r'"\1"', short))
    return [text.encode() for text in texts]


def mutate_csv(data: bytes, chance: random.Random) -> bytes:
    """Change cells, names, rows, columns, separators and line ends of a table."""
    text = data.decode("utf-8", "replace")
    separator = max(",;\t", key=text.partition("\n")[0].count)
    rows = [line.split(separator) for line in text.split("\n")]
    for _ in range(chance.choice((1, 1, 2, 5))):
        row = chance.choice(rows)
        at = chance.randrange(len(row))
        kind = chance.randrange(9)
        if kind == 0:
            rows[0][chance.randrange(len(rows[0]))] = chance.choice(HEADERS)
        elif kind == 1:
            rows[chance.randrange(len(rows))] = list(chance.choice(rows))
        elif kind == 2:
            extra = chance.choice(HEADERS)
            rows = [[*line, extra if line is rows[0] else line[-1]] for line in rows]
        elif kind == 3:
            rows = [line[:at] + line[at + 1 :] or [""] for line in rows]
        elif kind == 4:
            value = chance.choice(CELLS)
            rows = [rows[0], *([*line[:at], value, *line[at + 1 :]] for line in rows[1:])]
        elif kind == 5:
            rows = rows[: 1 + chance.randrange(len(rows))]
        else:
            row[at] = chance.choice(CELLS)
    separator = chance.choice((separator,) * 8 + (",", ";", "\t"))
    ending = chance.choice(("\n",) * 6 + ("\r\n", "\r"))
    return ending.join(separator.join(row) for row in rows).encode("utf-8", "replace")


def _path_seeds() -> list[bytes]:
    branch = (ROOT / "examples" / "path" / "branch.csv").read_text(encoding="utf-8")
    points = "x_mm,y_mm\n" + "".join(f"{2.0 * i},{0.002 * (2.0 * i) ** 2:.4f}\n" for i in range(20))
    metres = "kappa_per_m;arc_length_m;run\n0;0;a\n0;0,02;a\n30;0,03;a\n-30;0,04;a\n"
    return [text.encode() for text in (branch, points, metres)]


def _image_seeds() -> list[bytes]:
    from tests.rendered_tube import Scene, Tube

    tube = Tube(width=9.0, length=150.0, curvature=0.004, start=(20.0, 90.0))
    scenes = (
        Scene((120, 200), (tube,)),
        Scene((120, 200), (tube,), bright=True, light=200.0),
        Scene((120, 200), (tube,), glare=(90.0, 80.0, 14.0), streak=0.3),
        Scene((120, 200), (tube, Tube(width=8.0, length=120.0, curvature=-0.003, start=(25.0, 30.0)))),
        Scene(
            (90, 120),
            (Tube(width=14.0, length=90.0, curvature=0.0, start=(0.0, 45.0)),),
            noise=12.0,
            gradient=(0.4, 0.2),
        ),
    )
    return [_grey_map(scene.image()) for scene in scenes]


def _grey_map(levels: object) -> bytes:
    """A binary portable grey map: a picture whose bytes are its pixels."""
    import numpy as np

    pixels = np.clip(np.asarray(levels), 0, 255).astype(np.uint8)
    return b"P5 %d %d 255\n" % (pixels.shape[1], pixels.shape[0]) + pixels.tobytes()


def mutate_image(data: bytes, chance: random.Random) -> bytes:
    """Draw on, cut, turn, stretch and spoil a grey map; other bytes come back as a damaged file of another format."""
    import numpy as np

    match = re.match(rb"P5 (\d+) (\d+) 255\n", data)
    if match is None or int(match[1]) * int(match[2]) != len(data) - match.end():
        return data[: chance.randrange(len(data) + 1)]
    pixels = np.frombuffer(data, np.uint8, offset=match.end()).reshape(int(match[2]), int(match[1])).copy()
    noise = np.random.default_rng(chance.randrange(2**32))
    for _ in range(chance.choice((1, 1, 2, 4))):
        rows, columns = pixels.shape
        top, left = chance.randrange(rows), chance.randrange(columns)
        box = (slice(top, chance.randint(top, rows)), slice(left, chance.randint(left, columns)))
        pixels = chance.choice((_spoiled, _turned))(pixels, box, chance, noise)
    if chance.random() < 0.15:
        return _as_file(pixels, chance)
    return _grey_map(pixels)


def _spoiled(pixels, box, chance, noise):
    import numpy as np

    kind = chance.randrange(6)
    if kind == 0:
        return 255 - pixels
    if kind == 1:
        return np.clip(pixels + noise.normal(0, chance.choice((2, 20, 80)), pixels.shape), 0, 255).astype(np.uint8)
    if kind == 2:
        return np.where(pixels > chance.randrange(256), 255, 0).astype(np.uint8)
    if kind == 3 and chance.random() < 0.1:
        return np.full_like(pixels, chance.randrange(256))
    pixels = pixels.copy()
    pixels[box if kind < 5 else box[0]] = chance.choice((0, 30, 128, 220, 255))
    return pixels


def _turned(pixels, box, chance, _noise):
    import numpy as np

    kind = chance.randrange(5)
    if kind == 0:
        return np.rot90(pixels, chance.randrange(1, 4))
    if kind == 1 and pixels.size < 20_000:
        return np.repeat(pixels, chance.choice((2, 3)), axis=chance.randrange(2))
    if kind == 2:
        return np.roll(pixels, (box[0].start, box[1].start), (0, 1))
    if kind == 3:
        return pixels[:: chance.choice((1, 2, 3)), :: chance.choice((1, 2, 5))]
    return pixels[box] if min(pixels[box].shape) > 8 else np.fliplr(pixels)


def _as_file(pixels: object, chance: random.Random) -> bytes:
    from PIL import Image

    stream = io.BytesIO()
    picture = Image.fromarray(pixels)
    mode = chance.choice(("L", "RGB", "RGBA", "1", "P", "I;16", "F", "LA", "CMYK"))
    try:
        converted = picture.convert("I").convert(mode) if mode == "I;16" else picture.convert(mode)
        converted.save(stream, chance.choice(("PNG", "TIFF", "BMP", "JPEG", "GIF", "WEBP", "TGA", "PPM", "ICO")))
    except (OSError, ValueError, KeyError):
        return _grey_map(pixels)
    return stream.getvalue()


def _tube_seeds() -> list[bytes]:
    text = CONFIG.read_text(encoding="utf-8")
    explored = (ROOT / "examples" / "explore.toml").read_text(encoding="utf-8")
    table = "martensite_modulus_gpa = 25.0\nupper_plateau_mpa = 450.0\nlower_plateau_mpa = 180.0\ntemperature_c = 37.0"
    superelastic = f"{text}\n[materials.nitinol.superelastic]\n{table}\n"
    return [part.encode() for part in (text, explored, explored, superelastic)]


def _note_seeds() -> list[bytes]:
    """Return what unfinished runs left: without a block, with rows, and with arrays of several kinds."""
    import numpy as np

    states = ({}, {"front": np.arange(12.0).reshape(3, 4), "count": np.int64(3)}, {"names": np.array(["S4", "S1"])})
    found = []
    for state in states:
        with TemporaryDirectory() as place, closing(_stream(Path(place))) as stream:
            if state:
                stream.write({"outer": np.array(["=1+1", "OT4"]), "stroke_mm": np.array([0.5, 1.0])}, state)
            found.append((stream.part / "note").read_bytes() + SEAM + (stream.part / "rows.csv").read_bytes())
    return found


def _stream(folder: Path) -> Any:
    from coast_cli.output.stream import CsvStream

    return CsvStream(folder / "pairs.csv", "the same command", overwrite=False)


class NoteTarget(Target):
    """What an unfinished run left: its note and its rows, with a seam between; read as the same command would."""

    def try_one(self, path: Path) -> int | None:
        note, _, rows = path.read_bytes().partition(SEAM)
        with TemporaryDirectory() as place:
            folder = Path(place) / "pairs.csv.part"
            folder.mkdir(mode=0o700)
            (folder / "note").write_bytes(note)
            (folder / "rows.csv").write_bytes(rows)
            try:
                stream = _stream(Path(place))
            except CoastError:
                return None
            stream.close()
            return 0

    def replay(self, path: Path) -> None:
        self.try_one(path)


def _mutate_note(data: bytes, chance: random.Random) -> bytes:
    """Change numbers and names of the note's head, or bytes of any part."""
    head, newline, rest = data.partition(b"\n")
    if chance.random() < 0.5:
        at = chance.randrange(len(data) + 1)
        return data[:at] + bytes(chance.randrange(256) for _ in range(chance.choice((0, 1, 8)))) + data[at + 1 :]
    words = re.findall(rb'[0-9]+|"[^"]*"|.', head)
    if words:
        texts = (b"0", b"-1", b"1e999", b"9" * 30, b'"x"', b"null", b"[]", b"{}", b'"|O"', b'"<f8"', b"[1073741824]")
        words[chance.randrange(len(words))] = chance.choice((*texts, b"", chance.choice(words)))
    return b"".join(words) + newline + rest


SEAM = b"\0-- rows --\0"
JSON = ("--format", "json")
SMALL = ("--set", "explore.tubes=6", "--set", "explore.refinements=1")
TARGETS = {
    "config": Target(
        ".toml",
        (
            ("rank-pairs", "{file}", *JSON),
            ("rank-pairs", "{file}", "--assembly", "coupled", "--section", "chord", *JSON),
            ("stroke", "{file}", "--kappa", "0,20,400", "--x2", "5,30", *JSON),
            ("stroke", "{file}", "--stroke", "0,2,30", "--x2", "5,30", *JSON),
            ("check", "{file}", *JSON),
            ("check", "{file}", "--format", "junit"),
            ("beam", "{file}", "--tube", "OT4", "--points", "5", *JSON),
            ("validate", "{file}"),
            ("tolerance", "{file}", "--samples", "16", *JSON),
        ),
        _config_seeds,
        mutate_toml,
    ),
    "recording": Target(
        ".csv",
        (
            ("recordings", "{file}", *JSON),
            ("recordings", "{file}", "--config", str(CONFIG), "--x2", "20", *JSON),
            ("recordings", "{file}", "--pair", "OT4/MT1", "--columns", "stroke_mm=frame,bend_deg=x_mm", *JSON),
            ("compare", str(CONFIG), "{file}", *JSON),
            ("compare", str(CONFIG), "{file}", "--pair", "MT1", "--x2", "20", *JSON),
            ("calibrate", str(CONFIG), "{file}", *JSON),
        ),
        _recording_seeds,
        mutate_csv,
    ),
    "image": Target(
        ".png",
        (
            ("trace", "{file}", "--scale", "0.05", *JSON),
            ("trace", "{file}", "--scale", "0.05", "--clamp", "30,60", "--tube", "OT4", "--points", "5", *JSON),
            ("trace", "{file}", "--scale", "1e-300", "--kind", "joint", *JSON),
        ),
        _image_seeds,
        mutate_image,
    ),
    "model": Target(
        ".toml",
        (
            ("compare", str(CONFIG), str(RECORDING), "--model", "{file}", *JSON),
            ("stroke", "{file}", "--kappa", "0,20,400", "--x2", "5,30", *JSON),
            ("stroke", "{file}", "--stroke", "0,2,30", "--x2", "5,30", *JSON),
            ("check", "{file}", *JSON),
        ),
        _model_seeds,
        mutate_toml,
    ),
    "path": Target(
        ".csv",
        (
            ("path", str(CONFIG), "--path", "{file}", *JSON),
            ("path", str(CONFIG), "--path", "{file}", "--back", "--points", "7", "--within", "0.1", *JSON),
        ),
        _path_seeds,
        mutate_csv,
    ),
    "tubes": Target(
        ".toml",
        (
            ("pattern", "{file}", "--tube", "OT4", "--kerf", "0.02", *JSON),
            ("sensitivity", "{file}", *JSON),
            ("snap", "{file}", *JSON),
            ("beam", "{file}", "--tube", "OT4", "--points", "5", *JSON),
            ("rank-pairs", "{file}", *JSON),
            ("explore", "{file}", *SMALL, *JSON),
            ("design", "{file}", "--target", "rigidity_ratio_series=2.5", *JSON),
        ),
        _tube_seeds,
        mutate_toml,
    ),
    "note": NoteTarget(".note", (("explore", "--all"),), _note_seeds, _mutate_note),
    "protocol": Target(
        ".csv",
        (("plan", str(CONFIG), "--protocol", "{file}", "--x2", "20", *JSON),),
        _recording_seeds,
        mutate_csv,
    ),
}
