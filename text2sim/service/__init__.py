"""Services that the command line and the MCP server share: examined cases, exit codes, words about runs."""
