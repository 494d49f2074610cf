"""Configuration of Sphinx for the documentation site. docs/build.sh copies it into the sources."""

import sphinx.application

project = "Procgen Server"
author = "The authors of Procgen Server"
project_copyright = author
html_title = project

extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon"]
root_doc = "index"
source_suffix = {".md": "markdown", ".rst": "restructuredtext"}
exclude_patterns = ["_build"]
highlight_language = "text"

# Anchors of headings as on GitHub, so that links of the repository work on the site.
myst_heading_anchors = 4
myst_enable_extensions = ["colon_fence"]

# Docstrings mark code with one or two backticks.
default_role = "literal"
smartquotes = False
napoleon_use_ivar = True
autodoc_member_order = "bysource"
autodoc_typehints = "signature"
autodoc_default_options = {"members": True, "show-inheritance": True}

html_theme = "furo"
html_theme_options = {"navigation_with_keys": True}
html_static_path = ["_site"]
html_css_files = ["site.css"]
html_copy_source = False
html_show_sphinx = False


def _escape_shapes(_app, _what, _name, _object, _options, lines: list[str]) -> None:
    """The star of a shape such as [n, *F] begins no emphasis."""
    lines[:] = [line.replace(", *", ", \\*") for line in lines]


def setup(app: sphinx.application.Sphinx) -> None:
    """Sphinx calls this."""
    app.connect("autodoc-process-docstring", _escape_shapes)
