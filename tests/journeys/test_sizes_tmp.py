import pytest

from tests import driver
from vomstudio.paths import resource
from vomstudio.ui.interpret.facets_panel import FacetsPanel
from vomstudio.ui.interpret.fields_panel import FieldsPanel


@pytest.mark.parametrize("size", [(1280, 720), (1920, 1080)])
def test_look(window, size):
    window.resize(*size)
    window.open_path(resource("sample", "sample.obj"))
    driver.settled(window)
    window.actions_table.run("propose_facets")
    panel = window.findChild(FacetsPanel)
    driver.wait(panel.isVisible, "panel")
    driver.settled(window)
    driver.keep_picture(window, f"facets-empty-{size[0]}")
    driver.click(panel.start, panel.start.rect().center())
    driver.wait(lambda: panel._facets.found is not None, "the facets", 120.0)
    driver.pause(1500)
    driver.settled(window)
    driver.keep_picture(window, f"facets-{size[0]}")
    panel._facets.drop()
    window.actions_table.run("surface_fields")
    panel = window.findChild(FieldsPanel)
    driver.wait(panel.isVisible, "panel")
    for kind in ("dip_direction", "roughness", "curvature", "steepness"):
        panel.kind.setCurrentIndex(panel.kind.findData(kind))
        driver.pause(50)
        panel._show_rows()
        panel._start_or_stop()
        driver.wait(lambda: panel._fields.running is None, "done", 60)
        driver.pause(1500)
        driver.settled(window)
        driver.keep_picture(window, f"fields-{kind}-{size[0]}")
