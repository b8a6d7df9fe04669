"""Joints and motors: what is asked of them, and what they can do."""
