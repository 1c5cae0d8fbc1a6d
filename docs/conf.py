"""Configuration of the documentation site; build it with `make docs`."""

import mpma_mj

project = "mpma-mj"
author = "The mpma-mj developers"
copyright = f"2026, {author}"
release = version = mpma_mj.__version__

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "sphinx.ext.viewcode",
]
exclude_patterns = ["_build"]

html_theme = "furo"
html_title = "mpma-mj"
html_static_path = ["_static"]
html_css_files = ["tables.css"]

myst_enable_extensions = ["colon_fence"]
myst_heading_anchors = 3

autodoc_member_order = "bysource"
autodoc_typehints = "none"  # docstrings give shapes and units, which types do not
napoleon_google_docstring = True
napoleon_numpy_docstring = False
napoleon_use_ivar = True


def show_equations(app, what, name, obj, options, lines):
    """Show indented equations of docstrings as they stand."""
    for number in reversed(range(1, len(lines))):
        line, blank = lines[number], not lines[number - 1].strip()
        above = next((one for one in reversed(lines[:number]) if one.strip()), "")
        if line.startswith("    ") and blank and not above.startswith(" ") and above:
            lines[number:number] = ["::", ""]


def setup(app):
    """Connect before Napoleon, which rewrites the sections of a docstring."""
    app.connect("autodoc-process-docstring", show_equations, priority=100)
