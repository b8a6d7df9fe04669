"""How things start: inside each other, under the ground, with nothing to stand on."""
