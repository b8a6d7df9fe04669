"""What contacts cannot do: hold what is too fast, slide, give way, bounce."""
