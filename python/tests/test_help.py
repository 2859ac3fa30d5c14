"""``help()`` of every public thing: what it is, the shapes and units of its arrays, what its arguments are, what it raises."""

import dataclasses
import inspect
import re
from collections.abc import Iterator
from typing import Any

import pytest

import supercoil
from supercoil import contact, dna

#: Shape of an array as texts have it: (n, 3), (c,).
SHAPE = re.compile(r"\((?:[a-z]|\d+),(?: (?:[a-z]|\d+)(?:, (?:[a-z]|\d+))*)?\)")
#: A unit: [L], [F·L], [1/L], [nm], Å, s, K, or that there is none.
UNIT = re.compile(r"\[(?:1|[LFT]|nm|pN|rad|turns?|K|s\b|Å|a unit|column)|\bturns?\b|\brad\b|degrees|integer|[Uu]nits?\b|\bunit\b|B/L⁴|in the scene's units|dict of arrays")


def public() -> Iterator[tuple[str, Any]]:
    """Every public thing with its name: classes with their methods and properties, functions."""
    names = [(name, getattr(supercoil, name)) for name in supercoil.__all__ if name not in ("__version__", "contact", "dna")]
    names += [(f"contact.{name}", getattr(contact, name)) for name in contact.__all__]
    names += [(f"dna.{name}", getattr(dna, name)) for name in dna.__all__]
    for name, thing in names:
        yield name, thing
        for member in vars(thing) if inspect.isclass(thing) else ():
            # what a dict or an exception brings along has its help from Python
            if not member.startswith("_") and member not in getattr(thing, "__dataclass_fields__", {}):
                yield f"{name}.{member}", inspect.getattr_static(thing, member)


THINGS = dict(public())


def function(thing: Any) -> Any:
    """The function of a method or property; None of a class."""
    if isinstance(thing, (classmethod, staticmethod)):
        return thing.__func__
    if isinstance(thing, property):
        return thing.fget
    return getattr(thing, "func", thing) if not inspect.isclass(thing) else None


def test_these_are_all() -> None:
    for name in ("Scene.run", "State.positions", "Result.export", "Solver.step_to", "contact.detect", "sweep", "SweepPlan.only"):
        assert name in THINGS
    assert len(THINGS) > 90


@pytest.mark.parametrize("name", THINGS)
def test_help_says_what_it_is(name: str) -> None:
    text = inspect.getdoc(THINGS[name]) or ""
    # a dataclass without a text of its own would have its signature
    assert len(text) > 20 and text[0].isupper() or text[:1] in "(\"`" and len(text) > 20, text
    assert not text.startswith(f"{name}(")


@pytest.mark.parametrize("name", [name for name, thing in THINGS.items() if function(thing)])
def test_help_has_shapes_units_arguments_and_errors(name: str) -> None:
    thing = THINGS[name]
    made, text = function(thing), inspect.getdoc(thing) or ""
    result = str(inspect.signature(made).return_annotation)
    if re.search(r"Floats|NDArray", result):
        assert SHAPE.search(text) or "dict of arrays" in text, f"no shape: {text}"
    if re.search(r"Floats|NDArray|float", result):
        assert UNIT.search(text), f"no unit: {text}"
    arguments = [argument for argument in inspect.signature(made).parameters if argument not in ("self", "cls")]
    of_stage = set(inspect.signature(supercoil.Stage).parameters) if "Stage" in text else set()
    for argument in set(arguments) - of_stage:
        assert re.search(rf"\b{argument}\b", text), f"no {argument}: {text}"
    if arguments:
        assert re.search(r"Raises|InputError|never fails|Never fails", text), f"no errors: {text}"


@pytest.mark.parametrize("name", [name for name, thing in THINGS.items() if dataclasses.is_dataclass(thing)])
def test_fields_are_explained(name: str) -> None:
    """Fields are in the text of the class, or have a comment of their own beside them."""
    thing = THINGS[name]
    text, source = inspect.getdoc(thing) or "", inspect.getsource(thing)
    for field in dataclasses.fields(thing):
        is_commented = re.search(rf"#: .*\n(?:    #: .*\n)*    {field.name}:", source)
        assert is_commented or re.search(rf"\b{field.name}\b", text), f"{name}.{field.name}"
