"""Truth is sealed before the answers, and nothing beside the recordings tells it."""

import csv
import io
import json

import numpy as np
import pytest

from examples.concealed.case import make_case
from examples.concealed.seal import SEALED, BrokenSealError, build_all, unseal, write

SEEDS = range(9000, 9064)


@pytest.fixture(scope="module")
def cases():
    return [make_case(seed) for seed in SEEDS]


def test_the_same_seed_gives_the_same_bytes(tmp_path):
    jobs = [("joint", seed, None, None) for seed in range(4)]
    first = write(tmp_path / "a", build_all(jobs, 1))
    assert first == write(tmp_path / "b", build_all(jobs, 1))
    for path in (tmp_path / "a").rglob("*"):
        if path.is_file():
            assert path.read_bytes() == (tmp_path / "b" / path.relative_to(tmp_path / "a")).read_bytes()


def test_a_changed_truth_breaks_the_seal(tmp_path):
    digest = write(tmp_path, build_all([("joint", 1, "L1", None)], 1))
    truths = unseal(tmp_path, digest)
    (name,) = truths
    truths[name]["level"] = "L0"
    (tmp_path / SEALED).write_text(json.dumps(truths))
    with pytest.raises(BrokenSealError):
        unseal(tmp_path, digest)


def test_a_case_folder_holds_configuration_and_recordings_only(tmp_path):
    write(tmp_path, build_all([("joint", seed, None, None) for seed in range(6)], 1))
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
