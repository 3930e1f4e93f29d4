"""Hooks of mkdocs: pages generated from the code, and files of the repository outside docs/.

Pages in docs/ are also read in the repository, so their links to its files are relative. The hooks
keep links to files that the site shows, and replace other links by their text.
"""

import posixpath
import re
from pathlib import Path

from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files
from mkdocs.structure.pages import Page
from pygments.formatters import HtmlFormatter

from docs.site.pages import commands, licences, variables
from docs.site.paper_pages import published_claims, verdicts_page

ROOT = Path(__file__).parents[2]

#: Files of the repository that are pages of the site, and their paths there.
SITE_PAGES = {
    "README.md": "index.md",
    "config/README.md": "reference/studies.md",
    "CHANGELOG.md": "changelog.md",
    "CONTRIBUTING.md": "contributing.md",
    "benchmarks/verify/verify.md": "verify.md",
}

#: Targets of links in the repository, and the pages of the site that replace them.
LINK_TARGETS = SITE_PAGES | {
    "docs/site/pages.py": "reference/variables.md",
    "requirements.lock": "reference/licences.md",
    "results/published/paper_gallas/verdicts.csv": "verdicts.md",
    "results/published/paper_walton/verdicts.csv": "verdicts.md",
}

#: Pages generated from the code, and their functions.
GENERATED_PAGES = {
    "reference/commands.md": commands,
    "reference/licences.md": licences,
    "reference/variables.md": variables,
    "verdicts.md": lambda: verdicts_page(published_claims(ROOT / "results" / "published")),
}

#: Style sheet of the colours of code.
COLOURS = "site/colours.css"

#: Pattern of a link or picture in Markdown: text, target, anchor with its #.
LINK_PATTERN = re.compile(r"(!?\[(?:[^\[\]]|\[[^\]]*\])*\])\(([^)#\s:]*)(#[^)\s]*)?\)")

#: Pattern of a link or picture in a report, to a file beside it.
REPORT_LINK_PATTERN = re.compile(r'(?:href|src)="([^"#:]+)"')

#: Suffixes of files that are copied for the pages that show or link them.
COPIED_SUFFIXES = (".svg", ".png", ".gif", ".webp", ".html")


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Add the pages and pictures that do not lie in docs/."""
    for source, target in SITE_PAGES.items():
        files.append(File.generated(config, target, content=_text(ROOT / source)))
    for target, make in GENERATED_PAGES.items():
        files.append(File.generated(config, target, content=make()))
    files.append(
        File.generated(config, COLOURS, content=HtmlFormatter().get_style_defs(".codehilite"))
    )
    pages = [ROOT / source for source in SITE_PAGES] + sorted((ROOT / "docs").glob("*.md"))
    copied = {path for page in pages for path in _linked_files(page) if _is_copied(path)}
    reports = [path for path in copied if path.suffix == ".html"]
    copied |= {path for report in reports for path in _files_of_report(report)}
    for path in sorted(copied):
        target = path.relative_to(ROOT).as_posix()
        files.append(File.generated(config, target, abs_src_path=str(path)))
    return files


def on_page_markdown(markdown: str, page: Page, config: MkDocsConfig, files: Files) -> str:
    """Rewrite the links of a page for the site."""
    here = page.file.src_uri
    sources = {target: source for source, target in SITE_PAGES.items()}
    source = sources.get(here, f"docs/{here}")

    def relink(match: re.Match[str]) -> str:
        text, target, anchor = match.group(1), match.group(2), match.group(3) or ""
        if not target:
            return match.group(0)
        path = posixpath.normpath(posixpath.join(posixpath.dirname(source), target))
        destination = LINK_TARGETS.get(path, path.removeprefix("docs/"))
        if files.get_file_from_path(destination) is None:
            # The site does not show this file of the repository.
            return text[text.index("[") + 1 : -1]
        return f"{text}({posixpath.relpath(destination, posixpath.dirname(here) or '.')}{anchor})"

    return LINK_PATTERN.sub(relink, markdown)


def _linked_files(page: Path) -> set[Path]:
    """Return the files that a page of the repository links or shows."""
    targets = (match.group(2) for match in LINK_PATTERN.finditer(_text(page)))
    return {(page.parent / target).resolve() for target in targets if target}


def _files_of_report(report: Path) -> set[Path]:
    """Return the files beside a report that it shows or links."""
    paths = {report.parent / target for target in REPORT_LINK_PATTERN.findall(_text(report))}
    return {path for path in paths if path.is_file()}


def _is_copied(path: Path) -> bool:
    outside = ROOT in path.parents and ROOT / "docs" not in path.parents
    return outside and path.suffix in COPIED_SUFFIXES and path.is_file()


def _text(path: Path) -> str:
    return path.read_text(encoding="utf-8")
