"""Debug Cards: lessons from failures that were reproduced, and how the right one is found.

`model` says what a card is, `library` reads cards and checks them, `retrieval` finds those that fit a failure,
`verify` runs what a card tells of. The cards lie in `cards`, a folder for each.
"""
