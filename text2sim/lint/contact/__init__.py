"""Rules about the limits of contacts: speed, sliding, creep, bounce."""
