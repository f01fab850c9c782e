"""
A gate that fails
=================

The same gate with a limit below the score.
"""

import tempfile
from pathlib import Path

import magbench

file = Path(tempfile.mkdtemp()) / "gates.toml"
file.write_text("""
[[gate]]
name = "heading of ellipsoid"
scenario = "tumble"
set = ["phases.0.duration_s=40"]
calibrator = "ellipsoid"
score = "heading_rms"
limit = 0.01
""")
magbench.gate(file).plot()
