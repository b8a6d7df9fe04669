"""Rules about the script: names, forces, measures, events and expectations."""
