"""Settings of every test: no files left behind, seeds printed on failure."""

import tempfile

from hypothesis import configuration, settings

_scratch = tempfile.TemporaryDirectory(prefix="cdpr-hypothesis-")
configuration.set_hypothesis_home_dir(_scratch.name)
settings.register_profile("suite", database=None, deadline=None, print_blob=True)
settings.load_profile("suite")
