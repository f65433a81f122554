"""What shows itself in a notebook, and the notebooks themselves, run from nothing."""

from __future__ import annotations

import base64
import re
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import numpy as np
import pytest
from conftest import refused

import burstscope as bs

NOTEBOOKS = sorted((Path(__file__).parent.parent / "notebooks").glob("*.ipynb"))
# All of them together are small enough to be kept with the sources.
MOST_BYTES = 1_500_000


def pictures(html: str) -> list[bytes]:
    return [base64.b64decode(data) for data in re.findall(r"data:image/jpeg;base64,([A-Za-z0-9+/=]+)", html)]


def test_bursts_detections_and_matches_show_pictures(chart: bs.Burst, found: bs.Detection) -> None:
    assert len(pictures(chart._repr_html_())) == 1 and "240×180" in chart._repr_html_()
    svg = found._repr_html_().split("<br>")[0]
    root = ElementTree.fromstring(svg)
    assert len(root.findall(".//{*}circle")) == min(len(found), 400)
    assert len(pictures(svg)) == 1
    matched = bs.match(found, found)
    both = matched._repr_html_()
    assert len(pictures(both)) == 2
    ElementTree.fromstring(both.split("<br>")[0])
    assert all(jpeg[:2] == b"\xff\xd8" and len(jpeg) < 100_000 for jpeg in pictures(both))


def test_images_are_arrays_that_show_themselves(chart: bs.Burst) -> None:
    image = bs.stack(chart, (0.5, 0))
    assert isinstance(image, np.ndarray) and isinstance(image[10:20], bs.Image)
    assert image.png().startswith(b"\x89PNG") and image.png(colour_map="Viridis", limits=(0, 1)) != image.png()
    assert len(pictures(image._repr_mimebundle_()["text/html"])) == 1
    assert "text/html" not in image[0]._repr_mimebundle_()
    response = bs.dog(chart, (0.5, 0))
    assert response.signed and not image.signed and float(response.min()) < 0
    assert pictures(response._repr_mimebundle_()["text/html"])
    refused(ValueError, "give one of Grey, Viridis", image.png, colour_map="pink")


def test_a_picture_has_the_pixels_of_the_array() -> None:
    cv2 = pytest.importorskip("cv2")
    array = np.linspace(0, 1, 64 * 48, dtype=np.float32).reshape(48, 64)
    png = bs.Image.of(array).png(limits=(0, 1))
    decoded = cv2.imdecode(np.frombuffer(png, np.uint8), cv2.IMREAD_GRAYSCALE)
    np.testing.assert_allclose(decoded / 255, array, atol=0.003)


def test_a_slider_holds_its_own_pictures(chart: bs.Burst, tmp_path: Path) -> None:
    slider = bs.slider(chart, count=5, max_slope=1, max_side=160)
    assert len(slider) == 5 and len(pictures(slider.html)) == 5
    assert len(slider.html) < 100_000 and "src=\"http" not in slider.html
    page = slider.save(tmp_path / "slider.html")
    assert page.read_text().startswith("<!doctype html>")
    refused(ValueError, "none is given", bs.slider, chart, [])


def test_there_are_eight_small_notebooks() -> None:
    assert len(NOTEBOOKS) == 8
    assert sum(path.stat().st_size for path in NOTEBOOKS) < MOST_BYTES


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_notebook_runs_from_nothing(path: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    nbclient = pytest.importorskip("nbclient")
    nbformat = pytest.importorskip("nbformat")
    for package in ("pycolmap", "matplotlib", "h5py"):
        if package in path.read_text():
            pytest.importorskip(package)
    monkeypatch.setenv("JUPYTER_PLATFORM_DIRS", "1")
    notebook = nbformat.read(path, as_version=4)

    def shown() -> list[bool]:
        # A bar of progress that has gone leaves an empty output.
        return [
            any(output.get("data", {}).get("text/html") != "" for output in cell.outputs)
            for cell in notebook.cells
            if cell.cell_type == "code"
        ]

    kept = shown()
    client = nbclient.NotebookClient(notebook, timeout=600, kernel_name="python3", resources={"metadata": {"path": tmp_path}})
    client.execute()
    assert any(kept) and shown() == kept, "run `make notebooks` again"
