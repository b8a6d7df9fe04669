"""What the film would show: cameras, and what stands before them."""
