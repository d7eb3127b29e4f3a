"""What acts on vehicles during SUMO's run, beside roads and signals: one table.

What decides who departs and where to is acted on while the files are read, so that both simulators
have it. The rest SUMO follows by itself where that leaves the vehicles of the demand what they are
(`dmil.demand.sumo.beside`), and the queue simulator goes on without it, with a warning; or it is
switched off in both. SUMO is handed vehicle types without scales and without any other devices.
"""

from __future__ import annotations

from collections.abc import Mapping
from copy import deepcopy
from dataclasses import dataclass
from typing import Literal
from xml.etree.ElementTree import Element

Treatment = Literal["acted on", "SUMO only", "off", "left out", "no effect"]
"""What becomes of it: ``acted on`` alike in both simulators; by SUMO as in a run of its own, while
the queue simulator drives without (``SUMO only``); switched ``off`` in both, the vehicles
drive without; vehicles are ``left out``; it has ``no effect`` on who drives where."""


@dataclass(frozen=True, slots=True)
class Acting:
    """One kind of what acts on vehicles (ours).

    Parameters
    ----------
    what
        How the files say it.
    treatment
        What becomes of it.
    instead
        What happens here, a sentence.
    text
        What a remark says after a number and an example; empty where there is nothing to say.
    mend
        What to do about it.
    """

    what: str
    treatment: Treatment
    instead: str
    text: str = ""
    mend: str = "Nothing; but SUMO's own run differs."


_IN_SUMO = "Evaluate in SUMO (--simulator sumo)."
_OTHERS = ("bluelight", "driverstate", "fcd-replay", "glosa", "stationfinder", "toc")
"""Devices that change how a vehicle drives, beside those with a row of their own."""
WATCHING = frozenset(
    {"battery", "btreceiver", "btsender", "elechybrid", "emissions", "example", "fcd", "friction"}
    | {"person", "ssm", "transportable", "tripinfo", "vehroute"}
)
"""Devices that only look on and write."""

ACTING: Mapping[str, Acting] = {
    "scale": Acting(
        "attribute `scale` of a vehicle type, option `scale`",
        "acted on",
        "Both factors are multiplied. Vehicles, trips and flows depart as often as SUMO lets them, "
        "at its times; members of a distribution of types by their mean.",
    ),
    "rerouting-device": Acting(
        "parameter `has.rerouting.device`, options `device.rerouting.probability`, `….explicit`",
        "SUMO only",
        "SUMO reroutes vehicles, and they count where they are; `….explicit` names vehicles of "
        "the file and is not used here. In the queue simulator they keep the file's route; trips "
        "take the one that SUMO chooses at departure under the file's plan.",
        "have a device that sends them elsewhere during the run (rerouting), which only SUMO "
        "follows: in the queue simulator their routes are fixed",
        "Evaluate in SUMO (--simulator sumo), or let SUMO write the routes driven "
        "(--vehroute-output) and use that file.",
    ),
    "taxi-device": Acting(
        "parameter `has.taxi.device`, options `device.taxi.…`",
        "off",
        "The vehicle drives the file's route once, as a car, and serves no passengers.",
        "have a device that lets them serve persons (taxi), which is switched off: they drive the "
        "file's route",
    ),
    "driving-device": Acting(
        f"parameters `has.….device` and options `device.….probability` of {', '.join(_OTHERS)}, "
        "and of any unknown device",
        "off",
        "The vehicle drives as if without it.",
        f"have devices that change how they drive ({', '.join(_OTHERS)}), which are switched off",
    ),
    "watching-device": Acting(
        f"the same of {', '.join(sorted(WATCHING))}",
        "no effect",
        "They only look on and write; a run has those that it needs itself.",
    ),
    "stops": Acting(
        "`<stop>` of a vehicle, trip, flow or route",
        "SUMO only",
        "Vehicles stop in SUMO; stopped vehicles are in no queue. In the queue simulator they "
        "drive on: the demand on the signals is the same, but no lane is blocked.",
        "have stops, which they make in SUMO alone: in the queue simulator they drive on",
        _IN_SUMO,
    ),
    "stops-off": Acting(
        "a `<stop>` off the route, without an end, or that waits for others (`triggered`, "
        "`expected`, `join`, `split`)",
        "off",
        "Vehicles pass all their stops.",
        "have a stop off their route, without an end, or that waits for others, and ignore it",
        "Correct the stops, or give them a duration.",
    ),
    "beside": Acting(
        "bicycles, trains, ships and the like, also on edges that are theirs alone",
        "SUMO only",
        "They drive in SUMO, and others meet them; what is measured is of road vehicles with a "
        "motor. The load (`--load`) does not change them. In the queue simulator and in "
        "SUMO's mesoscopic model they are missing.",
    ),
    "no-fixed-departure": Acting(
        '`depart="triggered"`, `containerTriggered`, `split`, `now`',
        "left out",
        "Triggered departures are not supported.",
        "have no departure in seconds and are left out; give one, since nothing here triggers a "
        "departure",
        "Give them a departure in seconds.",
    ),
    "person": Acting(
        "`<person>`, `<personFlow>` who walk: `<walk>`, `<personTrip>`, `<stop>` on an edge",
        "SUMO only",
        "In SUMO they walk, vehicles wait for them at crossings, and their delay is measured. The "
        "queue simulator has no pedestrians.",
        "are persons, which walk in the SUMO simulator only",
        "Nothing; where they delay vehicles, evaluate with --simulator sumo.",
    ),
    "person-elsewhere": Acting(
        "`<person>`, `<personFlow>` who ride, or go to a bus stop or another place by its name",
        "left out",
        "They do not ride, and no vehicle waits for them.",
        "are persons that ride, or go to a bus stop etc., and are left out",
    ),
    "container": Acting(
        "`<container>`, `<containerFlow>`",
        "left out",
        "Containers are ignored.",
        "are containers and are left out; only vehicles are simulated",
    ),
    "rerouter": Acting(
        "`<rerouter>` with closed edges and lanes, other goals, routes and parking areas",
        "SUMO only",
        "SUMO reroutes vehicles, and they count where they are. In the queue simulator roads stay "
        "open and routes are fixed.",
        "are rerouters, which only SUMO follows: in the queue simulator roads stay open and "
        "routes are fixed",
        "Evaluate in SUMO (--simulator sumo), or close the roads in the network (netconvert "
        "--remove-edges) and give vehicles routes.",
    ),
    "calibrator": Acting(
        "`<calibrator>`, `<vaporizer>`",
        "off",
        "No vehicles are added or removed.",
        "are calibrators etc. and are switched off: they add and remove no vehicles",
        "Let SUMO write the simulated vehicles (--vehroute-output) and use that file.",
    ),
    "speed-sign": Acting(
        "`<variableSpeedSign>`",
        "SUMO only",
        "Speed limits change in SUMO. The queue simulator uses those of the network throughout.",
        "are signs that change the speed limit, which SUMO alone follows: in the queue simulator "
        "the network's hold",
        _IN_SUMO,
    ),
}
"""Every kind; those with a text are kinds of remarks and findings."""

