"""What was published under LLMLight's protocol, as data."""

from __future__ import annotations

from dmil.studies.protocols.recipes import LLMLIGHT

SOURCE = "EvoSignal (2026), tables of all methods under LLMLight's protocol"
_CITIES = ("JN1", "JN2", "JN3", "HZ1", "HZ2")
_LLMLIGHT: dict[str, tuple[float, ...]] = {
    "max-pressure": (281.6, 273.2, 265.8, 325.3, 347.7),
    "CoLight": (279.6, 274.8, 266.4, 322.9, 342.9),
    "Advanced-CoLight": (274.7, 268.3, 260.7, 304.5, 329.2),
    "GPT-4": (275.3, 271.3, 264.7, 318.7, 335.8),
    "LightGPT-13B": (274.0, 266.9, 260.2, 310.8, 330.7),
    "Traffic-R1, 3B": (277.9, 268.9, 262.7, 310.7, 330.3),
    "EvoSignal, best of its programs per city": (271.9, 266.9, 260.0, 307.3, 327.8),
}
PUBLISHED: dict[tuple[str, str], dict[str, float]] = {
    (LLMLIGHT, method): dict(zip(_CITIES, values, strict=True))
    for method, values in _LLMLIGHT.items()
}
"""Protocol and method to city and figure in s. Only a protocol that is reproduced has figures."""
COUNTERPART = {"max-pressure": "published-max-pressure"}
"""Published method to the controller of this study that is to give the same figure."""
