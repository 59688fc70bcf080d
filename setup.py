"""What pyproject.toml cannot state.

resources/ and docs/ travel in the wheel as vomstudio/resources. A package index gets README.md
without the links and pictures that lead nowhere there.
"""

import re
import shutil
from pathlib import Path

from setuptools import setup
from setuptools.command.build_py import build_py

RELATIVE_LINK = re.compile(r"(!?)\[([^\]]*)\]\((?!https?://)[^)\s]+\)")


class BuildWithResources(build_py):
    """An editable installation uses the folders of the checkout; any other gets copies."""

    def run(self) -> None:
        super().run()
        if not self.editable_mode:
            target = Path(self.build_lib) / "vomstudio" / "resources"
            shutil.rmtree(target, ignore_errors=True)
            shutil.copytree("resources", target)
            shutil.copytree("docs", target / "docs")


def without_relative_links(text: str) -> str:
    """Return Markdown with the text of its relative links alone, and without relative pictures."""
    text = RELATIVE_LINK.sub(lambda link: "" if link[1] else link[2], text)
    return re.sub(r"\n{3,}", "\n\n", text)


setup(
    cmdclass={"build_py": BuildWithResources},
    long_description=without_relative_links(Path("README.md").read_text("utf-8")),
    long_description_content_type="text/markdown",
)
