"""All pictures of an experiment as it was chosen to be flown."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from swarmproof.dmpc_swarm.pages.experiments.drawing import Picture
from swarmproof.dmpc_swarm.pages.experiments.formations_plots import fig3b_pictures, fig3c_pictures
from swarmproof.dmpc_swarm.pages.experiments.jam_plots import fig4_pictures
from swarmproof.dmpc_swarm.pages.experiments.loss_plots import loss_pictures
from swarmproof.dmpc_swarm.pages.experiments.numbers import Data

_PICTURES: Mapping[str, Callable[[Data], list[Picture]]] = {
    "fig3b": fig3b_pictures,
    "fig3c": fig3c_pictures,
    "fig4": fig4_pictures,
    "loss": loss_pictures,
}


def pictures(data: Data) -> list[Picture]:
    """Return the pictures of an experiment; matplotlib must be there."""
    return _PICTURES[data.experiment.name](data)
