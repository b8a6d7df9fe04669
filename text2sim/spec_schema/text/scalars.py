"""Plain scalars by the core schema of YAML 1.2: `no` is a word, `010` is ten, `1e-3` is a number."""

import re

from text2sim.spec_schema.arithmetic.values import MAX_NUMBER, MIN_NUMBER

Scalar = None | bool | int | float | str

_WORDS: dict[str, Scalar] = {
    "": None,
    "~": None,
    "null": None,
    "Null": None,
    "NULL": None,
    "true": True,
    "True": True,
    "TRUE": True,
    "false": False,
    "False": False,
    "FALSE": False,
}
_NUMBER_STARTS = frozenset("+-.0123456789")
_INTEGER = re.compile(r"[-+]?[0-9]+")
_OCTAL = re.compile(r"0o[0-7]+")
_HEX = re.compile(r"0x[0-9a-fA-F]+")
_FLOAT = re.compile(r"[-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]+)?")
_NOT_FINITE = re.compile(r"[-+]?\.(inf|Inf|INF)|\.(nan|NaN|NAN)")

MAX_DIGITS = 100


def resolve(text: str) -> Scalar:
    """Return the value of a plain scalar.

    Raises:
        ValueError: For a number that is not finite, too large or too small, or has too many digits.
    """
    if text in _WORDS:
        return _WORDS[text]
    if text[0] not in _NUMBER_STARTS:
        return text
    if _FLOAT.fullmatch(text):
        return _integer(text, 10) if _INTEGER.fullmatch(text) else _float(text)
    if _OCTAL.fullmatch(text):
        return _integer(text[2:], 8)
    if _HEX.fullmatch(text):
        return _integer(text[2:], 16)
    if _NOT_FINITE.fullmatch(text):
        raise ValueError(f"{text} is not a finite number")
    return text


def _integer(text: str, base: int) -> int:
    if len(text) > MAX_DIGITS:
        raise ValueError(f"the number has more than {MAX_DIGITS} digits")
    value = int(text, base)
    _check_size(value, text)
    return value


def _float(text: str) -> float:
    value = float(text)
    if value == 0 and any(c in "123456789" for c in text.lower().partition("e")[0]):
        raise ValueError(f"{_short(text)} is too small: write 0")
    _check_size(value, text)
    return value


def _check_size(value: float, text: str) -> None:
    if abs(value) > MAX_NUMBER:
        raise ValueError(f"{_short(text)} is too large: numbers go up to {MAX_NUMBER:g}")
    if 0 < abs(value) < MIN_NUMBER:
        raise ValueError(f"{_short(text)} is too small: write 0")


def _short(text: str) -> str:
    """Return a shortened number with its exponent."""
    return text if len(text) <= 30 else f"{text[:15]}…{text[-12:]}"
