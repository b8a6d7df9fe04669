"""Runs a case: program, simulation, film, evidence and report, doing only what is not yet done."""
