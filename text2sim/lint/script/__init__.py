"""Rules about the script: names, pushes, measures, events and expectations."""
