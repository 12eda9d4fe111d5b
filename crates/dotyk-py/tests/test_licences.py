"""The installed package has its licence and those of what is compiled into it."""

from __future__ import annotations

import importlib.metadata
import re


def test_the_package_carries_its_licences():
    files = {str(path): path for path in importlib.metadata.files("dotyk") or ()}
    texts = {name.rsplit("/", 1)[1]: path.read_text() for name, path in files.items() if ".dist-info/licenses/" in name}
    assert set(texts) == {"LICENSE-MIT", "LICENSE-APACHE", "THIRD-PARTY.txt"}
    assert "Apache License" in texts["LICENSE-APACHE"] and "The dotyk developers" in texts["LICENSE-MIT"]
    # what is compiled into it, and not what only builds or tests it
    crates = set(re.findall(r"^(\S+) [0-9.]+\S*: ", texts["THIRD-PARTY.txt"], re.MULTILINE))
    assert {"faer", "pyo3", "numpy", "spade", "toml", "clap", "rayon"} <= crates
    assert not {"proptest", "paste", "syn", "dotyk"} & crates
    told = importlib.metadata.metadata("dotyk")
    assert told["License-Expression"] == "MIT OR Apache-2.0" and set(told.get_all("License-File")) == set(texts)
