"""Rules about contacts: speed, sliding, creep, bounce."""
