"""
A gate that passes
==================

Each trial, the limit, and the evidence that grows until it decides.
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
limit = 1.0
""")
magbench.gate(file).plot()
