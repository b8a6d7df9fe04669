"""Sessions: saves, and recovery from processes that crash, hang or grow."""

import json
import threading
import time

import psutil
from watched import CASE

from text2sim.runtime import warm_engine as engine_module


def shown(watched):
    """What the page has to know of the scene that it shows."""
    return json.loads(watched.state.scene(watched.content()["scene"]["name"]))["contents"]


HIGHER = ("1.5]", "1.7]")


def test_the_first_text_is_simulated_judged_and_shown(watch):
    watched = watch()
    done = watched.wait("done")
    assert done["take"] == 1
    assert done["state"] == "finished"
    assert {"simulate", "scene", "judge"} <= done["what"]
    assert done["expect"] == {"falls": True}
    content = watched.content()
    assert content["tone"] == "good"
    assert (content["scene"]["take"], content["scene"]["whole"]) == ("1", True)
    scene = shown(watched)
    assert [row["name"] for row in scene["measures"]] == ["height"]
    assert [(row["name"], row["ok"]) for row in scene["expect"]] == [("falls", True)]
    assert {piece["body"]: piece["color"] for piece in scene["pieces"]} == {"ball": [255, 0, 0, 255]}


def test_another_number_is_another_take(watch):
    watched = watch()
    watched.wait("done")
    said = len(watched.said)
    watched.save(HIGHER)
    done = watched.wait("done", said)
    assert done["take"] == 2
    assert done["expect"] == {"falls": True}
    assert [path.name for path in watched.runs.glob("take-*")] == ["take-2"]


def test_takes_cannot_be_mistaken_for_runs(watch):
    watched = watch()
    watched.wait("done")
    assert not (watched.runs / "take-1/run.json").exists()
    assert "preview" in (watched.runs / "take-1/watch.json").read_text()
    assert (watched.runs / "take-1/case.yaml").read_text() == watched.file.read_text()


def test_another_look_is_only_shown(watch):
    watched = watch()
    watched.wait("done")
    said, before = len(watched.said), watched.content()["scene"]
    watched.save(("color: red", "color: blue"))
    done = watched.wait("done", said)
    assert done["take"] == 1
    assert done["what"] & {"simulate", "scene"} == {"scene"}
    assert watched.content()["scene"]["name"] != before["name"]
    assert shown(watched)["pieces"][0]["color"] == [0, 0, 255, 255]


def test_another_expectation_is_only_judged(watch):
    watched = watch()
    watched.wait("done")
    said = len(watched.said)
    watched.save(("below: 1.2", "below: 1.7, above: 1.3"))
    done = watched.wait("done", said)
    assert done["take"] == 1
    assert done["what"] & {"simulate", "scene", "judge"} == {"scene", "judge"}
    assert done["expect"] == {"falls": False}
    assert [row["ok"] for row in shown(watched)["expect"]] == [False]
    assert watched.content()["tone"] == "bad"


def test_another_comment_changes_nothing(watch):
    watched = watch()
    watched.wait("done")
    said = len(watched.said)
    watched.save(("prompt:", "# a remark\nprompt:"))
    assert "nothing to do" in watched.wait("status", said)
    assert watched.content()["tone"] == "good"


def test_problems_are_shown_at_once_and_the_scene_stays(watch):
    watched = watch()
    watched.wait("done")
    said, scene = len(watched.said), watched.content()["scene"]
    watched.save(("radius: 0.1", "raduis: 0.1"))
    begun = time.monotonic()
    assert set(watched.wait("checked", said)) == {"unknown-key", "missing"}
    assert time.monotonic() - begun < 20.0
    time.sleep(0.05)
    content = watched.content()
    assert content["tone"] == "bad"
    assert content["stale"] is True
    assert content["scene"] == scene
    assert {row["line"] for row in content["problems"]} == {6}
    assert "raduis" in content["problems"][0]["excerpt"]
    time.sleep(0.2)
    assert watched.said[said + 1 :] == []
    said = len(watched.said)
    watched.save(("raduis", "radius"))
    assert "nothing to do" in watched.wait("status", said)
    assert watched.content()["tone"] == "good"
    assert watched.content()["stale"] is False
    assert watched.content()["problems"] == []


def test_a_save_supersedes_the_current_simulation(watch):
    watched = watch()
    watched.wait("done")
    said = len(watched.said)
    watched.save(("A ball falls.", "A slow ball falls."), HIGHER)
    watched.wait("checked", said)
    time.sleep(0.2)
    watched.save(("A slow ball falls.", "A ball falls."), ("1.7]", "1.6]"))
    done = watched.wait("done", said)
    assert done["take"] == 3
    assert [name for name, _ in watched.said[said:]] == ["checked", "checked", "done"]


def test_a_case_is_not_simulated_twice_while_it_is_being_simulated(watch):
    """A change of looks during a simulation leaves it alone."""
    watched = watch(timeout=1.0)
    watched.wait("done")
    said = len(watched.said)
    watched.save(("A ball falls.", "A slow ball falls."), HIGHER)
    watched.wait("checked", said)
    watched.save(("color: red", "color: blue"))
    assert watched.wait("done", said)["take"] == 2


