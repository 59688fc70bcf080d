"""Tool that marks the cells of a grid."""

from vomstudio.studio.tools.cells.tool import TOOL, CellsTool

__all__ = ["TOOL", "CellsTool"]
