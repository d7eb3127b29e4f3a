"""Vehicle types: which class they are of, and how much room a queued vehicle takes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from xml.etree.ElementTree import Element

from dmil.demand.sumo.acting import switches, without_acting
from dmil.demand.sumo.entry import DemandEntry, lines_of, text_of
from dmil.network.permissions import ALL_CLASSES, MOTOR_CLASSES, OLD_NAMES, Classes

DEFAULT_TYPE = "DEFAULT_VEHTYPE"
GAP_M = 2.5
MOST_SCALE = 1000
"""More is a slip of the pen."""
CLASS_LENGTH_M = {
    **dict.fromkeys(MOTOR_CLASSES | {"ignoring"}, 5.0),
    **{"emergency": 6.5, "bus": 12.0, "coach": 14.0, "delivery": 6.5, "truck": 7.1},
    **{"trailer": 16.5, "motorcycle": 2.2, "moped": 2.1},
}
"""SUMO's classes of road vehicles with a motor, and their default length
(SUMO docs: Vehicle Type Parameter Defaults). The default gap in front of all is 2.5 m."""


@dataclass(frozen=True, slots=True)
class VehicleType:
    """What of a vehicle type matters here (ours).

    Parameters
    ----------
    road
        Whether its vehicles are road vehicles with a motor.
    space_m
        Length and least gap of a vehicle; of a distribution the mean.
    classes
        Those whose permissions it has; of a distribution all, and none for ``ignoring``.
    members
        Of a distribution over several classes the types, by id, and their probabilities.
    scale
        How often each of its vehicles departs; of a distribution the mean.
    devices
        Those that its parameters switch on or off; of a distribution, on if any member has it.
    """

    road: bool
    space_m: float
    classes: Classes = frozenset()
    members: tuple[tuple[str, float, VehicleType], ...] = ()
    scale: float = 1.0
    devices: Mapping[str, bool] = field(default_factory=dict)


_BUILT_IN = {
    DEFAULT_TYPE: VehicleType(True, CLASS_LENGTH_M["passenger"] + GAP_M, Classes({"passenger"})),
    "DEFAULT_TAXITYPE": VehicleType(True, CLASS_LENGTH_M["taxi"] + GAP_M, Classes({"taxi"})),
    "DEFAULT_BIKETYPE": VehicleType(False, 0.0),
    "DEFAULT_PEDTYPE": VehicleType(False, 0.0),
    "DEFAULT_RAILTYPE": VehicleType(False, 0.0),
    "DEFAULT_CONTAINERTYPE": VehicleType(False, 0.0),
}


class VehicleTypes:
    """The types and distributions of types that were defined so far (ours)."""

    def __init__(self) -> None:
        self._types: dict[str, VehicleType] = {}
        self._definitions: list[str] = []
        self._for_sumo: list[str] = []

    @property
    def xml_for_sumo(self) -> str:
        """The same with the devices that SUMO alone acts on."""
        return lines_of(self._for_sumo)

    @property
    def xml(self) -> str:
        """All definitions as XML elements, one a line, without a root element."""
        return lines_of(self._definitions)

    def define(self, entry: DemandEntry) -> None:
        """Take up a ``<vType>`` or ``<vTypeDistribution>``.

        Raises
        ------
        DemandError
            If it has no id or one that exists, or a number or a type in it cannot be used.
        """
        name = entry.required("id")
        if name in self._types:
            raise entry.error(
                "there is another vehicle type of this id", mend="rename or remove one of them"
            )
        definition = without_acting(entry.element)
        for_sumo = without_acting(entry.element, for_sumo=True)
        if entry.element.tag == "vType":
            self._types[name] = _type(entry)
        else:
            self._types[name] = self._distribution(entry, (definition, for_sumo))
        self._definitions.append(text_of(definition))
        self._for_sumo.append(text_of(for_sumo))

    def of(self, entry: DemandEntry) -> VehicleType:
        """Return the type that a vehicle or flow names, SUMO's default if it names none.

        Raises
        ------
        DemandError
            If it names one that is not defined before it.
        """
        return self._known(entry, entry.get("type") or DEFAULT_TYPE)

    def _known(self, entry: DemandEntry, name: str) -> VehicleType:
        found = self._types.get(name) or _BUILT_IN.get(name)
        if found is None:
            raise entry.error(
                f"there is no vehicle type '{name}'",
                expected="one that is defined before it",
                mend=f'add <vType id="{name}"/> in front of it, or name the file that has it',
            )
        return found

    def _distribution(self, entry: DemandEntry, definitions: Sequence[Element]) -> VehicleType:
        """Read a distribution; in its definitions the shares become those of scaled members."""
        members: list[VehicleType] = []
        weights: list[float] = []
        ids: list[str] = []
        for child in entry.element.findall("vType"):
            member = DemandEntry(entry.place, child)
            reference = child.get("refId")
            if reference:
                members.append(self._known(member, reference))
            else:
                self._types[member.required("id")] = _type(member)
                members.append(self._types[member.id])
            ids.append(reference or member.id)
            weights.append(member.number("probability") if "probability" in child.attrib else 1.0)
        names = (entry.get("vTypes") or "").split()
        members += [self._known(entry, name) for name in names]
        weights += probabilities(entry, len(names))
        total = sum(weights)
        if not total > 0:
            raise entry.error("it has no types", expected="at least one of a probability above 0")
        road = any(member.road for member in members)
        sizes = [
            (w, member.space_m)
            for w, member in zip(weights, members, strict=True)
            if member.road or not road
        ]
        space_m = sum(w * size_m for w, size_m in sizes) / (sum(w for w, _ in sizes) or 1)
        scaled = [w * member.scale for w, member in zip(weights, members, strict=True)]
        scale = sum(scaled) / total
        if scale and any(member.scale != 1 for member in members):
            for definition in definitions:
                nested = definition.findall("vType")
                for child, weight in zip(nested, scaled, strict=False):
                    child.set("probability", repr(weight))
                if names:
                    definition.set("probabilities", " ".join(map(repr, scaled[len(nested) :])))
        devices = [(name, on) for member in members for name, on in member.devices.items()]
        drawn = zip((*ids, *names), scaled, members, strict=True)
        apart = road and len({member.classes for member in members}) > 1
        return VehicleType(
            road,
            space_m,
            Classes().union(*(member.classes for member in members)),
            # A way that was found for one class is none for another.
            tuple(
                (name, w / sum(scaled), replace(each, space_m=space_m))
                for name, w, each in drawn
                if apart and w
            ),
            scale=scale,
            devices=dict(sorted(devices, key=lambda device: device[1])),
        )


def probabilities(entry: DemandEntry, count: int) -> Sequence[float]:
    """Return the weights that a distribution gives to the members that it names, by default 1.

    Raises
    ------
    DemandError
        If there are not as many, or one is no number of 0 or more.
    """
    text = entry.get("probabilities")
    if text is None:
        return [1.0] * count
    try:
        found = [float(part) for part in text.split()]
    except ValueError:
        found = []
    if len(found) != count or not all(0 <= weight < float("inf") for weight in found):
        raise entry.error(
            f"probabilities is '{text}'", expected=f"{count} numbers of 0 or more, one per member"
        )
    return found


def _type(entry: DemandEntry) -> VehicleType:
    kind = entry.get("vClass") or "passenger"
    kind = OLD_NAMES.get(kind, kind)
    length_m = CLASS_LENGTH_M.get(kind, CLASS_LENGTH_M["passenger"])
    if entry.get("length") is not None:
        length_m = entry.number("length", least=0.1)
    gap_m = entry.number("minGap") if entry.get("minGap") is not None else GAP_M
    road = kind in CLASS_LENGTH_M
    scale = entry.number("scale", most=MOST_SCALE) if entry.get("scale") is not None else 1.0
    return VehicleType(
        road,
        length_m + gap_m,
        ALL_CLASSES & {kind},
        scale=scale,
        devices=switches(entry.element),
    )
