"""What the reach of walls keeps in and what it costs, measured: the table in docs/soft.md.

python -m benchmarks.soft_leaks           what was not run yet, then the table
python -m benchmarks.soft_leaks --all     all again
python -m benchmarks.soft_leaks --docs    and put it into docs/soft.md
"""

from benchmarks.softlab.leaks import TRIALS, Tank, measure, table
from benchmarks.softlab.trials import tabulate

if __name__ == "__main__":
    tabulate(__doc__, "soft_leaks", "tanks", TRIALS, measure, Tank, table)