DEFINITIONS = {
    "container": "container",
    "containerFlow": "container",
    "rerouter": "rerouter",
    "calibrator": "calibrator",
    "vaporizer": "calibrator",
    "variableSpeedSign": "speed-sign",
}
"""Elements beside vehicles that act, and their kinds."""


def switches(element: Element) -> dict[str, bool]:
    """Return the devices that an element's own parameters switch on or off (SUMO docs: Devices).

    ``has.NAME.device`` goes over ``device.NAME.probability``; any probability above 0 counts as on.
    """
    found: dict[str, bool] = {}
    for prefix, suffix in (("device.", ".probability"), ("has.", ".device")):
        for parameter in element.findall("param"):
            key = parameter.get("key", "")
            if key.startswith(prefix) and key.endswith(suffix):
                found[key[len(prefix) : -len(suffix)]] = _is_on(parameter.get("value", ""))
    return found


def device_kinds(devices: Mapping[str, bool]) -> list[str]:
    """Return the kinds of what the devices do that are switched on (ours)."""
    return sorted({kind for name, on in devices.items() if on and (kind := _kind_of(name))})


def names_device(parameter: Element) -> bool:
    """Tell whether a ``<param>`` is about a device (ours)."""
    return parameter.get("key", "").startswith(("has.", "device."))


def kind_of_option(name: str, value: str) -> str:
    """Return the kind of what an option of ``sumo`` switches on, "" if nothing that acts (ours).

    Name and value are such as ``device.rerouting.probability`` and ``0.5``.
    """
    device, _, way = name.removeprefix("device.").rpartition(".")
    on = _is_on(value) if way == "probability" else way == "explicit" and bool(value)
    return _kind_of(device) if on and name.startswith("device.") else ""


def acts_in_sumo(parameter: Element) -> bool:
    """Tell whether a ``<param>`` is about a device that SUMO alone acts on (ours)."""
    return parameter.get("key", "").startswith(("has.rerouting.", "device.rerouting."))


def without_acting(definition: Element, *, for_sumo: bool = False) -> Element:
    """Return a copy of a vehicle type, or of a distribution, without devices and scales (ours).

    ``for_sumo`` keeps the devices that SUMO alone acts on.
    """
    kept = deepcopy(definition)
    for element in kept.iter():
        element.attrib.pop("scale", None)
        for parameter in filter(names_device, element.findall("param")):
            if not (for_sumo and acts_in_sumo(parameter)):
                element.remove(parameter)
    return kept


def acting_markdown() -> str:
    """Return the table of docs/your-network.md (ours)."""
    rows = "".join(
        f"| {each.what} | {each.treatment} | {each.instead} |\n" for each in ACTING.values()
    )
    return f"| in the files | here | what happens |\n|-|-|-|\n{rows}"


def _is_on(value: str) -> bool:
    try:
        return float(value) > 0
    except ValueError:
        return value.strip().lower() in ("true", "yes", "on", "x", "t")


def _kind_of(device: str) -> str:
    if device in WATCHING:
        return ""
    own = f"{device}-device"
    return own if own in ACTING else "driving-device"
