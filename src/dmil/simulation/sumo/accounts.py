"""The measures of a run, from SUMO's outputs and from vehicles that are still in the network."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import numpy.typing as npt

from dmil.demand import Vehicles
from dmil.simulation.measures import NAN, Measures
from dmil.simulation.sumo.approaches import Seen, Ways, reached_stop_lines
from dmil.simulation.sumo.outputs import Outputs

FloatArray = npt.NDArray[np.float64]


class Accounts:
    """Adds up a run.

    Parameters
    ----------
    output
        SUMO's output file.
    vehicles, ways
        All journeys.
    begin_s
        SUMO's time at 0 s of the run.
    """

    def __init__(self, output: Path, vehicles: Vehicles, ways: Ways, begin_s: int) -> None:
        self._outputs = Outputs(output)
        self._depart_s, self._ways, self._begin_s = vehicles.depart_s, ways, begin_s

    def measures(
        self,
        time_s: int,
        seen: Seen,
        under_way: FloatArray | None,
        *,
        overruled: int,
        emissions: bool,
    ) -> Measures:
        """Return the measures up to now (definitions: `Measures`).

        Parameters
        ----------
        time_s
            Time since the run began.
        seen
            Where the vehicles in the network are.
        under_way: (vehicles in the network, 4) float64
            Number, departure delay, time loss and stops; None after the run, when the output file
            tells.
        overruled
            Requests that the signal timing rules did not grant.
        emissions
            Whether SUMO's emission model runs.
        """
        if time_s:
            self._outputs.update()
        trips, seconds = self._outputs.trips, self._outputs.seconds.astype(np.int32)
        done = trips[trips[:, 1] >= 0]
        ids, arrival_s = done[:, 0].astype(np.int64), done[:, 1] - self._begin_s
        if under_way is None:
            under_way = trips[trips[:, 1] < 0][:, [0, 2, 3, 5]]
        spawned = int(np.searchsorted(self._depart_s, time_s))
        depart_s = self._depart_s[:spawned]
        # Whoever has neither arrived nor entered waits outside, from departure until now.
        delay_s = time_s - depart_s.astype(np.float64)
        delay_s[ids] = done[:, 2]
        delay_s[under_way[:, 0].astype(np.int64)] = under_way[:, 1]
        travel_s = time_s - depart_s.astype(np.float64)
        travel_s[ids] = arrival_s - depart_s[ids]
        queued_at = seconds[:, 0] + seconds[:, 1]
        wait_veh_s = float(queued_at.sum())
        gone = self._ways.passed[self._ways.offset[ids + 1] - 1].sum()
        return Measures(
            time_s=time_s,
            spawned_veh=spawned,
            arrived_veh=len(done),
            wait_veh_s=wait_veh_s,
            visits=int(gone) + reached_stop_lines(self._ways, seen),
            # Mesoscopic vehicles wait for parts of seconds, which counts at full seconds can miss.
            arrived_wait_veh_s=min(float(done[:, [2, 4]].sum()), wait_veh_s),
            travel_veh_s=float(travel_s.sum()),
            time_loss_veh_s=float(done[:, 3].sum() + under_way[:, 2].sum()),
            departure_delay_veh_s=float(delay_s.sum()),
            stops=int(done[:, 5].sum() + under_way[:, 3].sum()),
            overruled=overruled,
            arrived_at=seconds[:, 2],
            queued_at=queued_at,
            co2_g=float(trips[:, 6].sum()) if emissions else NAN,
            fuel_g=float(trips[:, 7].sum()) if emissions else NAN,
        )
