"""Measures of contacts, against touches whose every number is known."""

import numpy as np


def test_contact_force_is_that_of_a_scale(new_run, measure):
    run = new_run(every=2)
    floor, ball, other = run.add_link("floor"), run.add_link("ball"), run.add_link("other")
    # The force flickers between the two steps of a frame: a scale shows its mean; frame 0 has step 1.
    run.touch(floor, ball, range(1, 101, 2), (0, 0, 30.0), depth=0.002)
    run.touch(floor, ball, range(2, 101, 2), (0, 0, 10.0), depth=0.001)
    run.touch(ball, other, range(50, 101), (5.0, 0, 0))
    folder = run.write()
    both = {"bodies": ("ball", "other"), "statics": ("floor",)}
    force = measure(folder, kind="contact_force", of="ball", by="floor", **both).values
    np.testing.assert_allclose(force[0], 30.0)
    np.testing.assert_allclose(force[1:], 20.0)
    everything = measure(folder, kind="contact_force", of="ball", **both).values
    np.testing.assert_allclose(everything[-1], np.hypot(20, 5))
    # It pushes `other` along +x, and is pushed back.
    for axis, last in (("z", 20.0), ("x", -5.0), ("y", 0.0)):
        component = measure(folder, kind="contact_force", of="ball", axis=axis, **both).values
        np.testing.assert_allclose(component[-1], last)
    np.testing.assert_allclose(measure(folder, kind="contact_count", of="ball", **both).values, 1 + (run.step >= 50))
    np.testing.assert_allclose(
        measure(folder, kind="contact_count", of="ball", by="other", **both).values, run.step >= 50
    )
    np.testing.assert_allclose(measure(folder, kind="penetration", of="other", **both).values, 0.001 * (run.step >= 50))
    np.testing.assert_allclose(measure(folder, kind="penetration", of="floor", **both).values, 0.002)


def test_forces_between_copies_of_one_set_cancel(new_run, measure):
    run = new_run(duration=0.1)
    a, b = run.add_link("brick[0]"), run.add_link("brick[1]")
    run.touch(a, b, range(1, 11), (7.0, 0, 0))
    folder = run.write()
    assert measure(folder, bodies=("brick",), kind="contact_force", of="brick").values.max() == 0.0
    assert measure(folder, bodies=("brick",), kind="contact_force", of="brick[1]").values.min() == 7.0
    assert measure(folder, bodies=("brick",), kind="contact_count", of="brick").values.max() == 1


def test_contacts_that_were_not_recorded_are_no_zero(new_run, measure):
    run = new_run(duration=0.1)
    run.add_link("ball")
    series = measure(run, scene={"record": {"contacts": False}}, kind="contact_count", of="ball")
    assert "not recorded" in series.problem or "no contacts were recorded" in series.problem
    assert np.isnan(series.values).all()
