"""How meshes touch by their hull, by convex pieces and by their surface, measured: the table in docs/contact.md.

python -m benchmarks.mesh_contact           what was not run yet, then the table
python -m benchmarks.mesh_contact --all     all again
python -m benchmarks.mesh_contact --docs    and put it into docs/contact.md
"""

from benchmarks.softlab.fittings import TRIALS, Fit, measure, table
from benchmarks.softlab.trials import tabulate

if __name__ == "__main__":
    tabulate(__doc__, "mesh_contact", "meshes", TRIALS, measure, Fit, table, page="contact.md")
