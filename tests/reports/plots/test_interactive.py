"""A figure that zooms holds what the picture shows: read back from the JSON and compared with matplotlib's artists."""

from __future__ import annotations

import json

import numpy as np
import pytest
from matplotlib.figure import Figure

from reports.plots.interactive import NotInteractive, interactive

X = np.linspace(0.0, 10.0, 50)


def two_panels() -> Figure:
    figure = Figure()
    above, below = figure.subplots(2, 1, sharex=True)
    above.plot(X, np.sin(X), color="#0072b2", label="sine")
    above.plot(X, np.cos(X), color="#d55e00", linestyle="--")
    above.set(title="Waves", ylabel="nT")
    above.legend()
    below.plot(X, np.sin(2 * X), color="#0072b2")
    below.axvspan(2.0, 4.0, color="#cc79a7", alpha=0.1)
    below.axhline(0.5, color="#1b1f24")
    below.set(yscale="linear", xlabel="time (s)", xlim=(0.0, 10.0))
    return figure


def test_every_line_keeps_its_points_and_panel():
    plot = json.loads(interactive(two_panels()).json())
    sine, cosine, double = plot["data"]
    np.testing.assert_allclose(sine["y"], np.sin(X), atol=1e-4)  # a step of the span
    np.testing.assert_allclose(cosine["x"], X, atol=5e-4)
    assert (sine["yaxis"], double["yaxis"]) == ("y", "y2")
    assert cosine["line"]["dash"] == "dash"
    assert plot["layout"]["xaxis2"]["matches"] == "x"
    assert plot["layout"]["xaxis2"]["title"]["text"] == "time (s)"
    assert plot["layout"]["yaxis"]["domain"][0] > plot["layout"]["yaxis2"]["domain"][1]


def test_lines_of_the_figures_legend_toggle_together_and_are_named_once_by_the_boldest():
    figure = two_panels()
    above = figure.axes[0]
    above.get_legend().remove()
    above.lines[0].set_alpha(0.3)
    figure.legend(above.lines[:1], ["sine"])
    (pale, cosine, bold) = interactive(figure).data
    assert pale["legendgroup"] == bold["legendgroup"] == "sine"
    assert (pale["showlegend"], bold["showlegend"], cosine["showlegend"]) == (False, True, False)


def test_a_panels_legend_names_no_line_of_another_panel_nor_of_another_dash():
    figure = two_panels()
    figure.axes[0].plot(X, X, color="#0072b2", linestyle="--")
    named = [trace["name"] for trace in interactive(figure).data]
    assert named == ["sine", "", "", ""]


def test_thousands_have_no_comma_and_ticks_up_to_a_million_all_their_digits():
    figure = Figure()
    few, many = figure.subplots(1, 2)
    few.semilogx([0.01, 1e6], [0.0, 54_000.0])
    few.set_xlim(0.01, 1e6)
    many.semilogx([1.0, 1e9], [0.0, 1.0])
    layout = interactive(figure).layout
    assert layout["separators"] == "."
    assert [layout[axis]["exponentformat"] for axis in ("xaxis", "xaxis2")] == ["none", "power"]


def test_bands_and_lines_across_a_panel_are_shapes():
    band, level = interactive(two_panels()).layout["shapes"]
    assert (band["x0"], band["x1"], band["xref"]) == (2.0, 4.0, "x2")
    assert (level["y0"], level["y1"], level["yref"]) == (0.5, 0.5, "y2")


def test_a_logarithmic_axis_has_exponents_and_keeps_its_notes():
    figure = Figure()
    axis = figure.subplots()
    axis.loglog([1.0, 100.0], [1.0, 10.0])
    axis.annotate("here", (10.0, 1.0), xycoords=("data", "axes fraction"))
    axis.set(xlim=(1.0, 1000.0))
    plot = interactive(figure)
    assert plot.layout["xaxis"]["range"] == [0.0, 3.0]
    (note,) = plot.layout["annotations"]
    assert (note["x"], note["xref"], note["y"], note["yref"]) == (1.0, "x", 1.0, "y domain")


def test_ticks_with_words_keep_them():
    figure = Figure()
    axis = figure.subplots()
    axis.barh(["ellipsoid", "sphere"], [1.0, 2.0], color="#0072b2")
    plot = interactive(figure)
    assert plot.layout["yaxis"]["ticktext"] == ["ellipsoid", "sphere"]
    assert [max(bar["x"]) for bar in plot.data] == [1.0, 2.0]


def test_what_is_no_number_is_a_gap_and_text_stays_text():
    figure = Figure()
    figure.subplots().plot([0.0, 1.0, 2.0], [1.0, np.nan, np.inf], label="</script><b>")
    text = interactive(figure).json()
    assert "</script>" not in text
    assert json.loads(text)["data"][0]["y"] == [1.0, None, None]


def test_surfaces_images_and_scales_of_colours_stay_pictures():
    space, image, scale = Figure(), Figure(), Figure()
    space.add_subplot(projection="3d").plot([0, 1], [0, 1], [0, 1])
    image.subplots().imshow(np.eye(3))
    scale.colorbar(scale.subplots().scatter([0, 1], [0, 1], c=[0.0, 1.0]))
    for figure in (space, image, scale):
        with pytest.raises(NotInteractive):
            interactive(figure)


def test_coordinates_keep_a_strengths_small_changes_and_every_size_on_a_logarithmic_axis():
    strength, sizes = 48_000.0 + 30.0 * np.sin(X), 10.0 ** np.linspace(-9.0, 5.0, 50)
    figure = Figure()
    axis = figure.subplots()
    axis.plot(X, strength)
    axis.plot(X, sizes)
    drawn = interactive(figure).data
    np.testing.assert_allclose(drawn[0]["y"], strength, rtol=0, atol=60.0 / 2e4)
    np.testing.assert_allclose(drawn[1]["y"], sizes, rtol=1e-4)
