"""A forked process has no thread of its parent: it must not wait for one."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

PROGRAM = """
import os, sys
import dotyk

def model(q):
    m = dotyk.Model("plane-strain")
    block = m.body("b", dotyk.rectangle([0, 0], [1, 1], cells=[4, 4]), young=1.0, poisson=0.3)
    block.fix("bottom", x=0, y=0).load("top", traction=[0, -q])
    return m

case, first = sys.argv[1:]
before = {
    "solve": lambda: model(1e-3).solve(),
    "one": lambda: model(1e-3).solve(threads=1),
    "check": lambda: dotyk.check(case),
    "run": lambda: dotyk.run(case, threads=1),
    "study": lambda: dotyk.study(case, vary={"q": [1e-3, 2e-3]}),
    "report": lambda: model(1e-3).solve()._repr_html_(),
    "dual": lambda: dotyk.Model.from_case(case).dual(),
}
before[first]()
child = os.fork()
if child == 0:
    good = all(work() is not None for work in before.values())
    os._exit(0 if good else 1)
_, status = os.waitpid(child, 0)
sys.exit(os.waitstatus_to_exitcode(status))
"""

CASE = """
analysis = "plane-strain"
parameters = { q = 1e-3 }
[[body]]
name = "b"
mesh = { rectangle = { from = [0, 0], to = [1, 1], cells = [4, 4] } }
material = { young = 1, poisson = 0.3 }
fix = [{ side = "bottom", x = 0, y = 0 }]
load = [{ side = "top", traction = [0, "-q"] }]
[[body]]
name = "punch"
mesh = { rectangle = { from = [0, 1], to = [1, 2], cells = [4, 4] } }
material = { young = 1, poisson = 0.3 }
fix = [{ side = "left", x = 0 }]
load = [{ side = "top", traction = [0, "-q"] }]
[[contact]]
name = "c"
sides = ["punch.bottom", "b.top"]
[[probe]]
name = "p"
quantity = "c.pressure"
reduce = "max"
"""


@pytest.mark.skipif(not hasattr(os, "fork"), reason="no fork here")
@pytest.mark.parametrize("first", ["solve", "one", "check", "run", "study", "report", "dual"])
def test_a_forked_process_solves(tmp_path: Path, first: str) -> None:
    case = tmp_path / "case.toml"
    case.write_text(CASE)
    program = [sys.executable, "-c", PROGRAM, str(case), first]
    ended = subprocess.run(program, cwd=tmp_path, timeout=60, capture_output=True, text=True, check=False)
    assert ended.returncode == 0, ended.stderr
