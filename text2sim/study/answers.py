"""Answers of participants, in SQLite; each is stored before the next comparison is shown."""

import secrets
import sqlite3
import time
from collections import Counter
from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

from text2sim.spec_schema.errors import RunError
from text2sim.study.build import Study

FILE = "answers.sqlite"
_TABLES = """\
CREATE TABLE IF NOT EXISTS study (token TEXT NOT NULL);
CREATE TABLE IF NOT EXISTS person (id TEXT PRIMARY KEY, assignment INTEGER NOT NULL, agreed REAL NOT NULL);
CREATE TABLE IF NOT EXISTS answer (
    person TEXT NOT NULL REFERENCES person, trial INTEGER NOT NULL, question TEXT NOT NULL, level INTEGER,
    given REAL NOT NULL, PRIMARY KEY (person, trial, question)
);
"""


class StudyAnswer(NamedTuple):
    """One answer to one question."""

    person: str
    assignment: int
    trial: int
    question: str
    level: int | None
    """From -2 (A is much better) to 2 (B is much better); None: cannot judge."""


class Answers:
    """The answers of a study, in its folder.

    Args:
        folder: The folder.
        study: The study.

    Raises:
        RunError: if the file of the answers is damaged, or cannot be written.
    """

    def __init__(self, folder: Path, study: Study) -> None:
        self._study, self._file = study, folder / FILE
        try:
            self._base = sqlite3.connect(self._file, check_same_thread=False)  # the event loop serialises access
            with self._base:
                self._base.executescript(_TABLES)
                self._base.execute(
                    "INSERT INTO study SELECT ? WHERE NOT EXISTS (SELECT * FROM study)", (secrets.token_urlsafe(18),)
                )
        except sqlite3.DatabaseError as error:
            raise RunError(f"{self._file}: answers cannot be kept in it ({error})") from None

    @property
    def token(self) -> str:
        """The secret in the address of the page; it survives a restart."""
        return self._base.execute("SELECT token FROM study").fetchone()[0]

    def begin(self) -> str | None:
        """Give a new participant an assignment; return the participant's id, or None if all assignments are finished.

        The unfinished assignment that the fewest people have begun is given.
        """
        begun, done = Counter[int](), set[int]()
        count = "SELECT assignment, count(DISTINCT trial) FROM person LEFT JOIN answer ON person = id GROUP BY id"
        for assignment, answered in self._base.execute(count):
            begun[assignment] += 1
            if answered == len(self._study.assignments[assignment]):
                done.add(assignment)
        free = [k for k in range(len(self._study.assignments)) if k not in done]
        if not free:
            return None
        person = secrets.token_urlsafe(18)
        with self._base:
            row = (person, min(free, key=lambda k: begun[k]), time.time())
            self._base.execute("INSERT INTO person VALUES (?, ?, ?)", row)
        return person

    def position(self, person: str) -> tuple[int, int] | None:
        """Return a person's assignment and the number of comparisons answered; None if the person is unknown."""
        count = "SELECT count(DISTINCT trial) FROM answer WHERE person = id"
        return self._base.execute(f"SELECT assignment, ({count}) FROM person WHERE id = ?", (person,)).fetchone()

    def give(self, person: str, trial: int, levels: Mapping[str, int | None]) -> None:
        """Store the answers to a comparison; earlier answers to it are kept.

        Args:
            person: Id of the person.
            trial: Number of the comparison.
            levels: Answers by question, see `StudyAnswer.level`.
        """
        rows = [(person, trial, question, level, time.time()) for question, level in levels.items()]
        with self._base:
            self._base.executemany("INSERT OR IGNORE INTO answer VALUES (?, ?, ?, ?, ?)", rows)

    def all(self) -> list[StudyAnswer]:
        """Return all answers, in the order in which they were given.

        Raises:
            RunError: if the file is damaged, or has answers of another study.
        """
        select = "SELECT person, assignment, trial, question, level FROM answer JOIN person ON person = id"
        try:
            found = [StudyAnswer(*row) for row in self._base.execute(f"{select} ORDER BY given")]
        except sqlite3.DatabaseError as error:
            raise RunError(f"{self._file}: answers cannot be read from it ({error})") from None
        if not all(map(self._is_possible, found)):
            raise RunError(f"{self._file}: has answers that no participant of this study can give")
        return found

    def _is_possible(self, answer: StudyAnswer) -> bool:
        lengths = dict(enumerate(map(len, self._study.assignments)))
        return (
            answer.trial in range(lengths.get(answer.assignment, 0))
            and answer.question in self._study.questions
            and answer.level in (None, *range(-2, 3))
        )

    def close(self) -> None:
        """Close the database."""
        self._base.close()
