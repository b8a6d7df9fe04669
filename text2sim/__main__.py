"""The command `python -m text2sim`."""

from text2sim.cli.main import run

if __name__ == "__main__":
    run()
