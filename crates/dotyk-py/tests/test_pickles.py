"""Solutions out of pickles answer as those that were pickled, and solve nothing again."""

import multiprocessing
import operator
import os
import pickle
import shutil

import dotyk
import dotyk.examples
import numpy as np
import pytest


def rising(points, t):
    return 1e3 * (1 + points[:, 1]) * t


def pressed(function):
    m = dotyk.Model("plane-strain")
    ring = m.body("ring", dotyk.ring(1, 2, cells=[16, 2]), young=1e6, poisson=0.3)
    ring.fix("inner", x=0, y=0).load("outer", pressure=function)
    return m


def again(solution):
    return pickle.loads(pickle.dumps(solution))


def steady(text):
    """A summary or report without the lines of timings and memory."""
    drop = ("memory", '"total"', '"write"', "ms</td>", " s</td>")
    return [line for line in text.splitlines() if not any(word in line for word in drop)]


def same_files(first, second, tmp_path):
    one, two = first.write(tmp_path / "one"), second.write(tmp_path / "two")
    assert [os.path.basename(path) for path in one] == [os.path.basename(path) for path in two]
    for a, b in zip(one, two, strict=True):
        a, b = (open(path, "rb").read() for path in (a, b))
        if a.startswith((b"{", b"<!DOCTYPE")):
            a, b = (steady(text.decode()) for text in (a, b))
        assert a == b


def test_probes_lines_arrays_and_files_are_the_same(tmp_path):
    s = dotyk.examples.punch().solve(steps=[0.5, 1.0])
    t = again(again(s))
    for before, after in zip(s.steps, t.steps, strict=True):
        assert before.probe("punch.stress.yy", at=[2, 2]) == after.probe("punch.stress.yy", at=[2, 2])
        assert before.probe("sole.resultant.y") == after.probe("sole.resultant.y")
        lines = [step.probe("block.stress.yy", along="block.top") for step in (before, after)]
        assert all(np.array_equal(a, b) for a, b in zip(*lines, strict=True))
        assert np.array_equal(before.bodies["punch"].stress, after.bodies["punch"].stress)
        assert np.array_equal(before.contacts["sole"].gap, after.contacts["sole"].gap)
        assert before.history == after.history
    first = again(s.steps[0])
    assert first.probe("sole.resultant.y") == s.steps[0].probe("sole.resultant.y")
    assert t.bodies["block"].mesh.points.shape == s.bodies["block"].mesh.points.shape
    same_files(s, t, tmp_path)
    with pytest.raises(dotyk.InputError, match="unknown body or contact `punsh`"):
        t.probe("punsh.stress.yy", at=[2, 2])


def test_in_space_and_of_a_dual_problem(tmp_path):
    m = dotyk.examples.boxes()
    same_files(*(lambda s: (s, again(s)))(m.solve()), tmp_path)
    d = dotyk.examples.punch().dual()
    s = d.recover(*d.solve())
    assert again(s).probe("sole.resultant.y") == s.probe("sole.resultant.y")


def test_processes_return_whole_solutions():
    m = dotyk.examples.punch()
    s = m.solve(threads=1)
    for method in ("fork", "spawn"):
        if method in multiprocessing.get_all_start_methods():
            with multiprocessing.get_context(method).Pool(1) as pool:
                (t,) = pool.map(operator.methodcaller("solve", threads=1), [m])
            assert t.probe("punch.stress.yy", at=[2, 2]) == s.probe("punch.stress.yy", at=[2, 2])


