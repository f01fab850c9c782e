"""Build of the distribution; its metadata is in pyproject.toml.

The wheel holds the packages nested in magbench, see nesting.py, and the pytest plugin as a separate module. The
editable wheel holds the plugin, the import hook for the checkout's files, and stubs for type checkers, which run no
import hook.
"""

from __future__ import annotations

import importlib.util
import shutil
from pathlib import Path
from typing import ClassVar

from setuptools import setup
from setuptools.command.bdist_wheel import bdist_wheel
from setuptools.command.build_py import build_py

ROOT = Path(__file__).resolve().parent
spec = importlib.util.spec_from_file_location("nesting", ROOT / "nesting.py")  # the build's path is without ROOT
nesting = importlib.util.module_from_spec(spec)
spec.loader.exec_module(nesting)

PLUGIN = "pytest_magbench.py"
"""Not in magbench, since pytest imports it in every project, and magbench takes longer."""


class Nested(build_py):
    """Fills the wheel."""

    def run(self) -> None:
        out = Path(self.build_lib)
        shutil.rmtree(out, ignore_errors=True)
        out.mkdir(parents=True)
        shutil.copy(ROOT / PLUGIN, out)
        if not self.editable_mode:
            nesting.nest(ROOT, out / nesting.WHOLE)
            return
        (out / "_magbench_editable.py").write_text(nesting.HOOK.format(root=str(ROOT)), encoding="utf-8")
        (out / "_magbench_editable.pth").write_text("import _magbench_editable\n", encoding="utf-8")
        nesting.nest(ROOT, out / f"{nesting.WHOLE}-stubs", stubs=True)


class EditableWheel(bdist_wheel):
    """An ordinary wheel of what `Nested` writes in editable mode, in place of setuptools' own finders."""

    user_options: ClassVar = [*bdist_wheel.user_options, ("dist-info-dir=", None, "metadata made before; not used")]

    def initialize_options(self) -> None:
        super().initialize_options()
        self.dist_info_dir = None

    def run(self) -> None:
        self.get_finalized_command("build_py").editable_mode = True
        super().run()
        shutil.rmtree(self.get_finalized_command("build").build_base, ignore_errors=True)


if __name__ == "__main__":
    setup(packages=["magbench"], cmdclass={"build_py": Nested, "editable_wheel": EditableWheel})
