"""Settings of the book. `docs/build` runs Sphinx with them on a copy of this folder that has the generated pages too."""

import importlib.util
import sys
import tomllib
from pathlib import Path

from sphinx.errors import ConfigError

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE / "_ext"))

project = "dotyk"
author = "the authors of dotyk"
copyright = author
version = release = tomllib.loads((HERE / "Cargo.toml").read_text())["workspace"]["package"]["version"]

extensions = ["myst_nb", "sphinx.ext.autodoc", "mathml"]
exclude_patterns = ["requirements.txt"]
nitpicky = True
# types of other libraries, and those that are not public
nitpick_ignore_regex = [("py:.*", r"(?!dotyk).*"), ("py:.*", r"dotyk\._.*")]

myst_enable_extensions = ["dollarmath", "amsmath", "deflist", "colon_fence", "fieldlist"]
myst_heading_anchors = 3
myst_update_mathjax = False
html_math_renderer = "mathml"

html_theme = "furo"
html_title = "dotyk"
html_static_path = ["_static"]
html_css_files = ["book.css"]
html_show_sphinx = False
html_copy_source = False
pygments_style = "friendly"
highlight_language = "none"

# The module: its pages need it, and the tutorials are run.
WITHOUT = tags.has("without_python")  # noqa: F821, a name of Sphinx
if not WITHOUT and importlib.util.find_spec("dotyk") is None:
    raise ConfigError(
        "the module dotyk is not installed: `pip install ./crates/dotyk-py`, or build without it, with the tag without_python"
    )
nb_execution_mode = "off" if WITHOUT else "force"
nb_execution_raise_on_error = True
nb_execution_timeout = 300
nb_merge_streams = True
autodoc_member_order = "bysource"
autodoc_typehints = "signature"

API = """```{eval-rst}
.. automodule:: dotyk
   :members:
   :imported-members:

.. automodule:: dotyk.examples
   :members:
```"""
NOTE = """:::{note}
This copy of the book was built without the module: the reference is missing here, and the tutorials show no outputs.
:::"""


def with_api(app, docname, source):
    """What a page of the reference has in place of `@API@`."""
    source[0] = source[0].replace("@API@", NOTE if WITHOUT else API)


def setup(app):
    app.connect("source-read", with_api)
