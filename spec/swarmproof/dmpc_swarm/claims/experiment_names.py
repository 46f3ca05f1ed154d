"""The experiments of DMPC-Swarm's Section 5, as they are called here."""

from __future__ import annotations

#: Fig. 3b, Fig. 3c, Fig. 4, and independent loss.
EXPERIMENT_NAMES = ("fig3b", "fig3c", "fig4", "loss")
