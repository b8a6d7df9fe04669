"""MCP server whose tools let a coding agent write, check, run and judge cases."""
