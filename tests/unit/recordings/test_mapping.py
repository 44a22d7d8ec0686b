"""Other people's files: every thing that a mapping can say, and every way in which it can be wrong."""

import numpy as np
import pytest

from coast_cli.errors import BadInput, UsageError
from coast_cli.recordings.mapped import part_of
from coast_cli.recordings.mapping import load_mapping, mapping_of
from coast_cli.recordings.read import read_recordings
from coast_cli.spec.load import REFERENCE, load_config

FOREIGN = "t_s,motor_deg,jaw_deg,wrist,trial,torque_n_m\n" + "".join(
    f"{0.1 * i:.1f},{10 * i},{-2 * i},{i // 4},{i // 2 % 2},{0.01 * i}\n" for i in range(8)
)
PLAIN = '[columns]\nstroke_mm = { from = "motor_deg", scale = 0.1, offset = 3.0 }\nbend_deg = "jaw_deg"\n'


@pytest.fixture
def folder(tmp_path):
    class Folder:
        def __call__(self, mapping, text=FOREIGN, name="fixed_0.1hz_load40.csv"):
            path, columns = tmp_path / name, tmp_path / "map.toml"
            path.write_bytes(text if isinstance(text, bytes) else text.encode())
            columns.write_text(mapping, encoding="utf-8")
            return read_recordings([path], columns=load_mapping(columns))

        def refused(self, mapping, text=FOREIGN):
            with pytest.raises(BadInput) as caught:
                self(mapping, text)
            assert "\n" not in str(caught.value)
            return caught.value

    return Folder()


def test_scale_offset_and_sign(folder):
    read = folder(PLAIN.replace('"jaw_deg"', '{ from = "jaw_deg", scale = -1 }'))
    (run,) = read.joint.runs
    assert run.stroke == pytest.approx([3e-3 + 1e-3 * i for i in range(8)], rel=1e-12)
    assert run.response[:, 0] == pytest.approx(np.radians([2.0 * i for i in range(8)]), rel=1e-12)
    assert (run.name, run.middle, run.pair) == ("fixed_0.1hz_load40", "", "")
    assert run.time is None
    assert np.isnan(run.bending_length).all()
    assert read.notes == ("not named by the mapping, and not used: t_s, wrist, trial, torque_n_m.",)


def test_what_is_not_used_is_said_once_for_all_files(tmp_path):
    paths = [tmp_path / f"{name}.csv" for name in "ab"]
    for path in paths:
        path.write_text(FOREIGN)
    (tmp_path / "map.toml").write_text(PLAIN)
    notes = read_recordings(paths, columns=load_mapping(tmp_path / "map.toml")).notes
    assert sum("not used" in note for note in notes) == 1


def test_a_unit_nobody_knows_does_not_matter_where_the_column_is_not_used(folder, tmp_path):
    text = FOREIGN.replace("torque_n_m", "stroke_furlongs")
    assert folder(PLAIN, text).joint
    path = tmp_path / "own.csv"
    path.write_text("stroke_mm,bend_deg,tension_kg,time_min\n1,2,3,4\n2,3,4,5\n")
    read = read_recordings([path])
    assert read.joint.runs[0].tension is None
    assert sum("is not known and not used" in note for note in read.notes) == 2


@pytest.mark.parametrize(
    ("said", "names"),
    [
        ('["wrist", "trial"]', ["0_0", "0_1", "1_0", "1_1"]),
        ('"wrist"', ["0", "1"]),
        ('{ constant = "all" }', ["all"]),
        ('{ file = "{}_load*" }', ["fixed_0.1hz"]),
        ('{ file = "*load{}" }', ["40"]),
    ],
)
def test_runs(said, names, folder):
    assert [run.name for run in folder(PLAIN + f"run = {said}\n").joint.runs] == names


@pytest.mark.parametrize(
    ("said", "attribute", "value"),
    [
        ('load_n_m = "torque_n_m"', "load_moment", [0.01 * i for i in range(8)]),
        ("load_n = { constant = 5 }", "load", [5.0] * 8),
        ('load_n = { file = "*_load{}", scale = 0.1, offset = 1 }', "load", [5.0] * 8),
        ('time_s = "t_s"', "time", [0.1 * i for i in range(8)]),
        ('tension_n = { from = "trial" }', "tension", [0, 0, 1, 1, 0, 0, 1, 1]),
        ("bending_length_mm = { constant = 20 }", "bending_length", [0.02] * 8),
        ('middle = { constant = "MT1" }', "middle", "MT1"),
    ],
)
def test_loads_constants_and_the_rest(said, attribute, value, folder):
    (run,) = folder(f"{PLAIN}{said}\n").joint.runs
    assert getattr(run, attribute) == (value if isinstance(value, str) else pytest.approx(value))