def test_a_case_and_its_mesh_file_travel(tmp_path, monkeypatch):
    folder = tmp_path / "there"
    folder.mkdir()
    dotyk.rectangle([0, 0], [1, 1], cells=[2, 2], cell="quad8").to_meshio().write(folder / "m.vtu")
    (folder / "case.toml").write_text(
        'analysis = "plane-strain"\nparameters = { q = 1 }\n[[body]]\nname = "b"\nmesh = { file = { path = "m.vtu" } }\n'
        'material = { young = 1, poisson = 0 }\nfix = [{ point = [0, 0], x = 0, y = 0 }, { point = [1, 0], y = 0 }]\n'
        'load = [{ side = "boundary", pressure = "q" }]\n'
    )
    monkeypatch.chdir(tmp_path)
    s = dotyk.run("there/case.toml", parameters={"q": 2}, method="mprgp")
    pickled = pickle.dumps(s)
    shutil.rmtree(folder)
    t = pickle.loads(pickled)
    assert t.probe("b.stress.yy", at=[0.5, 0.5]) == s.probe("b.stress.yy", at=[0.5, 0.5]) == pytest.approx(-2)
    assert (t.case, t.parameters) == ("case", {"q": 2.0})


def test_functions_travel_where_they_can(tmp_path):
    s = pressed(rising).solve()
    t = again(s)
    assert t.probe("ring.stress.xx", at=[1.5, 0.1]) == s.probe("ring.stress.xx", at=[1.5, 0.1])
    same_files(s, t, tmp_path)
    s = pressed(lambda points, t: rising(points, t)).solve()
    t = again(again(s))
    assert np.array_equal(t.bodies["ring"].stress, s.bodies["ring"].stress) and steady(t.report()) == steady(s.report())
    why = "body `ring`, load on `outer`, pressure: the function <lambda> cannot be pickled"
    with pytest.raises(dotyk.InputError, match=f"{why}.*: probes are read before it is pickled"):
        t.probe("ring.stress.xx", at=[1.5, 0.1])
    with pytest.raises(dotyk.InputError, match=f"{why}.*: files are written before it is pickled"):
        t.write(tmp_path / "out")


def test_a_function_that_is_not_found_is_named(tmp_path, monkeypatch):
    pickled = pickle.dumps(pressed(rising).solve())
    monkeypatch.delitem(globals(), "rising")
    t = pickle.loads(pickled)
    assert t.converged and t.probe("ring.stress.xx", at=[1.5, 0.1]) < 0
    with pytest.raises(dotyk.InputError, match="the function rising of a pickled model is not found here"):
        t.write(tmp_path / "out")


def test_a_solution_of_another_version_is_refused_with_its_numbers_left():
    s = dotyk.examples.punch().solve()
    t = again(s)
    solutions, *rest = t._run._solutions
    t._run._solutions = (solutions.replace(dotyk.__version__.encode(), b"0.0.9", 1), *rest)
    assert t.converged and t.contacts["sole"].closed == 11
    with pytest.raises(dotyk.InputError, match=r"begin with `dotyk solutions 0.0.9`, and this version reads"):
        t.probe("sole.resultant.y")


def test_a_failed_step_stays_failed():
    with pytest.raises(dotyk.NotConverged) as caught:
        dotyk.examples.punch().solve(steps=[0.5, 1.0], method="gradient", max_iterations=2)
    s, t = caught.value.solution, again(caught.value).solution
    assert t.failed_step == s.failed_step is not None and len(t.steps) == len(s.steps) == 1
    assert t.probe("sole.resultant.y") == s.probe("sole.resultant.y")
    assert steady(t.report()) == steady(s.report())


def test_generated_meshes_keep_their_curves():
    pressures = []
    for copy in (lambda mesh: mesh, again):
        m = dotyk.Model("plane-strain")
        inner, outer = (dotyk.ring(a, a + 1, from_=0, to=90, cells=[n, 2]) for a, n in ((1, 7), (2, 10)))
        m.body("inner", copy(inner), young=1, poisson=0.3).fix("start", y=0).fix("end", x=0)
        m.body("outer", copy(outer), young=1, poisson=0.3).fix("start", y=0).fix("end", x=0).load("outer", pressure=1)
        s = m.contact("fit", nonmortar="inner.outer", mortar="outer.inner").solve()
        pressures.append(s.contacts["fit"].pressure)
    assert np.array_equal(*pressures)
    tube = dotyk.extrude(dotyk.ring(1, 1.2, from_=0, to=90, cells=[8, 2]), height=3, layers=2)
    assert np.array_equal(again(tube).points, tube.points) and again(tube).sides.keys() == tube.sides.keys()
