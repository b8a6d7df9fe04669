"""Evidence from a recording: measures, events, expectations, diagnostics, suspicions, and the report."""
