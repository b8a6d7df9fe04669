"""Jinja templates of the generated program, and the recorder that is copied into it."""
