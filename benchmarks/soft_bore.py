"""How `soft_reach` and the cell change a bore, measured: the table in docs/soft.md.

python -m benchmarks.soft_bore            what was not run yet, then the table
python -m benchmarks.soft_bore --all      all again
python -m benchmarks.soft_bore --docs     and put it into docs/soft.md
"""

from benchmarks.softlab.bore import TRIALS, Bore, measure, table
from benchmarks.softlab.trials import tabulate

if __name__ == "__main__":
    tabulate(__doc__, "soft_bore", "bores", TRIALS, measure, Bore, table)
