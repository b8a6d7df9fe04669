"""What a program gets to know of the environment of whoever runs it."""

from text2sim.runtime.child import child_environment


def test_a_program_shares_out_its_sums_in_one_way_whoever_runs_it() -> None:
    given = {"OMP_NUM_THREADS": "7", "MKL_NUM_THREADS": "3", "HOME": "/home/somebody"}
    found = child_environment(given)
    assert found == child_environment({"HOME": "/home/somebody"})
    assert found["OMP_NUM_THREADS"] == "1"


def test_a_program_gets_no_keys() -> None:
    given = {"OPENAI_API_KEY": "x", "XDG_TOKEN": "x", "AWS_SECRET": "x", "OMP_KEY": "x"}
    assert not given.keys() & child_environment(given).keys()
