"""The page of the documentation about Debug Cards: `python -m text2sim.card_library.reference > docs/cards.md`."""

from typing import get_args

from text2sim.card_library.library import BUILT_IN, MAX_CARD, MAX_CASE, CardEntry, load_library
from text2sim.card_library.model import Mode, Role
from text2sim.card_library.retrieval import DUPLICATE_LIKENESS

_INTRODUCTION = """\
<!-- Made by `python -m text2sim.card_library.reference`: change the cards in text2sim/card_library, not this page. -->
# Debug Cards

A Debug Card is a lesson from a failure that was reproduced and a repair that was run: symptoms, likely causes, what
tells it from others, what to change, and which shortcuts only hide it. Cards go into prompts of language models, so
that each has at most 350 tokens; people read them just as well. Most are about what the [lint](lint.md) cannot see.

```sh
text2sim cards list                      # one line for each
text2sim cards show grip-slips           # all that a card says, and where its two cases lie
text2sim cards find "the brick slips out of the gripper" --role actions --mode articulated
text2sim cards verify grip-slips         # run both cases, and compare with what the card says
text2sim cards verify --jobs 2           # the same of all cards: two runs for each, ten seconds or more for a run
```

All take `--json`. `verify` ends with 1 if a card does not hold; `--lint-only` compares what needs no engine; `--force`
simulates again what lies in `--runs` already.

## A card

A folder `cards/ID` of the package with three files: `card.yaml`, `failing.yaml` and `repaired.yaml`. The last two are
ordinary cases with the same expectations, which differ in the repair and little else: `text2sim diff` shows it, and
`text2sim run` runs them.

`card.yaml` has

- `id`, the folder's name, and `title`, the lesson in 80 characters;
- `applies`, when it is of use: `modes` (@MODES@), `tags` (what the task is about), `signatures` (how the failure shows:
  ids of lint rules, `diverged`, words of the evidence) and `roles` (who needs it: @ROLES@);
- `symptoms`, `likely_causes`, `checks`, `repair` and `forbidden`, lists of sentences;
- `evidence`: the scene in words, an `outcome` and what was `observed`, with numbers, of the failing and of the repaired
  case, and the versions that they ran on.

An outcome is `lint:RULE` (the lint finds it), `state:diverged` (the run stops as diverged), `missed:NAME` (it ends, and
this expectation did not come true), `suspicion` (it ends, and its evidence says that something looks wrong) or
`passed`.

`TEXT2SIM_CARDS` names a folder with more cards, which are held to the same rules and limits: no links, @CARD@
characters for a card and @CASE@ for a case, nothing executed. What is wrong with one is said at its line, and it is
left out.

## How they are found

Cards for other roles are left out. A signature that the lint or the run has given counts most, then words (BM25 over
title, tags, signatures, symptoms and causes), then the mode of the scene. The order is the same each time. From Python:
`text2sim.card_library.retrieval.find_cards`, `Library.index` for the list that a Planner chooses from, and
`Card.brief(role)` for the text of a prompt.

## How they are learned

```sh
text2sim cards distill cases/throw --model M                # from one finished loop: failed there, fixed there
text2sim cards distill --suite learning --model M --judge J --reviewer R --out cards --work runs/learning
text2sim cards ledger cards --runs runs/answers             # what each owes, what it changed, whether it was given
```

With `--suite` all prompts are answered and judged as `text2sim evaluate` does it. For each prompt a reviewer (the
judge, or with `--reviewer` another model) compares request, judgements, attempts and pictures, names a failure with
its evidence, and writes a card: of two attempts, or of one with a patch that mends it. A card that shares @SAME@ of
its words with another says the same: it has to be an edit of that one, if that was learned, and is refused if that
comes with text2sim. Both cases are run, and what does not hold goes back with the reason. The prompt, and those that
an edited card owes something to, are answered and judged again with the card. It is kept if somebody was given it
there and the mean of physical and visual score rose by more than repeats of judgements scatter. One loop before and
one after are compared: a card may also be lucky. At the end cards that say the same become one. Called again, the
command goes on where it was.

`ledger.json` beside the cards has, of every card, the prompts and by them the sources to which it owes its lesson,
the failure and its evidence, the scores before and after, and whether it was kept, rejected or merged. `cards ledger`
says which made it worse and which nobody was given; with `--runs` also of those that come with text2sim. `text2sim
evaluate run` refuses to answer a suite while `TEXT2SIM_CARDS` has a card that owes something to one of its sources or
prompts, one that the ledger does not know (`distill CASE` makes such), or one that has changed since it was entered.
`distill --suite` refuses a suite that shares a source with `demonstrations`; `--apart-from` names more.

## The cards

"""


def cards_reference() -> str:
    """Return the text of the page."""
    entries = load_library([BUILT_IN]).entries.values()
    intro = _INTRODUCTION.replace("@MODES@", ", ".join(get_args(Mode))).replace("@ROLES@", ", ".join(get_args(Role)))
    intro = intro.replace("@SAME@", f"{DUPLICATE_LIKENESS:.0%}".replace("%", " %"))
    intro = intro.replace("@CARD@", f"{MAX_CARD:,}").replace("@CASE@", f"{MAX_CASE:,}")
    rows = ["| card | lesson | failing | repaired |", "|---|---|---|---|", *map(_row, entries)]
    return intro + "\n".join(rows) + "\n"


def _row(entry: CardEntry) -> str:
    seen = entry.card.evidence
    failing = f"{seen.failing.observed} (`{seen.failing.outcome}`)"
    cells = (f"`{entry.id}`", entry.card.title, failing, seen.repaired.observed)
    return "| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |"


if __name__ == "__main__":
    print(cards_reference(), end="")
