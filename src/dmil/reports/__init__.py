"""What people see: figures, tables and one report per study."""

from dmil.reports.export import FORMATS, save_figure, specification
from dmil.reports.gallery import Figure, gallery
from dmil.reports.page import write_report

__all__ = ["FORMATS", "Figure", "gallery", "save_figure", "specification", "write_report"]
