"""What MkDocs calls while it builds the site: the reference from the code, and the documents of the top folder."""

import re
from typing import Any

from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files
from mkdocs.structure.pages import Page

from reference_pages import DETAILS, ROOT, SITE

TOP = {"README.md": "index.md", "ARCHITECTURE.md": "architecture.md"}
"""Documents of the top folder, and their names in the site."""


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Add the documents of the top folder, with links that hold in the site."""
    for source, name in TOP.items():
        text = (ROOT / source).read_text(encoding="utf-8")
        files.append(File.generated(config, name, content=in_the_site(text)))
    return files


def in_the_site(text: str) -> str:
    """Return a document of the top folder with its links as the site has them; files that it lacks are named."""
    text = text.replace("](docs/", "](")
    for source, name in TOP.items():
        text = text.replace(f"]({source})", f"]({name})")
    return re.sub(r"\[([^]]*)\]\(([A-Z]+\.md)\)", r"\1 (`\2`)", text)


def on_page_markdown(markdown: str, page: Page, **_: Any) -> str:
    """Put the details of a reference page in their place."""
    details = SITE.get(page.file.src_uri)
    return markdown.replace(DETAILS.strip(), details()) if details else markdown
