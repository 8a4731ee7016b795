#!python
"""The command clsdf, which is the file bin/clsdf in the package clsdf. The package is not imported."""

import importlib.util
import os
import sys

command = os.path.join(importlib.util.find_spec("clsdf").submodule_search_locations[0], "bin", "clsdf")
os.execv(command, [command, *sys.argv[1:]])
