"""Settings of all tests."""

from hypothesis import settings

# The first call of a kernel compiles it, so a deadline would judge the machine. The same examples
# every time: a green commit stays green.
settings.register_profile("dmil", deadline=None, derandomize=True)
settings.load_profile("dmil")
