"""Agent roles, and the loop in which they plan, write, run, judge and decide: from a request to an accepted case."""
