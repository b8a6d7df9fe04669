"""An MCP server: a coding agent writes, checks, runs and judges cases with a handful of bounded tools."""
