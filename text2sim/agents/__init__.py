"""Planner, Writers and Critic: whoever writes and repairs cases with a language model. Not built yet."""
