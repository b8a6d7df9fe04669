"""From words to an accepted case: the roles, and the loop in which they plan, write, run, judge and decide."""
