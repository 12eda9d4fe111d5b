"""Every key of the case file has its call or keyword."""

from __future__ import annotations

import inspect
from functools import cached_property

import pytest

import dotyk
import dotyk.examples
from dotyk import _dotyk
from dotyk._words import keyword_of

#: Keys by table; of two with one name the first, that of a mesh or of a body.
KEYS = dict(reversed(_dotyk.keys()))

#: Keys of members, by their lists.
MEMBERS = {key: keys for key, _, keys in _dotyk.members()}

#: Tables of the case file and the call whose keywords are their keys; keys that a call has elsewhere, with the place.
CALLS = {
    "body": (dotyk.Model.body, {}),
    "material": (dotyk.Model.body, {"group": "in `material`, a list"}),
    "contact": (dotyk.Model.contact, {}),
    "section": (dotyk.Model.section, {}),
    "probe": (dotyk.Model.probe, {}),
    "step": (dotyk.Model.step, {}),
    "fix": (dotyk.Body.fix, {}),
    "load": (dotyk.Body.load, {}),
    "spring": (dotyk.Body.spring, {}),
    "couple": (dotyk.Body.couple, {}),
    "solver": (dotyk.Model.solve, {"bolt": "in the case file, for the method of the paper"}),
    "rectangle": (dotyk.rectangle, {}),
    "ring": (dotyk.ring, {}),
    "tunnel_rock": (dotyk.tunnel_rock, {}),
    "box": (dotyk.box, {}),
    "cylinder": (dotyk.cylinder, {}),
    "sphere": (dotyk.sphere, {}),
    "extrude": (dotyk.extrude, {}),
    "case": (
        dotyk.Model.__init__,
        {key: "a call" for key in ("body", "contact", "section", *MEMBERS, "step", "probe", "solver")},
    ),
}


@pytest.mark.parametrize("table", CALLS)
def test_every_key_has_its_keyword(table):
    call, elsewhere = CALLS[table]
    known = inspect.signature(call).parameters
    missing = [key for key in KEYS[table] if keyword_of(key) not in known and key not in elsewhere]
    assert missing == []


@pytest.mark.parametrize("kind", MEMBERS)
def test_every_key_of_a_member_has_its_keyword(kind):
    known = inspect.signature(getattr(dotyk.Model, kind)).parameters
    assert [key for key in MEMBERS[kind] if keyword_of(key) not in known] == []


def test_calls_for_lists_of_the_case_have_their_names():
    for key in ("body", "contact", "section", *MEMBERS, "step", "probe"):
        assert callable(getattr(dotyk.Model, key))
    for key in ("fix", "load", "spring", "couple", "body_force", "initial_stress", "initial_strain", "surface", "points"):
        assert callable(getattr(dotyk.Body, key))


def public():
    """Names and what they name: functions and classes, and the methods and properties of those."""
    for module in (dotyk, dotyk.examples):
        for name in module.__all__:
            thing = getattr(module, name)
            if isinstance(thing, str):
                continue
            yield name, thing
            for own, member in vars(thing).items() if inspect.isclass(thing) else ():
                member = getattr(member, "__func__", member)
                if not own.startswith("_") and (inspect.isfunction(member) or isinstance(member, (property, cached_property))):
                    yield f"{name}.{own}", member


def test_what_is_public_is_documented_with_an_example():
    names = dict(public())
    assert len(names) > 100
    assert [name for name, thing in names.items() if ">>>" not in (thing.__doc__ or "")] == []


def test_words_of_python_may_be_given_without_their_underscore():
    a = dotyk.rectangle(**{"from": [0, 0], "to": [1, 1], "cells": [1, 1]})
    b = dotyk.rectangle(from_=[0, 0], to=[1, 1], cells=[1, 1])
    assert (a.points == b.points).all()
