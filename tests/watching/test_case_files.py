"""Detection of saves, however an editor saves."""

import os
import threading
import time

import pytest

from text2sim.watching.case_files import CaseFiles


@pytest.fixture
def case(tmp_path):
    path = tmp_path / "case.yaml"
    path.write_text("one\n")
    return path


@pytest.fixture
def files(case):
    return CaseFiles(case)


def test_nothing_happened(files):
    assert files.saved() == ""


def test_written_in_place(files, case):
    case.write_text("two\n")
    assert files.saved() == "changed"
    assert files.saved() == ""


def test_the_same_length_in_the_same_second(files, case):
    case.write_text("eno\n")
    assert files.saved() == "changed"


def test_replaced_by_another_file(files, case):
    fresh = case.with_name("case.yaml~new")
    fresh.write_text("two\n")
    os.replace(fresh, case)
    assert files.saved() == "changed"


def test_moved_to_a_backup_first(files, case):
    case.rename(case.with_name("case.yaml~"))
    case.write_text("two\n")
    assert files.saved() == "changed"


def test_saved_again_without_a_change(files, case):
    os.utime(case, (1, 1))
    assert files.saved() == "touched"


def test_a_file_is_not_read_while_it_is_empty(files, case):
    """Some editors empty the file and write it a moment later: that is one save, not two."""
    case.write_text("")
    threading.Timer(0.1, case.write_text, ("two\n",)).start()
    time.sleep(0.02)
    assert files.saved() == "changed"
    assert case.read_text() == "two\n"
    assert files.saved() == ""


def test_a_file_that_stays_away_is_a_change(files, case):
    case.unlink()
    assert files.saved() == "changed"


@pytest.mark.parametrize("name", [".case.yaml.swp", "4913", "case.yaml~", "#case.yaml#", "notes.txt"])
def test_files_of_editors_are_no_change(files, case, name):
    case.with_name(name).write_text("x")
    assert files.saved() == ""


@pytest.mark.parametrize("name", ["assets/cup.obj", "prefabs/cup.yaml", "arm.urdf"])
def test_files_that_the_case_may_use_are_watched(files, case, name):
    path = case.parent / name
    path.parent.mkdir(exist_ok=True)
    path.write_text("x")
    assert files.saved() == "changed"
    path.write_text("y")
    assert files.saved() == "changed"
    os.utime(path, (1, 1))
    assert files.saved() == "", "a date says nothing about an asset"


def test_runs_beside_the_case_do_not_count(files, case):
    (case.parent / "runs" / "watch-a").mkdir(parents=True)
    (case.parent / "runs" / "watch-a" / "case.yaml").write_text("x")
    assert files.saved() == ""


def test_how_long_ago_it_was_saved(files, case):
    case.write_text("two\n")
    time.sleep(0.1)
    files.saved()
    assert 0.1 <= files.age <= 0.5


@pytest.mark.parametrize("kind", ["pipe", "device", "link to a pipe"])
def test_pipes_and_devices_are_not_read(files, case, kind):
    pipe = case.with_name("pipe.json")
    if kind == "device":
        pipe.symlink_to("/dev/zero")
    else:
        os.mkfifo(pipe)
    if kind == "link to a pipe":
        case.with_name("other.json").symlink_to(pipe)
    assert files.saved() == ""
    assert CaseFiles(case).saved() == ""
