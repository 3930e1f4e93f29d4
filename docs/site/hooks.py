"""What mkdocs does besides: pages made from the code, and files that lie beside docs/.

The pages in docs/ are read in the repository, too, so they name other files of it relative to
themselves. Those that the site shows are linked; of others the name stays.
"""

import posixpath
import re
from pathlib import Path

from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files
from mkdocs.structure.pages import Page
from pygments.formatters import HtmlFormatter

from docs.site.pages import commands, variables

ROOT = Path(__file__).parents[2]

#: Files of the repository that are pages of the site, and where.
SHOWN = {
    "README.md": "index.md",
    "config/README.md": "reference/studies.md",
    "CHANGELOG.md": "changelog.md",
    "CONTRIBUTING.md": "contributing.md",
}

#: What makes pages, as pages of the repository name it, and the page that is meant.
MEANT = SHOWN | {"docs/site/pages.py": "reference/variables.md"}

#: Pages made from the code.
MADE = {"reference/commands.md": commands, "reference/variables.md": variables}

#: Style sheet of the colours of code.
COLOURS = "site/colours.css"

#: A link or picture of Markdown: its text, its target, what follows a #.
LINK = re.compile(r"(!?\[(?:[^\[\]]|\[[^\]]*\])*\])\(([^)#\s:]*)(#[^)\s]*)?\)")

#: Kinds of files that are copied beside the pages that show or link them.
COPIED = (".svg", ".png", ".gif", ".webp", ".html")


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Add the pages and pictures that do not lie in docs/."""
    for source, target in SHOWN.items():
        files.append(File.generated(config, target, content=_text(ROOT / source)))
    for target, make in MADE.items():
        files.append(File.generated(config, target, content=make()))
    files.append(
        File.generated(config, COLOURS, content=HtmlFormatter().get_style_defs(".codehilite"))
    )
    pages = [ROOT / source for source in SHOWN] + sorted((ROOT / "docs").glob("*.md"))
    copied = {linked for page in pages for linked in _linked(page) if _is_copied(linked)}
    for path in sorted(copied):
        target = path.relative_to(ROOT).as_posix()
        files.append(File.generated(config, target, abs_src_path=str(path)))
    return files


def on_page_markdown(markdown: str, page: Page, config: MkDocsConfig, files: Files) -> str:
    """Lead links to where things are on the site."""
    here = page.file.src_uri
    back = {target: source for source, target in SHOWN.items()}
    source = back.get(here, f"docs/{here}")

    def led(match: re.Match[str]) -> str:
        text, target, anchor = match.group(1), match.group(2), match.group(3) or ""
        if not target:
            return match.group(0)
        path = posixpath.normpath(posixpath.join(posixpath.dirname(source), target))
        there = MEANT.get(path, path.removeprefix("docs/"))
        if files.get_file_from_path(there) is None:
            # A file of the repository that is no part of the site.
            return text[text.index("[") + 1 : -1]
        return f"{text}({posixpath.relpath(there, posixpath.dirname(here) or '.')}{anchor})"

    return LINK.sub(led, markdown)


def _linked(page: Path) -> set[Path]:
    """Return the files that a page of the repository links or shows."""
    targets = (match.group(2) for match in LINK.finditer(_text(page)))
    return {(page.parent / target).resolve() for target in targets if target}


def _is_copied(path: Path) -> bool:
    outside = ROOT in path.parents and ROOT / "docs" not in path.parents
    return outside and path.suffix in COPIED and path.is_file()


def _text(path: Path) -> str:
    return path.read_text(encoding="utf-8")
