"""A run in a notebook shows its metrics and its path."""

from xml.etree import ElementTree

from holodrive.log.words import words


def test_a_run_shows_its_metrics_and_its_path_inline(run):
    root = ElementTree.fromstring(run._repr_html_())
    text = " ".join("".join(root.itertext()).split())
    assert all(words(name).label in text for name in run.metrics)
    assert root.find("{http://www.w3.org/2000/svg}svg") is not None


def test_a_run_of_which_nothing_is_known_still_shows(blank_run):
    assert "no pose is known" in "".join(ElementTree.fromstring(blank_run._repr_html_()).itertext())


def test_log_does_not_need_the_report_layer():
    """Showing a run must not load pages, pictures or terminals."""
    import subprocess
    import sys

    heavy = ("holodrive.reports", "PIL", "rich")
    code = f"import sys, holodrive.log.drawing; sys.exit(any(m in sys.modules for m in {heavy}))"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
