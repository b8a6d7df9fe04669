"""Debug Cards: lessons from reproduced failures, and their retrieval.

`model` defines cards, `library` reads and checks them, `retrieval` finds the cards that fit a failure, and `verify`
runs the cases of a card. Each card has a folder in `cards`.
"""
