"""Reports of imports: lines for a terminal, whatever names the file has."""

from mpma_mj.motions import ymca
from mpma_mj.motions.import_report import ImportReport


def test_names_of_markers_are_printed_with_escapes() -> None:
    groups = {"left_wrist": ("LWR\x1b[31m", "two\nlines")}
    report = ImportReport(groups=groups, frames=2, rate=20.0)
    line = next(line for line in report.lines(ymca()) if "left_wrist" in line)
    assert line.split() == ["left_wrist", r"LWR\x1b[31m", "+", r"two\nlines"]
