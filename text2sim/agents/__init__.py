"""From words to an accepted case: Reader, Planner, Writers, asset agents, Critic and Viewer, and the loop they work in."""
