"""Every option of a SUMO configuration, and what becomes of it: one table (ours).

The names, other names and defaults are those of ``sumo --save-template`` of SUMO 1.28, and of
sumo-gui where it can draw in three dimensions; a test compares them with the SUMO installed.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, NamedTuple

Treatment = Literal["read", "sumo", "noted", "harmless", "refused"]
"""What becomes of an option.

- ``read``: both simulators act on it.
- ``sumo``: SUMO is told it as it stands; the queue simulator does not know it.
- ``noted``: it could change how vehicles drive and is not taken over; a finding says so.
- ``harmless``: it does not change how vehicles drive, or only by chance.
- ``refused``: with it a run could not be what the file says.
"""


@dataclass(frozen=True, slots=True)
class Group:
    """Options that are treated alike (ours).

    Parameters
    ----------
    treatment
        What becomes of them.
    reason
        Why.
    names
        One option a word: its name, its other names after ``|``, its default after ``=``.
    """

    treatment: Treatment
    reason: str
    names: str


class SumoOption(NamedTuple):
    """One option: its name, what becomes of it, why, and its default (ours)."""

    name: str
    treatment: Treatment
    reason: str
    default: str


GROUPS = (
    Group(
        "read",
        "they say what is loaded, and when",
        """
        net-file|n|net route-files|r|routes|route additional-files|a|additional begin|b end|e
        step-length scale
        """,
    ),
    Group("harmless", "every junction is known as such", "junction-taz"),
    Group(
        "harmless",
        "they name this file",
        """
        configuration-file|c|configuration save-configuration|C|save-config
        save-configuration.relative|save-config.relative save-template save-schema
        save-commented|save-template.commented
        """,
    ),
    Group(
        "harmless",
        "they say what SUMO writes",
        """
        write-license write-metadata output-prefix output-suffix precision precision.geo
        output.compression output.format output.column-header output.column-separator
        human-readable-time|H netstate-dump|ndump|netstate|netstate-output
        netstate-dump.empty-edges|dump-empty-edges|netstate-output.empty-edges|netstate.empty-edges
        netstate-dump.precision|dump-precision|netstate-output.precision|netstate.precision
        emission-output emission-output.precision emission-output.geo emission-output.step-scaled
        emission-output.attributes battery-output battery-output.precision elechybrid-output
        elechybrid-output.precision elechybrid-output.aggregated chargingstations-output
        chargingstations-output.aggregated chargingstations-output.aggregated.write-unfinished
        overheadwiresegments-output substations-output substations-output.precision fcd-output
        fcd-output.geo fcd-output.utm fcd-output.signals fcd-output.distance fcd-output.acceleration
        fcd-output.speed-relative fcd-output.max-leader-distance fcd-output.params
        fcd-output.filter-edges.input-file fcd-output.attributes fcd-output.filter-shapes
        fcd-output.skip-empty person-fcd-output|person-fcd device.ssm.filter-edges.input-file
        full-output queue-output queue-output.period queue-output.aggregation
        queue-output.speed-threshold queue-output.percentile queue-output.skip-empty vtk-output
        amitran-output summary-output|summary summary-output.period person-summary-output
        tripinfo-output|tripinfo tripinfo-output.write-unfinished tripinfo-output.write-undeparted
        personinfo-output|personinfo vehroute-output|vehroutes
        vehroute-output.exit-times|vehroutes.exit-times
        vehroute-output.last-route|vehroutes.last-route vehroute-output.sorted|vehroutes.sorted
        vehroute-output.dua|vehroutes.dua vehroute-output.cost
        vehroute-output.intended-depart|vehroutes.intended-depart
        vehroute-output.route-length|vehroutes.route-length vehroute-output.write-unfinished
        vehroute-output.skip-ptlines vehroute-output.incomplete vehroute-output.stop-edges
        vehroute-output.speedfactor vehroute-output.internal personroute-output|personroutes
        link-output railsignal-block-output railsignal-vehicle-output bt-output lanechange-output
        lanechange-output.started lanechange-output.ended lanechange-output.xy stop-output
        stop-output.write-unfinished collision-output edgedata-output lanedata-output
        statistic-output|statistics-output deadlock-output save-state.times save-state.period
        save-state.period.keep save-state.prefix save-state.suffix save-state.files save-state.rng
        save-state.transportables save-state.constraints save-state.precision
        pedestrian.jupedsim.wkt pedestrian.jupedsim.wkt.geo pedestrian.jupedsim.py
        """,
    ),
    Group(
        "harmless",
        "they say what SUMO reports, checks and counts",
        """
        verbose|v print-options help|? version|V xml-validation|X xml-validation.net
        xml-validation.routes no-warnings|W|suppress-warnings aggregate-warnings log|l|log-file
        message-log error-log log.timestamps log.processid language
        duration-log.disable|no-duration-log duration-log.statistics|t no-step-log step-log.period
        emissions.volumetric-fuel phemlight-path phemlight-year phemlight-temperature
        device.emissions.probability device.emissions.explicit|device.emissions.knownveh
        device.emissions.deterministic device.emissions.begin device.emissions.period
        device.tripinfo.probability device.tripinfo.explicit|device.tripinfo.knownveh
        device.tripinfo.deterministic device.vehroute.probability
        device.vehroute.explicit|device.vehroute.knownveh device.vehroute.deterministic
        device.fcd.probability device.fcd.explicit|device.fcd.knownveh device.fcd.deterministic
        device.fcd.begin device.fcd.period device.fcd.radius person-device.fcd.probability
        person-device.fcd.explicit|person-device.fcd.knownveh person-device.fcd.deterministic
        person-device.fcd.period device.ssm.probability device.ssm.explicit|device.ssm.knownveh
        device.ssm.deterministic device.ssm.measures device.ssm.thresholds device.ssm.trajectories
        device.ssm.range device.ssm.extratime device.ssm.mdrac.prt device.ssm.file device.ssm.geo
        device.ssm.write-positions device.ssm.write-lane-positions device.ssm.write-na
        device.ssm.exclude-conflict-types device.friction.probability
        device.friction.explicit|device.friction.knownveh device.friction.deterministic
        device.friction.stdDev device.friction.offset device.example.probability
        device.example.explicit|device.example.knownveh device.example.deterministic
        device.example.parameter device.elechybrid.probability
        device.elechybrid.explicit|device.elechybrid.knownveh device.elechybrid.deterministic
        """,
    ),
    Group(
        "harmless",
        "they are about the window of sumo-gui",
        """
        gui-settings-file|g quit-on-end|Q game|G game.mode start|S delay|d breakpoints|B
        edgedata-files|data-files|m alternative-net-file|N selection-file demo|D disable-textures|T
        registry-viewport window-size window-pos tracker-interval gui-testing gui-testing-debug
        gui-testing.setting-output osg-view
        """,
    ),
    Group(
        "harmless",
        "they concern connections to SUMO and communication between vehicles",
        """
        remote-port num-clients device.btreceiver.probability
        device.btreceiver.explicit|device.btreceiver.knownveh device.btreceiver.deterministic
        device.btreceiver.range device.btreceiver.all-recognitions device.btreceiver.offtime
        device.btsender.probability device.btsender.explicit|device.btsender.knownveh
        device.btsender.deterministic person-device.btsender.probability
        person-device.btsender.explicit|person-device.btsender.knownveh
        person-device.btsender.deterministic person-device.btreceiver.probability
        person-device.btreceiver.explicit|person-device.btreceiver.knownveh
        person-device.btreceiver.deterministic
        """,
    ),
    Group(
        "harmless",
        "they are about chance, threads, reading ahead and wires",
        """
        random|abs-rand seed|srand thread-rngs threads route-steps|s max-num-persons scale-suffix
        tls.actuated.show-detectors overhead-wire.solver overhead-wire.recuperation
        overhead-wire.substation-current-limits emergencydecel.warning-threshold use-stop-ended
        use-stop-started mapmatch.distance mapmatch.junctions mapmatch.taz weights.reversal-penalty
        persontrip.walk-opposite-factor routing-algorithm astar.all-distances
        astar.landmark-distances railway.max-train-length device.rerouting.threads|routing-threads
        device.rerouting.output device.battery.probability
        device.battery.explicit|device.battery.knownveh device.battery.deterministic
        device.battery.track-fuel load-state.offset load-state.remove-vehicles
        """,
    ),
    Group(
        "sumo",
        "they change how SUMO drives, and are passed to it",
        """
        ignore-route-errors
        step-method.ballistic extrapolate-departpos lateral-resolution no-internal-links
        ignore-junction-blocker waiting-time-memory startup-wait-threshold sloppy-insert
        eager-insert emergency-insert insertion-checks lanechange.duration lanechange.overtake-right
        tls.actuated.jam-threshold tls.actuated.detector-length
        tls.delay_based.detector-range tls.yellow.min-decel
        railsignal-moving-block|railsignal.moving-block railsignal.moving-block.default-classes
        railsignal.moving-block.max-dist railsignal.max-block-length railsignal.default-classes
        slope-centered time-to-impatience default.departspeed default.departlane
        default.action-step-length default.carfollowmodel|carfollow.model default.speeddev
        default.emergencydecel parking.maneuver pedestrian.model pedestrian.timegap-crossing
        pedestrian.striping.stripe-width pedestrian.striping.dawdling
        pedestrian.striping.mingap-to-vehicle pedestrian.striping.jamtime
        pedestrian.striping.jamtime.crossing pedestrian.striping.jamtime.narrow
        pedestrian.striping.jamfactor pedestrian.striping.reserve-oncoming
        pedestrian.striping.reserve-oncoming.junctions pedestrian.striping.reserve-oncoming.max
        pedestrian.striping.legacy-departposlat pedestrian.striping.walkingarea-detail
        pedestrian.jupedsim.step-length pedestrian.jupedsim.exit-tolerance pedestrian.jupedsim.model
        pedestrian.jupedsim.strength-neighbor-repulsion pedestrian.jupedsim.range-neighbor-repulsion
        pedestrian.jupedsim.strength-geometry-repulsion pedestrian.jupedsim.range-geometry-repulsion
        """,
    ),
    Group(
        "noted",
        "they weight the routing of trips, for which SUMO uses its defaults here",
        """
        weight-files|w|weights weight-attribute|measure|x=traveltime weights.random-factor=1
        weights.random-factor.dynamic=false weights.minor-penalty=1.5 weights.tls-penalty=0
        weights.priority-factor=0 weights.separate-turns=0 weights.turnaround-penalty=5
        """,
    ),
    Group(
        "sumo",
        "jammed vehicles stay, unless the configuration sets a teleporting time; this and "
        "collision options are passed to SUMO",
        """
        time-to-teleport time-to-teleport.highways time-to-teleport.highways.min-speed
        time-to-teleport.disconnected time-to-teleport.ride time-to-teleport.bidi
        time-to-teleport.railsignal-deadlock ignore-accidents collision.action
        intermodal-collision.action collision.stoptime intermodal-collision.stoptime
        collision.check-junctions collision.check-junctions.mingap collision.mingap-factor
        """,
    ),
    Group(
        "noted",
        "no vehicle is removed, kept outside or departs at another time",
        """
        keep-after-arrival=0 max-num-vehicles=-1 max-num-teleports=-1 time-to-teleport.remove=false
        time-to-teleport.remove-constraint=false max-depart-delay=-1 random-depart-offset=0
        ride.stop-tolerance=10
        """,
    ),
    Group(
        "sumo",
        "SUMO sends vehicles elsewhere during the run as they say",
        """
        device.rerouting.probability device.rerouting.deterministic
        device.rerouting.period|device.routing.period
        device.rerouting.pre-period|device.routing.pre-period
        device.rerouting.adaptation-weight|device.routing.adaptation-weight
        device.rerouting.adaptation-steps|device.routing.adaptation-steps
        device.rerouting.adaptation-interval|device.routing.adaptation-interval
        device.rerouting.cch-update-threshold.factor device.rerouting.cch-update-threshold.constant
        device.rerouting.cch-ensemble device.rerouting.threshold.factor
        device.rerouting.threshold.constant device.rerouting.invalidation device.rerouting.mode
        device.rerouting.synchronize device.rerouting.railsignal device.rerouting.bike-speeds
        """,
    ),
    Group(
        "noted",
        "they are about persons and devices of vehicles",
        """
        persontrip.walkfactor=0.75 persontrip.transfer.car-walk=parkingAreas
        persontrip.transfer.taxi-walk persontrip.transfer.walk-taxi persontrip.default.group
        persontrip.taxi.waiting-time=300 persontrip.ride-public-line=false replay-rerouting=false
        device.rerouting.explicit|device.rerouting.knownveh
        device.rerouting.with-taz|device.routing.with-taz|with-taz=false
        device.rerouting.init-with-loaded-weights=false
        person-device.rerouting.probability=-1
        person-device.rerouting.explicit|person-device.rerouting.knownveh
        person-device.rerouting.deterministic=false
        person-device.rerouting.period|person-device.routing.period=0 person-device.rerouting.mode=0
        person-device.rerouting.scope=stage device.stationfinder.probability=-1
        device.stationfinder.explicit|device.stationfinder.knownveh
        device.stationfinder.deterministic=false device.stationfinder.rescueTime=1800
        device.stationfinder.rescueAction=remove device.stationfinder.reserveFactor=1.1
        device.stationfinder.emptyThreshold=0.05 device.stationfinder.radius=180
        device.stationfinder.maxEuclideanDistance=-1 device.stationfinder.repeat=60
        device.stationfinder.chargeType=charging device.stationfinder.waitForCharge=600
        device.stationfinder.minOpportunityDuration=3600
        device.stationfinder.saturatedChargeLevel=0.8 device.stationfinder.needToChargeLevel=0.4
        device.stationfinder.opportunisticChargeLevel=0 device.stationfinder.replacePlannedStop=0
        device.stationfinder.maxDistanceToReplacedStop=300
        device.stationfinder.chargingStrategy=none device.stationfinder.checkEnergyForRoute=true
        device.toc.probability=-1 device.toc.explicit|device.toc.knownveh
        device.toc.deterministic=false device.toc.manualType device.toc.automatedType
        device.toc.responseTime=-1 device.toc.recoveryRate=0.1 device.toc.lcAbstinence=0
        device.toc.initialAwareness=0.5 device.toc.mrmDecel=1.5 device.toc.dynamicToCThreshold=0
        device.toc.dynamicMRMProbability=0.05 device.toc.mrmKeepRight=false device.toc.mrmSafeSpot
        device.toc.mrmSafeSpotDuration=60 device.toc.maxPreparationAccel=0
        device.toc.ogNewTimeHeadway=-1 device.toc.ogNewSpaceHeadway=-1 device.toc.ogMaxDecel=-1
        device.toc.ogChangeRate=-1 device.toc.useColorScheme=true device.toc.file
        device.driverstate.probability=-1 device.driverstate.explicit|device.driverstate.knownveh
        device.driverstate.deterministic=false device.driverstate.initialAwareness=1
        device.driverstate.errorTimeScaleCoefficient=100
        device.driverstate.errorNoiseIntensityCoefficient=0.2
        device.driverstate.speedDifferenceErrorCoefficient=0.15
        device.driverstate.headwayErrorCoefficient=0.75
        device.driverstate.freeSpeedErrorCoefficient=0
        device.driverstate.speedDifferenceChangePerceptionThreshold=0.1
        device.driverstate.headwayChangePerceptionThreshold=0.1 device.driverstate.minAwareness=0.1
        device.driverstate.maximalReactionTime=-1 device.bluelight.probability=-1
        device.bluelight.explicit|device.bluelight.knownveh device.bluelight.deterministic=false
        device.bluelight.reactiondist=25 device.bluelight.mingapfactor=1 device.taxi.probability=-1
        device.taxi.explicit|device.taxi.knownveh device.taxi.deterministic=false
        device.taxi.dispatch-algorithm=greedy device.taxi.dispatch-algorithm.output
        device.taxi.dispatch-algorithm.params device.taxi.dispatch-period=60
        device.taxi.dispatch-keep-unreachable=3600 device.taxi.idle-algorithm=stop
        device.taxi.idle-algorithm.output device.taxi.vclasses|taxi.vclasses=taxi
        device.glosa.probability=-1 device.glosa.explicit|device.glosa.knownveh
        device.glosa.deterministic=false device.glosa.range=100 device.glosa.max-speedfactor=1.1
        device.glosa.min-speed=5 device.glosa.add-switchtime=0 device.glosa.use-queue=false
        device.glosa.override-safety=false device.glosa.ignore-cfmodel=false
        device.fcd-replay.probability=-1 device.fcd-replay.explicit|device.fcd-replay.knownveh
        device.fcd-replay.deterministic=false device.fcd-replay.files|device.fcd-replay.file
        device.fcd-replay.consistency=all
        """,
    ),
    Group("noted", "signals are what is controlled here, so they stay on", "tls.all-off=false"),
    Group(
        "noted",
        "the model is chosen by --simulator",
        """
        mesosim=false meso-ltm=false meso-edgelength=98 meso-tauff=1.13 meso-taufj=1.13
        meso-taujf=1.73 meso-taujj=1.4 meso-jam-threshold=-1 meso-multi-queue=true
        meso-lane-queue=false
        meso-ignore-lanes-by-vclass|meso.ignore-lanes.by-vclass=pedestrian,bicycle
        meso-junction-control=false meso-junction-control.limited=false meso-tls-penalty=0
        meso-tls-flow-penalty=0 meso-minor-penalty=0 meso-overtaking=false meso-recheck=0
        meso-interpolate-pos=false
        """,
    ),
    Group(
        "refused",
        "a run begins with an empty network, so vehicles under way are not known",
        """
        load-state
        """,
    ),
)
"""All of them."""


def _by_name() -> dict[str, SumoOption]:
    found = {}
    for group in GROUPS:
        for word in group.names.split():
            names, _, default = word.partition("=")
            name, *others = names.split("|")
            option = SumoOption(name, group.treatment, group.reason, default)
            found.update(dict.fromkeys((name, *others), option))
    return found


OPTIONS: dict[str, SumoOption] = _by_name()
"""Every name and other name to its option."""
