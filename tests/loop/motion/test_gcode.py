"""G-code programs of known geometry, and what a bad one is told."""

from hfc_design.files.named_scenario import load_scenario


def test_a_file_in_a_change_lies_where_the_user_is(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "mine.ngc").write_text("G1 X10 Y5 F300\n")
    change = "reference={kind='gcode', file='mine.ngc'}"
    assert load_scenario("feed-drive-circle", [change]).reference.duration_s > 2.0
    assert load_scenario("feed-drive-contour").reference.duration_s > 20.0