@pytest.mark.parametrize(("ours", "kind", "factor"), [("position_mm", "position", 1e-3), ("force_n", "force", 1.0)])
def test_responses_of_other_devices(ours, kind, factor, folder):
    (run,) = folder(
        PLAIN.replace("bend_deg = ", f"{ours} = ").replace('"jaw_deg"', '{ from = "jaw_deg", scale = 1 }')
    ).joint.runs
    assert run.kind == kind
    assert run.response[:, 0] == pytest.approx([-2.0 * i * factor for i in range(8)])


def test_a_position_is_no_response_of_notched_tubes(tmp_path):
    path = tmp_path / "a.csv"
    path.write_text("stroke_mm,position_mm\n1,2\n2,3\n")
    with pytest.raises(BadInput, match="no response of a notched joint"):
        read_recordings([path], load_config(REFERENCE), bending_length_mm=20)


def test_a_load_said_once_stands_for_the_whole_run(tmp_path):
    path = tmp_path / "a.csv"
    path.write_text("run,stroke_mm,bend_deg,load_n\na,1,2,\na,2,3,4.5\nb,1,2,1\nb,2,3,2\n")
    first, second = read_recordings([path]).joint.runs
    assert (first.load.tolist(), second.load.tolist()) == ([4.5, 4.5], [1.0, 2.0])
    path.write_text("stroke_mm,bend_deg,load_n\n1,2,\n2,3,4.5\n3,4,5\n")
    with pytest.raises(BadInput, match="2:3: load_n: an empty cell"):
        read_recordings([path])


LAYOUTS = {
    "skipped": ("skip = 2", "Lab 7\n\n" + FOREIGN),
    "comments": ('comment = "%"', "% made on monday\n" + FOREIGN.replace("\n0.3", "\n% a pause\n0.3")),
    "units": ("units_row = true", FOREIGN.replace("\n0.0", "\ns,deg,deg,-,-,N m\n0.0")),
    "no header": (
        'names = ["t_s", "motor_deg", "jaw_deg", "wrist", "trial", "torque_n_m"]',
        FOREIGN.partition("\n")[2],
    ),
    "tabs": ("", FOREIGN.replace(",", "\t")),
    "spaces": ("", "  " + FOREIGN.replace(",", "   ").replace("\n0.", "\n  0.")),
    "semicolons": ("", FOREIGN.replace(",", ";").replace(".", ",")),
    "tabs and decimal commas": ("", FOREIGN.replace(",", "\t").replace(".", ",")),
    "carriage returns": ("skip = 1", "x\n" + FOREIGN.replace("\n", "\r\n")),
    "all at once": (
        'skip = 1\ncomment = "#"\nunits_row = true',
        "Lab 7\n# x\n" + FOREIGN.replace("\n0.0", "\ns d d - - N\n0.0").replace(",", " "),
    ),
}


@pytest.mark.parametrize("layout", LAYOUTS)
def test_layouts(layout, folder):
    rows, text = LAYOUTS[layout]
    (run,) = folder(f"{PLAIN}[rows]\n{rows}\n", text).joint.runs
    assert run.stroke == pytest.approx([3e-3 + 1e-3 * i for i in range(8)])
    lines = text.replace("\r\n", "\n").split("\n")
    cells = [line.replace(",", ".") if "decimal" in layout or layout == "semicolons" else line for line in lines]
    for index, line in enumerate(run.line):
        assert cells[line - 1].split()[0].startswith(f"{0.1 * index:.1f}")


@pytest.mark.parametrize(
    ("where", "kept"),
    [
        ("t_s = { min = 0.25, max = 0.55 }", [3, 4, 5]),
        ("wrist = 1", [4, 5, 6, 7]),
        ('wrist = "1"', [4, 5, 6, 7]),
        ("motor_deg = [10, 30]", [1, 3]),
        ("wrist = 0\ntrial = 1", [2, 3]),
    ],
)
def test_where(where, kept, folder):
    read = folder(f"{PLAIN}[rows.where]\n{where}\n")
    assert read.joint.runs[0].line.tolist() == [2 + i for i in kept]
    assert f"{8 - len(kept)} of 8 rows are left out by where" in read.notes[0]


