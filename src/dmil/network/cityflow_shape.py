"""The shape of CityFlow's road network file, as far as it is read."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field, FiniteFloat, NonNegativeInt

Text = Annotated[str, Field(min_length=1)]


class _Shape(BaseModel):
    model_config = ConfigDict(frozen=True)


class Point(_Shape):
    """A position in metres."""

    x: FiniteFloat
    y: FiniteFloat


class Lane(_Shape):
    """One lane of a road."""

    max_speed: Annotated[FiniteFloat, Field(gt=0, alias="maxSpeed")]
    width: Annotated[FiniteFloat, Field(ge=0)] = 4.0


class RoadnetRoad(_Shape):
    """A road in one direction."""

    id: Text
    points: Annotated[tuple[Point, ...], Field(min_length=2)]
    lanes: Annotated[tuple[Lane, ...], Field(min_length=1)]
    start: Annotated[Text, Field(alias="startIntersection")]
    end: Annotated[Text, Field(alias="endIntersection")]


class LaneLink(_Shape):
    """The way from a lane to a lane."""

    start_lane: Annotated[NonNegativeInt, Field(alias="startLaneIndex")]
    end_lane: Annotated[NonNegativeInt, Field(alias="endLaneIndex")] = 0
    points: tuple[Point, ...] | None = None


class RoadLink(_Shape):
    """The way from a road to a road."""

    type: Literal["go_straight", "turn_left", "turn_right", "turn_u"]
    start_road: Annotated[Text, Field(alias="startRoad")]
    end_road: Annotated[Text, Field(alias="endRoad")]
    lane_links: Annotated[tuple[LaneLink, ...], Field(min_length=1, alias="laneLinks")]


class LightPhase(_Shape):
    """A phase: road links that may go together, and for how long."""

    time: Annotated[FiniteFloat, Field(ge=0)]
    available: Annotated[tuple[NonNegativeInt, ...], Field(alias="availableRoadLinks")]


class TrafficLight(_Shape):
    """The signals of an intersection."""

    phases: Annotated[tuple[LightPhase, ...], Field(alias="lightphases")] = ()


class RoadnetIntersection(_Shape):
    """An intersection, or where it is virtual the end of the modelled roads."""

    id: Text
    point: Point
    width: Annotated[FiniteFloat, Field(ge=0)] = 0.0
    roads: tuple[Text, ...] | None = None
    road_links: Annotated[tuple[RoadLink, ...], Field(alias="roadLinks")] = ()
    light: Annotated[TrafficLight | None, Field(alias="trafficLight")] = None
    virtual: bool = False

    @property
    def is_fringe(self) -> bool:
        """Whether vehicles only begin and end here: CityFlow ignores a virtual one's links."""
        return self.virtual or not self.road_links


class RoadnetFile(_Shape):
    """The whole file."""

    intersections: tuple[RoadnetIntersection, ...]
    roads: tuple[RoadnetRoad, ...]
