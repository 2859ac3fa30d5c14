"""From Python's values to the text and the files of a scene, checked against the scene's schema on the way.

Errors name the argument as it is written in Python (``rods[0].section.bending``) and its value.
"""

from __future__ import annotations

import difflib
import io
import json
import operator
import os
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, fields, is_dataclass
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _supercoil
from .errors import InputError

Table = dict[str, Any]

#: Keys that name a file, and what may stand in its place.
_ARRAY, _TABLE = "an array", "a dict of columns, a data frame or an array with named columns"
_FILES = {"file": _ARRAY, "table": _TABLE, "steps": _TABLE, "proteins": _TABLE, "fasta": None}


@cache
def schema() -> Table:
    """The JSON Schema of scenes, which the Rust half makes from the types that read them."""
    found: Table = json.loads(_supercoil.schema())
    return found


def ramp_keys() -> frozenset[str]:
    """Keys of a stage's ``ramp``."""
    return frozenset(schema()["$defs"]["RampText"]["properties"])


@dataclass(frozen=True)
class Given:
    """An array that was given as an argument of its own, not at the key that takes it."""

    argument: str
    array: np.ndarray[Any, Any]


class Inputs:
    """Plain values for TOML, and the files that stand for arrays in them."""

    def __init__(self, rods: Sequence[str] = ()) -> None:
        #: Names of the rods, by which errors call them.
        self.rods = rods
        #: Contents by name.
        self.files: dict[str, bytes] = {}
        #: The argument that each file stands for.
        self.arguments: dict[str, str] = {}

    def in_arguments(self, said: str) -> str:
        """An error about a rod by its name or a file that stands for an argument, as one about the argument: rows for lines below
        the head."""
        for k, name in enumerate(self.rods):
            said = re.sub(rf"\brods\.{re.escape(name)}(?=[.:,]|$)", f"rods[{k}]", said)
        for file, argument in self.arguments.items():
            said = re.sub(rf"{re.escape(file)}: line 1: ", f"{argument}: ", said)
            said = re.sub(rf"{re.escape(file)}: line (\d+)", lambda line: f"{argument}: row {int(line[1]) - 2}", said)
            said = said.replace(file, argument)
        return re.sub(r"^(rods\[\d+\]): (?=\1)", "", said)

    def plain(self, value: Any, where: str = "") -> Any:
        """The value as TOML knows it; keys that are None are left out, arrays where a file is taken become one."""
        if hasattr(value, "_table"):
            return self.plain(value._table(), where)
        if is_dataclass(value) and not isinstance(value, type):
            return self.plain({f.name: getattr(value, f.name) for f in fields(value)}, where)
        if isinstance(value, Mapping):
            entries = ((str(key), entry) for key, entry in value.items() if entry is not None)
            return {key: self._entry(key, entry, f"{where}.{key}" if where else key) for key, entry in entries}
        if isinstance(value, np.ndarray):
            return self.plain(value.tolist(), where)
        if isinstance(value, np.generic):
            return value.item()
        if isinstance(value, os.PathLike):
            return os.fspath(value)
        if isinstance(value, (list, tuple)):
            return [self.plain(entry, f"{where}[{k}]") for k, entry in enumerate(value)]
        return value

    def _entry(self, key: str, value: Any, where: str) -> Any:
        if isinstance(value, Given):
            return self._array(value.array, f"{where.rsplit('.', 2)[0]}.{value.argument}")
        if key not in _FILES or isinstance(value, (int, float)):
            return self.plain(value, where)
        if isinstance(value, (str, os.PathLike)):
            if os.path.exists(value):
                return os.path.abspath(value)
            # a word
            if key == "steps":
                return os.fspath(value)
            raise InputError(f"{where} = {os.fspath(value)!r}: there is no such file")
        if hasattr(value, "_nodes"):
            return self._csv(value._nodes(), where)
        names = getattr(getattr(value, "dtype", None), "names", None)
        if names and _FILES[key]:
            return self._csv({name: value[name] for name in names}, where)
        if (isinstance(value, Mapping) or hasattr(value, "columns")) and _FILES[key]:
            return self._csv(value, where)
        if _FILES[key] != _ARRAY:
            wanted = " or ".join(filter(None, ["the path of a file", _FILES[key]]))
            raise InputError(f"{where}: must be {wanted}, found {type(value).__name__}")
        return self._array(np.asarray(value), where)

    def _array(self, array: np.ndarray[Any, Any], where: str) -> str:
        array = np.ascontiguousarray(numbers(where, array))
        if array.shape[1:] not in ((3,), (4, 3)):
            raise InputError(f"{where}: has shape {array.shape}: must be (n, 3), points, or (n, 4, 3), frames")
        bad = np.argwhere(~np.isfinite(array))
        if len(bad):
            index = tuple(int(k) for k in bad[0])
            raise InputError(f"{where}[{', '.join(map(str, index))}] = {array[index]}: must be finite")
        buffer = io.BytesIO()
        np.save(buffer, array)
        return self._file(where, "npy", buffer.getvalue())

    def _csv(self, table: Any, where: str) -> str:
        names = [str(name) for name in (table.columns if hasattr(table, "columns") else table)]
        columns = [np.atleast_1d(np.asarray(table[name])) for name in names]
        lengths = {name: len(column) for name, column in zip(names, columns, strict=True)}
        if len(set(lengths.values())) != 1:
            raise InputError(f"{where}: columns of unlike lengths: {lengths}")
        rows = [",".join(names)]
        for k in range(len(columns[0])):
            cells = (column[k].item() if isinstance(column[k], np.generic) else column[k] for column in columns)
            rows.append(",".join(repr(cell) if isinstance(cell, float) else str(cell) for cell in cells))
        return self._file(where, "csv", ("\n".join(rows) + "\n").encode())

    def _file(self, where: str, ending: str, content: bytes) -> str:
        stem = "".join(letter if letter.isalnum() else "_" for letter in where)
        name = f"{stem.strip('_')}.{ending}"
        self.files[name], self.arguments[name] = content, where
        return name