@pytest.mark.parametrize(
    ("mapping", "said"),
    [
        ("", "nothing is mapped"),
        ("[columns", "not valid TOML"),
        ("[columns]\nstroke = 'motor_deg'", "no column of ours"),
        ("[columns]\nstroke_mn = 'motor_deg'", "Did you mean"),
        ("[columns]\nstroke_mm = 'motor_deg'", "is an angle (deg), and stroke_mm is a length (mm)"),
        ("[columns]\nbend_rad = 'jaw_deg'", "Write bend_deg = jaw_deg, or scale = 0.0174533"),
        ("[columns]\nbend_deg = 'jaw_dge'", "Did you mean jaw_deg?"),
        ("[columns]\nbend_deg = 3", "constant = 3"),
        ("[columns]\nbend_deg = { from = 'jaw_deg', constant = 2 }", "from several"),
        ("[columns]\nbend_deg = { form = 'jaw_deg' }", "Did you mean from?"),
        ("[columns]\nbend_deg = { from = 'jaw_deg', scale = 0 }", "a scale of zero"),
        ("[columns]\nbend_deg = { from = 'jaw_deg', scale = nan }", "not such a number"),
        ("[columns]\nbend_deg = ['jaw_deg', 'wrist']", "made of several columns"),
        ("[columns]\nrun = { from = 'wrist', scale = 2 }", "a text has no scale"),
        ("[columns]\nbend_deg = { constant = 'x' }", "not a number"),
        ("[columns]\nrun = { file = 'fixed_*' }", "{} once"),
        ("[columns]\nrun = { file = 'free_{}' }", "the file's name is another"),
        ("[columns]\nload_n = { file = '{}_load*' }", "is no number"),
        ("[rows]\nskip = 1", "nothing is mapped"),
        (PLAIN + "[rows]\nskip = -1", "not a number of lines"),
        (PLAIN + "[rows]\nskip = true", "not a number of lines"),
        (PLAIN + "[rows]\nskip = 900", "empty"),
        (PLAIN + "[rows]\ncomment = ' '", "an empty mark"),
        (PLAIN + "[rows]\nnames = ['a', 'a']", "a name stands twice"),
        (PLAIN + "[rows]\nnames = ['a', 'b']", "a row of another length"),
        (PLAIN + "[rows]\nunits_row = 1", "neither true nor false"),
        (PLAIN + "[rows]\nwhere = { t_s = { min = 2, max = 1 } }", "keeps no row"),
        (PLAIN + "[rows]\nwhere = { t_s = { min = 99 } }", "no row is left"),
        (PLAIN + "[rows]\nwhere = { time = { min = 2 } }", "does not have"),
        (PLAIN + "[rows]\nwhere = { t_s = [] }", "keeps no row"),
        (PLAIN + "[rows]\nfoo = 1", "there is no such key"),
        (PLAIN + "[other]\nfoo = 1", "there is no such key"),
        ("columns = 3", "not a table"),
    ],
)
def test_what_is_wrong_is_said_with_its_place(mapping, said, folder):
    error = folder.refused(mapping)
    assert said in str(error)
    assert error.exit_code == 3
    assert error.file is not None


def test_a_bad_cell_is_said_with_the_files_own_name_and_place(folder):
    error = folder.refused(PLAIN, FOREIGN.replace("\n0.3,30,", "\n0.3,thirty,"))
    assert (error.line, error.column, error.key) == (5, 2, "motor_deg")


def test_a_missing_column_is_refused_beside_one_of_our_own_name(tmp_path):
    path = tmp_path / "a.csv"
    path.write_text("stroke_mm,bend_deg\n1,2\n2,3\n")
    with pytest.raises(BadInput, match=r"a column that the file does not have.*Did you mean stroke_mm\?"):
        read_recordings([path], columns=mapping_of("stroke_mm=stroke_mn"))


@pytest.mark.parametrize("text", ["stroke_mm", "stroke_mm=", "=X", "a=b,a=c", "map.csv", "none"])
def test_what_is_no_mapping_at_all(text):
    with pytest.raises(UsageError, match="OURS=THEIRS"):
        mapping_of(text)


def test_a_mapping_file_that_is_not_there():
    with pytest.raises(BadInput, match="no such file"):
        mapping_of("none.toml")


@pytest.mark.parametrize(
    ("name", "pattern", "part"),
    [
        ("roll-90_load20", "roll{}_load*", "-90"),
        ("roll-90_load20", "*load{}", "20"),
        ("roll-90_load20", "{}", "roll-90_load20"),
        ("roll-90_load20", "rol{}l*", None),
        ("aXbXc", "*X{}X*", "b"),
        ("abc", "abc{}", None),
        ("ab", "ab*{}ba", None),
        ("abc", "x{}", None),
    ],
)
def test_part_of_a_name(name, pattern, part):
    assert part_of(name, pattern) == part


def test_every_shared_set_comes_in_by_at_most_12_lines(shared, tmp_path):
    mappings = {
        "davinci_tool": """[columns]
time_s = "time_s"
stroke_mm = { from = "drive_angle_deg", scale = 0.1 }
bend_deg = { from = "jaw_angle_deg", scale = -1 }
load_n_m = "jaw_torque_n_m"
""",
        "so101_servo": """[columns]
time_s = "time_s"
stroke_mm = { from = "wrist_roll_command_rad", scale = 10 }
bend_rad = "wrist_roll_position_rad"
load_n_m = "wrist_roll_torque_raw_n_m"
[rows]
where = { time_s = { min = 2.0 } }
""",
        "nitinol_loop": '[columns]\ntime_s = "time_s"\nstroke_mm = "extension_mm"\nforce_n = "load_n"\n',
    }
    for name, text in mappings.items():
        path = tmp_path / f"{name}.toml"
        path.write_text(text)
        files = sorted((shared / name).glob("*.csv"))
        runs = read_recordings(files, columns=load_mapping(path)).joint.runs
        assert len(runs) == len(files)
        assert text.count("\n") <= 12
