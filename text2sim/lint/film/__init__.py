"""Rules about the film: cameras and subjects."""
