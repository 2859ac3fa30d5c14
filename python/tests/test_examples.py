"""Every example runs and says what its title asks."""

import runpy
from pathlib import Path

import pytest

EXAMPLES = Path(__file__).parents[1] / "examples"


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("minicircle", "converged"),
        ("own_curves", "1 site"),
        ("loop_by_hand", "end force"),
    ],
)
def test_example(
    name: str, words: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.chdir(tmp_path)
    runpy.run_path(str(EXAMPLES / f"{name}.py"), run_name="__main__")
    assert words in capsys.readouterr().out


def test_a_tight_knot_is_near_its_published_length() -> None:
    pytest.importorskip("database_knotinfo")
    example = runpy.run_path(str(EXAMPLES / "ideal_knots.py"))
    ((name, found, published, _),) = example["rows"](["3_1"])
    assert name == "3_1" and 1.0 < found / published < 1.015


def test_every_example_is_run() -> None:
    assert {path.stem for path in EXAMPLES.glob("*.py")} == {"minicircle", "own_curves", "loop_by_hand", "ideal_knots"}
