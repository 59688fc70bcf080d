"""What pyproject.toml cannot say: resources/ travels in the wheel as vomstudio/resources, and docs/
with it, so that Help can show the pages."""

import shutil
from pathlib import Path

from setuptools import setup
from setuptools.command.build_py import build_py


class BuildWithResources(build_py):
    """An editable installation uses the folders of the checkout; any other gets copies."""

    def run(self) -> None:
        super().run()
        if not self.editable_mode:
            target = Path(self.build_lib) / "vomstudio" / "resources"
            shutil.rmtree(target, ignore_errors=True)
            shutil.copytree("resources", target)
            shutil.copytree("docs", target / "docs")


setup(cmdclass={"build_py": BuildWithResources})