def test_a_simulation_that_takes_too_long_is_stopped_and_shown_as_far_as_it_came(watch):
    watched = watch(timeout=0.3)
    watched.wait("done")
    said = len(watched.said)
    watched.save(("A ball falls.", "A slow ball falls."), HIGHER)
    words, _ = watched.wait("trouble", said)
    assert words == "timeout: it took longer than 0.3 s, and was stopped"
    done = watched.wait("done", said)
    assert done["state"] == "timeout"
    assert done["no_scene"] == ""


def test_a_simulation_that_does_not_stop_is_killed(watch, monkeypatch):
    monkeypatch.setattr(engine_module, "STOP_LIMIT", 0.2)
    watched = watch(timeout=0.3)
    watched.wait("done")
    said = len(watched.said)
    watched.save(("A ball falls.", "A ball hangs."), HIGHER)
    assert "did not stop" in watched.wait("trouble", said)[0]
    assert watched.wait("status", said) == "the engine is restarted"
    said = len(watched.said)
    watched.save(("A ball hangs.", "A ball falls."), ("1.7]", "1.8]"))
    while (done := watched.wait("done", said))["take"] != 3:
        said += 1
    assert done["state"] == "finished"


def test_a_crash_is_reported_and_the_next_save_works(watch):
    watched = watch()
    watched.wait("done")
    said = len(watched.said)
    watched.save(("A ball falls.", "A ball crashes."), HIGHER)
    words, _ = watched.wait("trouble", said)
    assert words.startswith("crashed: the engine gave up (SIGABRT")
    assert "nothing was recorded" in watched.wait("done", said)["no_scene"]
    said = len(watched.said)
    watched.save(("A ball crashes.", "A ball falls."), ("1.7]", "1.8]"))
    assert watched.wait("done", said)["state"] == "finished"


def test_an_engine_that_dies_while_idle_does_not_affect_the_next_save(watch):
    watched = watch()
    watched.wait("done")
    said = len(watched.said)
    (engine,) = [child for child in psutil.Process().children() if "fake_engine" in child.cmdline()]
    engine.kill()
    watched.save(HIGHER)
    assert watched.wait("done", said)["state"] == "finished"
    assert "trouble" not in dict(watched.said)


def test_a_crashed_text_is_tried_again_when_it_is_saved_again(watch):
    watched = watch(CASE.replace("A ball falls.", "A ball crashes."))
    watched.wait("done")
    said = len(watched.said)
    time.sleep(0.05)
    watched.save()
    assert watched.wait("trouble", said)[0].startswith("crashed")


def test_a_divergence_is_judged_and_shown(watch):
    watched = watch()
    watched.wait("done")
    said = len(watched.said)
    watched.save(("A ball falls.", "A ball diverges."), HIGHER)
    done = watched.wait("done", said)
    assert done["state"] == "diverged"
    assert watched.content()["words"].startswith("diverged at t = 0.05 s")


def test_an_error_of_the_engine_is_located_in_the_case(watch):
    watched = watch()
    watched.wait("done")
    said = len(watched.said)
    watched.save(("A ball falls.", "A ball fails."), HIGHER)
    words, problem = watched.wait("trouble", said)
    assert words == "failed: GenesisException: no"
    assert problem is not None
    assert problem.line == 6


def test_an_engine_that_has_grown_is_replaced_between_takes(watch):
    watched = watch()
    watched.wait("done")
    said = len(watched.said)
    watched.save(("A ball falls.", "A ball grows."), HIGHER)
    watched.wait("done", said)
    until = time.monotonic() + 20
    while not watched.session.engine.renewals:
        assert time.monotonic() < until
        time.sleep(0.01)
    said = len(watched.said)
    watched.save(("A ball grows.", "A ball falls."), ("1.7]", "1.8]"))
    assert watched.wait("done", said)["state"] == "finished"
    assert not [words for kind, words in watched.said if kind == "trouble"]


def test_another_precision_takes_another_process(watch):
    watched = watch()
    watched.wait("done")
    said = len(watched.said)
    cube = "cube: {kind: soft, solver: fem, shape: {kind: box, size: [0.1, 0.1, 0.1]}, pose: {pos: [1, 0, 0.2]}}"
    watched.save(("bodies:\n", f"bodies:\n  {cube}\n"))
    assert watched.wait("done", said)["state"] == "finished"
    assert ("status", "the engine is restarted, for another numeric precision") in watched.said[said:]
    said = len(watched.said)
    watched.save(("size: [0.1, 0.1, 0.1]", "size: [0.2, 0.1, 0.1]"))
    assert watched.wait("done", said)["state"] == "finished"
    assert "fresh" not in str(watched.said[said:]), "of the same precision, the same process"


def test_an_engine_that_does_not_start_is_given_up(watch):
    watched = watch(engine="no_such_module")
    words, _ = watched.wait("trouble")
    assert words.startswith("the engine does not start: ")
    assert "no_such_module" in (watched.runs / "engine.log").read_text()
    said = len(watched.said)
    watched.save(("radius: 0.1", "raduis: 0.1"))
    assert watched.wait("checked", said), "checks go on"


def test_nothing_is_left_when_it_ends(watch):
    others = set(psutil.Process().children(recursive=True))  # of other tests
    watched = watch()
    watched.wait("done")
    children = set(psutil.Process().children(recursive=True)) - others
    assert children
    watched.stop()
    _, alive = psutil.wait_procs(list(children), timeout=5)
    assert not alive
    assert not [thread for thread in threading.enumerate() if thread.name in ("engine", "scene")]
