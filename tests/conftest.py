"""What every test may ask for."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path

import pytest
from hypothesis import settings

from tests.guards import (  # noqa: F401 - hooks: what a test leaves behind fails it
    pytest_collection_finish,
    pytest_runtest_call,
    pytest_runtest_setup,
    pytest_runtest_teardown,
)
from tests.kernel_cache import share_kernel_cache
from tests.tiers import (  # noqa: F401 - hooks: the processor time of each test
    pytest_configure,
    pytest_runtest_makereport,
    pytest_runtest_protocol,
    pytest_sessionfinish,
    pytest_sessionstart,
    pytest_terminal_summary,
)

share_kernel_cache()

# No test fails because the machine is busy with something else.
settings.register_profile("patient", deadline=None)
settings.load_profile("patient")

ROOT = Path(__file__).resolve().parents[1]


@pytest.fixture(scope="session")
def data_dir() -> Path:
    """The folder of real data, which is not part of the project."""
    folder = Path(os.environ.get("VOMSTUDIO_DATA", ROOT.parent / "shared" / "data"))
    if not folder.is_dir():
        pytest.skip(f"real data not found at {folder}; set VOMSTUDIO_DATA")
    return folder


@pytest.fixture(scope="session", autouse=True)
def state_folder(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """Where logs and traces of crashes go, in place of the user's own, those of processes too."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("XDG_STATE_HOME", str(tmp_path_factory.mktemp("state")))
        yield


@pytest.fixture(scope="session", autouse=True)
def no_progress() -> Iterator[None]:
    """Keep stderr of slow commands free of progress, which tests of progress turn on."""
    from vomstudio.cli.common.reporting import DELAY_VARIABLE

    with pytest.MonkeyPatch.context() as patch:
        patch.setenv(DELAY_VARIABLE, "86400")
        yield


def use_home(home: Path, patch: pytest.MonkeyPatch) -> Path:
    """Give the process state, configuration and settings of a user who has just come."""
    for name in ("XDG_STATE_HOME", "XDG_CONFIG_HOME", "XDG_CACHE_HOME", "XDG_DATA_HOME"):
        patch.setenv(name, str(home / name.lower()))
    patch.setenv("VOMSTUDIO_SETTINGS", str(home / "settings.toml"))
    home.mkdir()
    return home


@pytest.fixture
def own_folders(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The home folder of a user who has just come."""
    return use_home(tmp_path / "user", monkeypatch)


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    # QImage.mirrored is deprecated since Qt 6.13; its successor is missing from the oldest Qt.
    for item in items:
        item.add_marker(pytest.mark.filterwarnings("ignore:.*QImage.mirrored:DeprecationWarning"))


@pytest.fixture(autouse=True)
def image_folder(tmp_path_factory: pytest.TempPathFactory, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Where images from inside of models go, in place of the user's own cache."""
    from vomstudio.io.models import image_store

    folder = tmp_path_factory.getbasetemp() / "images"
    monkeypatch.setattr(image_store, "folder", lambda: folder)
    return folder
