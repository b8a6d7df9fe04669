"""Services that the command line and the MCP server share: checks of cases, exit codes, words about runs."""
