"""Whether specifications are valid Vega-Lite."""

import altair as alt
from jsonschema import Draft7Validator

VALIDATOR = Draft7Validator(alt.load_schema())


def check_valid(spec):
    """Validate a specification as a whole; Altair does it again for each of its parts."""
    VALIDATOR.validate(spec | {"datasets": {}})