def check_count(argument: str, value: object, least: int = 1) -> None:
    """Refuses what is not a whole number of at least ``least``."""
    plain = value.item() if isinstance(value, np.generic) else value
    check(plain, {"type": "integer", "minimum": least}, argument)


def numbers(argument: str, value: ArrayLike) -> NDArray[np.float64]:
    """An array of numbers; refuses what is none."""
    try:
        return np.asarray(value, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise InputError(f"{argument}: must be an array of numbers: {error}") from error


def check(value: Any, rule: Table, where: str) -> None:
    """Refuses what the schema does not allow, with the argument and its value."""
    if "$ref" in rule:
        rule = {**schema()["$defs"][rule["$ref"].rsplit("/", 1)[1]], **{k: v for k, v in rule.items() if k != "$ref"}}
    if "oneOf" in rule:
        _check_kind(value, rule["oneOf"], where)
    elif "anyOf" in rule:
        _check_any(value, rule, where)
    elif "enum" in rule and value not in rule["enum"]:
        raise InputError(f"{where} = {value!r}: must be one of {', '.join(map(repr, rule['enum']))}")
    elif "const" in rule and value != rule["const"]:
        raise InputError(f"{where} = {value!r}: must be {rule['const']!r}")
    elif "type" in rule:
        _check_type(value, rule, where)


def _check_type(value: Any, rule: Table, where: str) -> None:
    kind = rule["type"]
    kinds: dict[str, Any] = {"string": str, "boolean": bool, "integer": int, "number": (int, float), "array": list, "object": dict}
    is_bool = isinstance(value, bool)
    if not isinstance(value, kinds[kind]) or (is_bool and kind in ("integer", "number")):
        form = rule.get("x-value")
        names = {"string": "a string", "boolean": "True or False", "integer": "an int", "number": "a number"}
        wanted = form or {**names, "array": "a list", "object": "a dict"}[kind]
        raise InputError(f"{where} = {value!r}: must be {wanted}, found {type(value).__name__}")
    if kind == "object":
        _check_keys(value, rule, where)
    elif kind == "array":
        low, high = rule.get("minItems", 0), rule.get("maxItems")
        if len(value) < low or (high is not None and len(value) > high):
            wanted = str(low) if low == high else f"{low} or more" if high is None else f"{low} to {high}"
            raise InputError(f"{where} = {value!r}: must have {wanted} entries, found {len(value)}")
        for k, entry in enumerate(value):
            check(entry, rule.get("items", {}), f"{where}[{k}]")
    elif kind in ("integer", "number"):
        _check_range(value, rule, where)


def _check_range(value: float, rule: Table, where: str) -> None:
    bounds: tuple[tuple[str, str, Callable[[float, float], bool]], ...] = (
        ("minimum", "at least", operator.ge),
        ("maximum", "at most", operator.le),
        ("exclusiveMinimum", "greater than", operator.gt),
        ("exclusiveMaximum", "less than", operator.lt),
    )
    if not all(test(value, rule[key]) for key, _, test in bounds if key in rule):
        wanted = " and ".join(f"{words} {rule[key]}" for key, words, _ in bounds if key in rule)
        unit = f" {rule['x-unit']}" if "x-unit" in rule else ""
        raise InputError(f"{where} = {value!r}: must be {wanted}{unit}")


def _check_keys(value: Table, rule: Table, where: str) -> None:
    known = rule.get("properties", {})
    for key, entry in value.items():
        inside = f"{where}.{key}" if where else key
        if key not in known and rule.get("additionalProperties") is False:
            near = difflib.get_close_matches(key, known, n=1)
            hint = f" (meant: {near[0]}?)" if near else ""
            raise InputError(f"{inside} = {entry!r}: there is no such key{hint}; there are {', '.join(known)}")
        check(entry, known.get(key, {}), inside)
    for key in rule.get("required", ()):
        if key not in value:
            raise InputError(f"{where}.{key}: missing")


def _check_kind(value: Any, rules: list[Table], where: str) -> None:
    """One of several tables, told apart by their ``kind``; or a word of several."""
    by_kind = {rule.get("properties", {}).get("kind", {}).get("const"): rule for rule in rules}
    if None not in by_kind and isinstance(value, dict) and "kind" in value:
        if value["kind"] not in by_kind:
            raise InputError(f"{where}.kind = {value['kind']!r}: must be one of {', '.join(map(repr, by_kind))}")
        check(value, by_kind[value["kind"]], where)
    elif None not in by_kind and isinstance(value, dict):
        raise InputError(f"{where}.kind: missing: must be one of {', '.join(map(repr, by_kind))}")
    else:
        _check_any(value, {"anyOf": rules}, where)


def _check_any(value: Any, rule: Table, where: str) -> None:
    """One of several forms; the reason is that of the form whose type fits."""
    reasons: list[InputError] = []
    for form in rule["anyOf"]:
        try:
            check(value, form, where)
        except InputError as error:
            reasons.append(error)
        else:
            return
    types = {"object": dict, "array": list}
    resolved = [schema()["$defs"][form["$ref"].rsplit("/", 1)[1]] if "$ref" in form else form for form in rule["anyOf"]]
    for form, reason in zip(resolved, reasons, strict=True):
        if isinstance(value, types.get(form.get("type", ""), ())):
            raise reason
    if "x-value" in rule:
        raise InputError(f"{where} = {value!r}: must be {rule['x-value'].replace('`', '')}")
    words = [form["const"] for form in resolved if "const" in form]
    words += [word for form in resolved for word in form.get("enum", ())]
    if words:
        raise InputError(f"{where} = {value!r}: must be one of {', '.join(map(repr, words))}")
    raise reasons[-1]
