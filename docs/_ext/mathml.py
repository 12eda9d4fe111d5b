"""Formulas as MathML, made when the book is built: pages need no script and no network."""

from html import escape

from docutils.nodes import SkipNode
from latex2mathml.converter import convert
from sphinx.util import logging

logger = logging.getLogger(__name__)


def mathml(latex, display, node):
    """The formula as MathML; the text itself, with a warning, where it cannot be read."""
    try:
        return convert(latex, display=display)
    except Exception as error:  # the converter has no common kind of error
        logger.warning("formula %r: %s", latex, error, location=node)
        return f"<code>{escape(latex)}</code>"


def visit_inline(self, node):
    self.body.append(mathml(node.astext(), "inline", node))
    raise SkipNode


def visit_block(self, node):
    identifier = f' id="{node["ids"][0]}"' if node.get("ids") else ""
    self.body.append(f'<div class="formula"{identifier}>')
    self.body.append(mathml(node.astext(), "block", node))
    if node.get("number"):
        self.body.append(f'<span class="number">({node["number"]})</span>')
    self.body.append("</div>\n")
    raise SkipNode


def setup(app):
    app.add_html_math_renderer("mathml", (visit_inline, None), (visit_block, None))
    return {"parallel_read_safe": True, "parallel_write_safe": True}
