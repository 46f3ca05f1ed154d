"""The experiments that can be reproduced, by name."""

from __future__ import annotations

from collections.abc import Callable

from swarmproof.dmpc_swarm.claims.experiment_names import EXPERIMENT_NAMES
from swarmproof.dmpc_swarm.experiments.experiment import Experiment
from swarmproof.dmpc_swarm.experiments.formations import fig3b, fig3c
from swarmproof.dmpc_swarm.experiments.jams import fig4
from swarmproof.dmpc_swarm.experiments.loss import loss

#: From its name; called with whether it is to be quick.
EXPERIMENTS: dict[str, Callable[[bool], Experiment]] = dict(
    zip(EXPERIMENT_NAMES, (fig3b, fig3c, fig4, loss), strict=True)
)
