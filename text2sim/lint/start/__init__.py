"""Rules about the start: bodies inside each other, under the ground, with nothing to stand on."""
