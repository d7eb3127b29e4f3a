"""The command line inside this process."""

import json

import pytest
from typer.testing import CliRunner

from dmil.cli import app


class CommandLine:
    """Runs command lines and checks their exit codes."""

    def __call__(self, *arguments, code=0):
        """Return what went to standard output; what went to standard error is in ``err``."""
        self.result = CliRunner().invoke(app, [str(each) for each in arguments])
        assert self.result.exit_code == code, self.result.output
        return self.result.stdout

    @property
    def err(self):
        return self.result.stderr

    def json(self, *arguments, code=0):
        """Return the JSON object of a command."""
        return json.loads(self(*arguments, "--json", code=code))


@pytest.fixture
def dmil(monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")
    monkeypatch.setenv("NO_COLOR", "1")
    return CommandLine()
