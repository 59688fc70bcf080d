"""The documentation's site is built without network and loads nothing from elsewhere."""

from __future__ import annotations

import subprocess
import sys
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

import pytest

from vomstudio.ui.dialogs.help.help_pages import list_pages

ROOT = Path(__file__).resolve().parents[2]
LOADED = {"script": "src", "img": "src", "link": "href", "iframe": "src", "source": "src"}


class Links(HTMLParser):
    """What a page loads, and where it leads; the ids that can be led to."""

    def __init__(self, page: Path) -> None:
        super().__init__()
        self.loads: list[str] = []
        self.leads: list[str] = []
        self.ids: set[str] = set()
        self.feed(page.read_text("utf-8"))

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        found = {name: value or "" for name, value in attrs}
        if "id" in found:
            self.ids.add(found["id"])
        if (name := LOADED.get(tag)) and name in found:
            self.loads.append(found[name])
        if tag == "a" and "href" in found:
            self.leads.append(found["href"])


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("site")
    words = [sys.executable, "-m", "properdocs", "build", "--strict", "--site-dir", str(folder)]
    done = subprocess.run(words, cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return folder


def html(site: Path) -> list[Path]:
    # Nobody is led to the page of a missing page, whose links begin at the root of a server.
    return [page for page in sorted(site.rglob("*.html")) if page.name != "404.html"]


def test_every_page_of_the_documentation_is_in_the_site(site: Path) -> None:
    pages = {page.path.stem for page in list_pages(ROOT / "docs")}
    assert len(pages) > 9
    assert pages == {page.stem for page in html(site)}


def test_nothing_is_loaded_from_elsewhere(site: Path) -> None:
    outside = [
        (page.name, target)
        for page in html(site)
        for target in Links(page).loads
        if urlsplit(target).scheme or urlsplit(target).netloc
    ]
    assert outside == []
    styles = [path for path in site.rglob("*.css") if _imports_from_elsewhere(path)]
    assert styles == []


def _imports_from_elsewhere(style: Path) -> bool:
    text = style.read_text("utf-8").replace(" ", "")
    return any(word in text for word in ("url(http", 'url("http', "url('http", "url(//", "@import"))


def test_every_link_and_picture_of_site_resolves(site: Path) -> None:
    pages = {page.resolve(): Links(page) for page in html(site)}
    broken = []
    for page, links in pages.items():
        for target in (*links.loads, *links.leads):
            parts = urlsplit(target)
            if parts.scheme or parts.netloc:
                continue
            path = page if not parts.path else (page.parent / unquote(parts.path)).resolve()
            lost = parts.fragment and path in pages and parts.fragment not in pages[path].ids
            if not path.is_file() or lost:
                broken.append((page.name, target))
    assert broken == []
