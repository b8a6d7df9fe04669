"""Intake of assets: tests in tiny cases, previews, registration in a case's manifest."""
