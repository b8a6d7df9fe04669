"""Rules about the film: cameras, and what stands before them."""
