"""Truth is sealed before the answers, and nothing beside the recordings tells it."""

import csv
import io

import numpy as np
import pytest

from examples.concealed.case import make_case
from examples.concealed.seal import SEALED, BrokenSealError, build, key_of, open_seal, unseal, write

SEEDS = range(9000, 9064)


@pytest.fixture(scope="module")
def cases():
    return [make_case(seed) for seed in SEEDS]


JOBS = [("joint", seed, None, None) for seed in range(4)]


def make(out, jobs=JOBS):
    return write(out, map(build, jobs), key_of(jobs))


def test_the_same_seed_gives_the_same_bytes(tmp_path):
    first = make(tmp_path / "a")
    assert first == make(tmp_path / "b")
    for path in (tmp_path / "a").rglob("*"):
        if path.is_file() and path.name != SEALED:
            assert path.read_bytes() == (tmp_path / "b" / path.relative_to(tmp_path / "a")).read_bytes()


def answer(out, name, words="{}"):
    (out / "answers").mkdir(exist_ok=True)
    (out / "answers" / f"{name}.json").write_text(words)


def test_nothing_beside_the_cases_can_be_read_for_the_truth_before_the_answers_are_digested(tmp_path, capsys):
    digest = make(tmp_path)
    everything = b"".join(path.read_bytes() for path in tmp_path.rglob("*") if path.is_file())
    assert b'"level"' not in everything
    assert b'"effects"' not in everything
    with pytest.raises(BrokenSealError, match="is not there"):
        unseal(tmp_path, digest)
    answer(tmp_path, "first")
    open_seal(tmp_path, key_of(JOBS))
    assert "1 answers and models, SHA-256 " in capsys.readouterr().err
    assert len(unseal(tmp_path, digest)) == len(JOBS)


def test_other_seeds_do_not_open_the_seal(tmp_path):
    make(tmp_path)
    open_seal(tmp_path, key_of(JOBS[:3]))
    with pytest.raises(BrokenSealError, match="does not open"):
        unseal(tmp_path)


def test_an_answer_younger_than_the_key_is_refused(tmp_path):
    make(tmp_path)
    answer(tmp_path, "first")
    open_seal(tmp_path, key_of(JOBS))
    answer(tmp_path, "first", '{"better": 1}')
    with pytest.raises(BrokenSealError, match=r"younger than the key: answers/first\.json"):
        unseal(tmp_path)
    answer(tmp_path, "first")
    assert unseal(tmp_path)
    answer(tmp_path, "second")
    with pytest.raises(BrokenSealError, match=r"younger than the key: answers/second\.json"):
        unseal(tmp_path)


def test_a_changed_truth_breaks_the_seal(tmp_path):
    digest = make(tmp_path)
    open_seal(tmp_path, key_of(JOBS))
    with pytest.raises(BrokenSealError, match="has changed"):
        unseal(tmp_path, "0" * 64)
    (tmp_path / SEALED).write_bytes((tmp_path / SEALED).read_bytes()[:-8] + b"AAAAAAA=")
    with pytest.raises(BrokenSealError, match="does not open"):
        unseal(tmp_path, digest)


def test_a_case_folder_holds_configuration_and_recordings_only(tmp_path):
    make(tmp_path)
    for folder in (tmp_path / "cases").iterdir():
        assert all(path.name == "tubes.toml" or path.suffix == ".csv" for path in folder.iterdir())


def metadata(case):
    """What a file tells without being read as physics: names, counts, decimals, sizes."""
    names, texts = sorted(case.files), [case.files[name] for name in sorted(case.files)]
    rows = [row for text in texts for row in csv.reader(io.StringIO(text))]
    cells = [cell for row in rows[1:] for cell in row]
    decimals = [len(cell.partition(".")[2]) for cell in cells if "." in cell]
    return [
        len(names),
        sum(map(len, names)),
        len(rows),
        len(rows[0]),
        np.mean(decimals),
        np.std(decimals),
        np.mean([len(cell) for cell in cells]),
        len({row[0] for row in rows[1:]}),
        len(rows[1][0]),
        np.mean([cell == "" for cell in cells]),
        sum(map(len, texts)),
        len(case.config_text),
        case.config_text.count("{ value"),
    ]


def nearest_centroid_accuracy(features, labels):
    """Leave-one-out accuracy of nearest centroid on whitened features, averaged over the classes."""
    scaled = (features - features.mean(axis=0)) / (features.std(axis=0) + 1e-12)
    kinds = sorted(set(labels))
    hit = {kind: [] for kind in kinds}
    for i, label in enumerate(labels):
        others = np.arange(len(labels)) != i
        distance = [np.sum((scaled[others & (labels == kind)].mean(axis=0) - scaled[i]) ** 2) for kind in kinds]
        hit[label].append(kinds[int(np.argmin(distance))] == label)
    return float(np.mean([np.mean(hit[kind]) for kind in kinds]))


def test_metadata_does_not_tell_clean_from_concealed(cases):
    labels = np.array(["clean" if not case.truth["effects"] else "concealed" for case in cases])
    features = np.array([metadata(case) for case in cases])
    accuracy = nearest_centroid_accuracy(features, labels)
    shuffled = [nearest_centroid_accuracy(features, np.random.default_rng(k).permutation(labels)) for k in range(60)]
    # Chance is what shuffled labels reach; the true labels may stand three of its spreads above.
    assert accuracy < np.mean(shuffled) + 3 * np.std(shuffled)


def test_the_classifier_would_see_a_leak(cases):
    labels = np.array(["clean" if not case.truth["effects"] else "concealed" for case in cases])
    features = np.array([metadata(case) for case in cases])
    features[:, 2] += 3000 * (labels == "clean")
    assert nearest_centroid_accuracy(features, labels) > 0.8


def test_order_of_case_names_carries_no_level(cases):
    from examples.concealed.seal import case_id

    order = np.argsort([case_id(seed, "joint") for seed in SEEDS])
    clean = np.array([not case.truth["effects"] for case in cases])[order].astype(float)
    rank = np.arange(clean.size)
    assert abs(np.corrcoef(rank, clean)[0, 1]) < 3 / np.sqrt(clean.size)
