"""Rules about joints and motors."""
