"""A notebook that is run as a user runs it: in a kernel of its own, with what it shows kept."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import nbformat
import pytest
from nbclient import NotebookClient
from nbclient.exceptions import CellExecutionError

from vomstudio.core.findings import Finding

CELLS = (
    "import pandas\nimport vomstudio as vs\n"
    "picks = pandas.read_csv(vs.sample('picks.csv'), comment='#')",
    "bed = vs.fit_plane(picks.loc[picks['pick'] == 'B01', ['x', 'y', 'z']])\nbed",
    "planes = vs.fit_planes(picks, by='pick')\nplanes.head(2)",
    "vs.fold(planes[planes['id'].str.startswith('B')])",
    "%matplotlib inline\nax = vs.stereonet(planes)",
    "project = vs.Project.create('cliff.vom')\n"
    "model = project.add_model(vs.sample('sample.obj'))\n"
    "project.add_trace(picks.loc[picks['pick'] == 'B01', ['x', 'y', 'z']], model=model,\n"
    "                  type='bedding')\nproject",
    "project.save()\nproject.close()\nproject",
)


def run(cells: tuple[str, ...], folder: Path) -> Any:
    notebook = nbformat.v4.new_notebook(cells=[nbformat.v4.new_code_cell(cell) for cell in cells])
    client = NotebookClient(
        notebook, timeout=180, kernel_name="python3", resources={"metadata": {"path": str(folder)}}
    )
    return client.execute()


def shown(cell: Any, kind: str) -> str:
    return "".join(out["data"].get(kind, "") for out in cell["outputs"] if "data" in out)


@pytest.fixture
def folder(tmp_path: Path, own_folders: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    # The kernel finds the package of this checkout, and keeps its own files away.
    root = Path(__file__).resolve().parents[2]
    monkeypatch.setenv("PYTHONPATH", str(root))
    monkeypatch.setenv("IPYTHONDIR", str(tmp_path / "ipython"))
    monkeypatch.setenv("JUPYTER_RUNTIME_DIR", str(tmp_path / "runtime"))
    return tmp_path


@pytest.mark.full
@pytest.mark.filterwarnings("ignore::DeprecationWarning", "ignore::ResourceWarning")
def test_a_notebook_runs_and_shows_its_objects(folder: Path) -> None:
    notebook = run(CELLS, folder)
    cells = notebook["cells"]
    assert "max_confidence95_deg" in shown(cells[1], "text/html")
    assert "dip_direction_deg" in shown(cells[2], "text/html")
    assert "beta.trend_deg" in shown(cells[3], "text/html")
    assert shown(cells[4], "image/png")
    assert "unsaved changes" in shown(cells[5], "text/html")
    assert "closed" in shown(cells[6], "text/html")
    assert (folder / "cliff.vom" / "journal.sqlite").is_file()


@pytest.mark.filterwarnings("ignore::DeprecationWarning", "ignore::ResourceWarning")
def test_notebook_error_shows_program_message(folder: Path) -> None:
    cells = ("import vomstudio as vs", "vs.fit_plane([[0, 0, 0], [1, float('nan'), 0]])")
    with pytest.raises(CellExecutionError) as error:
        run(cells, folder)
    assert error.value.ename == "InputError"
    finding = Finding("array.not-finite", count=1, first_row=1)
    assert error.value.evalue == f"points: {finding}"
