"""What a case asks for: names, pushes, measures, events and expectations."""
