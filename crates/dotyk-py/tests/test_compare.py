"""Two solutions side by side."""

import math
import pickle
import re

import dotyk
import dotyk.examples
import pytest


def block(width: float, probe: bool = True) -> dotyk.Solution:
    m = dotyk.Model("plane-strain")
    cells = dotyk.rectangle([0, 0], [width, 1], cells=[4, 2])
    body = m.body("block", cells, young=1e3, poisson=0).fix("bottom", y=0).fix(point=[0, 0], x=0)
    body.load("top", pressure=2.0)
    if probe:
        m.probe("top", "block.displacement.y", at=[0.5, 1])
        m.probe("along", "block.displacement.y", along="block.left")
    return m.solve()


def test_numbers_of_both_by_name() -> None:
    both = dotyk.compare(block(2), block(3))
    rows = {row.what: row for row in both}
    assert len(rows) == len(both) and list(both) == both[:]
    assert math.isclose(rows["top"].first, -2e-3) and math.isclose(rows["top"].second, -2e-3)
    assert rows["block.reaction.x"].first == 0.0  # rounding is none
    assert math.isclose(rows["block.reaction.y"].difference, 2.0)
    assert math.isclose(rows["block.reaction.y"].relative, 0.5)
    assert math.isclose(rows["along.smallest"].first, -2e-3) and rows["along.largest"].first == 0.0


def test_what_one_of_them_lacks_is_not_a_number() -> None:
    rows = {row.what: row for row in dotyk.compare(block(2, probe=False), block(2))}
    assert math.isnan(rows["top"].first) and math.isclose(rows["top"].second, -2e-3)
    assert math.isnan(rows["top"].difference)
    assert rows["block.max_displacement"].difference == 0.0


def test_a_page_shows_both_with_names_of_their_own() -> None:
    first = dotyk.examples.punch().solve()
    second = pickle.loads(pickle.dumps(first))
    page = dotyk.compare(first, second).report()
    ids = re.findall(r'\bid="([^"]*)"', page)
    assert ids and len(ids) == len(set(ids))
    for name in re.findall(r"url\(#([^)]*)\)", page):
        assert name in ids
    assert "script" not in page and "default-src 'none'" in page


def test_buttons_over_steps_are_those_of_one_solution() -> None:
    m = dotyk.Model("plane-strain")
    cells = dotyk.rectangle([0, 0], [2, 1], cells=[4, 2])
    m.body("block", cells, young=1e3, poisson=0).fix("bottom", x=0, y=0).load("top", pressure="t")
    s = m.solve(steps=[1, 2, 3])
    groups = set(re.findall(r'<input[^>]*name="([^"]*)"', dotyk.compare(s, s).report()))
    assert {group.split("-")[0] for group in groups} == {"first", "second"}


def test_what_turns_is_left_out_in_space() -> None:
    m = dotyk.Model("3d")
    m.body("block", dotyk.box([0, 0, 0], [1, 1, 1], cells=[2, 2, 2]), young=1e3, poisson=0).fix("bottom", x=0, y=0, z=0)
    s = m.solve()
    page = dotyk.compare(s, s).report()
    assert "<script" not in page and "View that turns" not in page and "Deformed shape" in page


def test_a_page_is_written(tmp_path) -> None:  # type: ignore[no-untyped-def]
    both = dotyk.compare(block(2), block(3))
    path = tmp_path / "both.html"
    page = both.report(path)
    assert path.read_text(encoding="utf-8") == page
    with pytest.raises(dotyk.InputError, match="cannot write"):
        both.report(tmp_path / "no" / "both.html")


def test_only_solutions_are_compared() -> None:
    with pytest.raises(TypeError, match="two solutions"):
        dotyk.compare(block(2), 3.0)  # type: ignore[arg-type]


def test_a_section_of_several_bodies_and_displacements_from_a_step() -> None:
    m = dotyk.Model("plane-stress")
    m.step(1.0).step(2.0, zero_displacements=True)
    left = m.body("left", dotyk.rectangle([0, 0], [2, 0.5], cells=[8, 2]), young=1e5, poisson=0.2)
    right = m.body("right", dotyk.rectangle([2, 0], [4, 0.5], cells=[6, 2]), young=1e5, poisson=0.2)
    left.fix("left", x=0, y=0)
    right.load("right", traction=["3*t", 0])
    m.contact("joint", sides=["left.right", "right.left"], tied=True)
    m.section("beam", bodies=[left, "right"], sides=["top", "bottom"], stations=5)
    m.probe("weighed", "beam.N", factor="2*x", reduce="max")
    s = m.solve()
    assert s.displacements_from == 1.0 and not hasattr(s.steps[0], "displacements_from")
    assert all(math.isclose(station["N"], 3.0) for station in s.sections["beam"].stations)
    assert math.isclose(s.probes["weighed"], 24.0)
    assert math.isclose(s.probe("right.stress.xx", at=[3, 0.25], factor=0.5), 3.0, rel_tol=1e-6)
    end = s.bodies["right"].points[:, 0] == 4.0
    first = s.steps[0].bodies["right"].displacement[end]
    assert abs(s.bodies["right"].displacement[end] - first).max() < 1e-12
