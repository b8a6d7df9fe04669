"""Child processes within limits, stops, progress, locks, and what this machine can do."""
