"""YAML scalars as ROS 2 reads them.

``rcl_yaml_param_parser`` has its own rules: ``1e10`` is a double, ``0x10`` an integer, ``y`` a
boolean, ``null`` a string. A scenario file is handed unchanged to the nodes, so the check has to
read each value exactly as they will.

Source: rcl_yaml_param_parser (Jazzy), ``src/parse.c``, ``get_value``; tried with rclpy 7.1.6.
"""

from __future__ import annotations

import json
import re
import sys
from typing import Final

_TRUE: Final = re.compile("[Yy]|[Yy]es|YES|[Tt]rue|TRUE|[Oo]n|ON")
_FALSE: Final = re.compile("[Nn]|[Nn]o|NO|[Ff]alse|FALSE|[Oo]ff|OFF")
_INTEGER: Final = re.compile(r"[+-]?(0[xX][0-9a-fA-F]+|0[0-7]*|[1-9][0-9]*)")
_FLOAT: Final = re.compile(r"[+-]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][+-]?[0-9]+)?")
_HEXADECIMAL: Final = re.compile(
    r"[+-]?0[xX]([0-9a-fA-F]+\.?[0-9a-fA-F]*|\.[0-9a-fA-F]+)([pP][+-]?[0-9]+)?"
)
_NOT_FINITE: Final = re.compile(
    r"[+-]?([nN][aA][nN]|[iI][nN][fF]([iI][nN][iI][tT][yY])?)|\.(nan|NaN|NAN)|[+-]?\.(inf|Inf|INF)"
)
_PLAIN_WORD: Final = re.compile(r"[A-Za-z_][A-Za-z0-9_./-]*")
_INT64: Final = range(-(2**63), 2**63)
_MOST_DIGITS: Final = 22  # of an int64, which are octal

Scalar = bool | int | float | str


def parse_plain(text: str) -> Scalar:
    """Return the value of an unquoted, untagged scalar."""
    if _TRUE.fullmatch(text):
        return True
    if _FALSE.fullmatch(text):
        return False
    if _INTEGER.fullmatch(text):
        whole = _c_integer(text)
        if whole is not None:
            return whole
    if _NOT_FINITE.fullmatch(text):
        return float(text.replace(".", ""))
    if _FLOAT.fullmatch(text):
        return _c_double(text)
    return _c_hexadecimal(text) if _HEXADECIMAL.fullmatch(text) else text


def emit(value: Scalar | list[Scalar]) -> str:
    """Return YAML text that `parse_plain`, ROS 2 and YAML 1.1 readers all read as ``value``."""
    if isinstance(value, list | tuple):
        return "[" + ", ".join(emit(item) for item in value) + "]"
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, float):
        return _emit_float(value)
    if isinstance(value, str):
        plain = _PLAIN_WORD.fullmatch(value) and parse_plain(value) == value
        return value if plain and value not in ("null", "Null", "NULL") else json.dumps(value)
    return str(value)


def _emit_float(value: float) -> str:
    text = repr(value)
    if "e" not in text and "n" not in text:  # most: no exponent, no NaN or infinity
        return text
    if text in ("nan", "inf", "-inf"):
        return text.replace("nan", ".nan").replace("inf", ".inf")
    mantissa, exponent, power = text.partition("e")
    if "." not in mantissa:  # YAML 1.1 readers take 1e-10 for a word
        mantissa += ".0"
    return mantissa + exponent + power


def _c_integer(text: str) -> int | None:
    """Read as C's strtoll with base 0: 0x is hexadecimal, a leading 0 octal; None: too large."""
    digits = text.lstrip("+-")
    base = 16 if digits[:2] in ("0x", "0X") else 8 if digits.startswith("0") else 10
    digits = digits.lstrip("0").lstrip("xX").lstrip("0") or "0"
    if len(digits) > _MOST_DIGITS:  # Python refuses to convert some thousand
        return None
    number = int(digits, base) * (-1 if text.startswith("-") else 1)
    return number if number in _INT64 else None


def _c_double(text: str) -> float | str:
    """Read as ROS 2 does: a number out of the range of normal doubles stays a word."""
    value = float(text)
    zero = not re.search("[1-9]", re.split("[eE]", text)[0])
    in_range = sys.float_info.min <= abs(value) <= sys.float_info.max
    return value if zero or in_range else text


def _c_hexadecimal(text: str) -> float | str:
    """Read likewise; hexadecimal digits may well be exact below the normal doubles."""
    try:
        value = float.fromhex(text)
    except OverflowError:
        return text
    zero = not re.search("[1-9a-f]", re.split("[pP]", text)[0].lower().partition("x")[2])
    return value if zero or value else text
