# Sphinx's settings for the pages that pages.py gathers.
project = "clsdf"
author = "the authors of clsdf"
copyright = "the authors of clsdf, MIT licence"
extensions = ["myst_parser", "sphinx_design", "sphinx_copybutton"]
exclude_patterns = ["_static"]
source_suffix = {".md": "markdown"}
# Anchors as GitHub makes them, which the pages use.
myst_heading_anchors = 5
myst_enable_extensions = ["colon_fence"]
html_theme = "furo"
html_title = "clsdf"
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_extra_path = ["_extra"]
html_theme_options = {"navigation_with_keys": False, "top_of_page_buttons": []}
html_show_sphinx = False
html_copy_source = True
html_show_sourcelink = False
html_sourcelink_suffix = ""
copybutton_prompt_text = r"\$ |>>> "
copybutton_prompt_is_regexp = True
highlight_language = "none"
