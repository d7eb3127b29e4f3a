"""Small CityFlow files, made on the spot."""

import json
import os
from pathlib import Path

import pytest

ARMS = {"E": (200.0, 0.0), "N": (0.0, 100.0), "W": (-200.0, 0.0), "S": (0.0, -100.0)}
TURNS = {1: ("turn_right", 2), 2: ("go_straight", 1), 3: ("turn_left", 0)}


def crossing_document(arms="ENWS", speed=10.0):
    """Make a crossing named ``c`` with an arm to each side: roads ``E_in``, ``E_out``...

    Lane 0 turns left, 1 goes straight, 2 turns right. Road links are named by their index in the
    returned list ``links``, pairs such as ``("E", "turn_right")``, in an order of its own.
    """
    lanes = [{"width": 4, "maxSpeed": speed} for _ in range(3)]
    centre = {"x": 0, "y": 0}
    nodes, roads, road_links, links = [], [], [], []
    for arm in arms:
        x, y = ARMS[arm]
        end = {"x": x, "y": y}
        names = [f"{arm}_in", f"{arm}_out"]
        nodes.append(
            {"id": arm, "point": end, "width": 0, "roads": names, "roadLinks": [], "virtual": True}
        )
        for name, points, start, stop in (
            (names[0], [end, centre], arm, "c"),
            (names[1], [centre, end], "c", arm),
        ):
            roads.append(
                {
                    "id": name,
                    "points": points,
                    "lanes": lanes,
                    "startIntersection": start,
                    "endIntersection": stop,
                }
            )
    for step, (turn, lane) in sorted(TURNS.items(), reverse=True):
        for arm in reversed(arms):
            to = "ENWS"[("ENWS".index(arm) + step) % 4]
            if to not in arms:
                continue
            links.append((arm, turn))
            road_links.append(
                {
                    "type": turn,
                    "startRoad": f"{arm}_in",
                    "endRoad": f"{to}_out",
                    "laneLinks": [{"startLaneIndex": lane, "endLaneIndex": k} for k in range(3)],
                }
            )
    rights = [index for index, (_, turn) in enumerate(links) if turn == "turn_right"]
    greens = [
        [index for index, (arm, turn) in enumerate(links) if arm in pair and turn == wanted]
        for wanted in ("go_straight", "turn_left")
        for pair in ("EW", "NS")
    ]
    phases = [{"time": 3, "availableRoadLinks": rights}]
    phases += [{"time": 20, "availableRoadLinks": green + rights} for green in greens if green]
    centre_node = {
        "id": "c",
        "point": centre,
        "width": 15,
        "roads": [road["id"] for road in roads],
        "roadLinks": road_links,
        "trafficLight": {"roadLinkIndices": [], "lightphases": phases},
        "virtual": False,
    }
    return {"intersections": [centre_node, *nodes], "roads": roads}, links


@pytest.fixture
def crossing():
    """Return the maker of crossings."""
    return crossing_document


@pytest.fixture
def two_crossings():
    """Two crossings in a row; the western one's roads are named ``w...``."""
    document, _ = crossing_document()
    west, _ = crossing_document()
    names = {road["id"]: f"w{road['id']}" for road in west["roads"]} | {"c": "wc"}
    names |= {arm: f"w{arm}" for arm in "NWS"}
    # The western crossing's eastern arm is the eastern crossing's western one.
    names |= {"E_in": "W_out", "E_out": "W_in", "E": "c"}

    def renamed(part):
        if isinstance(part, dict):
            return {key: renamed(value) for key, value in part.items()}
        if isinstance(part, list):
            return [renamed(value) for value in part]
        return names.get(part, part) if isinstance(part, str) else part

    west = renamed(west)
    for road in document["roads"]:
        road["startIntersection"] = {"W": "wc"}.get(
            road["startIntersection"], road["startIntersection"]
        )
        road["endIntersection"] = {"W": "wc"}.get(road["endIntersection"], road["endIntersection"])
    document["intersections"] = [
        node for node in document["intersections"] if node["id"] != "W"
    ] + [node for node in west["intersections"] if node["id"] != "c"]
    document["roads"] += [road for road in west["roads"] if road["id"] not in ("W_in", "W_out")]
    return document


@pytest.fixture
def write(tmp_path):
    """Return a function that writes a document as JSON and returns the path."""

    def write_json(document, name="roadnet.json"):
        path = tmp_path / name
        path.write_text(json.dumps(document))
        return path

    return write_json


@pytest.fixture
def data():
    """Return the folder of recorded CityFlow networks and demand."""
    folder = os.environ.get("DMIL_DATA")
    if not folder:
        pytest.skip("DMIL_DATA does not name a folder of recorded networks and demand")
    return Path(folder) / "cityflow"
