"""A data set with its evaluation at more training sizes than the protocol has, from which all figures are drawn."""

from __future__ import annotations

from dataclasses import dataclass, replace

from spherefunc_bullet.batch.simulated import Simulated
from spherefunc_bullet.clouds.cloud import Cloud
from spherefunc_bullet.learning.method import Method
from spherefunc_bullet.settling.cached_runs import DropConfig

from ..evaluation.evaluation import Evaluation
from ..evaluation.protocol import Labels, Protocol, labels_of, require_enough
from ..evaluation.readings import spheres_read

LADDER = (5, 10, 20, 30, 45, 65, 85, 125, 175, 250, 350, 500, 700, 1000)  # training sizes, the paper's among them
APART = 0.9  # of the last size: one nearer to it would only crowd the figure


@dataclass(frozen=True, kw_only=True)
class EvaluatedData:
    """A data set's objects with their evaluation."""

    simulated: Simulated
    drop_config: DropConfig
    protocol: Protocol  # its training sizes are those of the confusion matrices
    evaluation: Evaluation  # at the training sizes of the learning curve

    @property
    def name(self) -> str:
        return self.simulated.name

    @property
    def radii(self) -> tuple[float, ...]:
        """Metres, ascending."""
        return self.drop_config.radii

    @property
    def labels(self) -> Labels:
        return self.evaluation.labels

    @property
    def half(self) -> int:
        """The largest number of training examples."""
        return self.evaluation.halves[0]

    def cloud(self, index: int) -> Cloud:
        """Return an object's cloud, on which the spheres were dropped."""
        return self.drop_config.cloud(self.simulated.objects[index].path)


def evaluate_data(simulated: Simulated, drop_config: DropConfig, method: Method, protocol: Protocol) -> EvaluatedData:
    """Return a data set with its evaluation, at more training sizes than the protocol has, and each object left out.

    Raises
    ------
    InputError
        If all objects have one label, or there are too few.
    """
    labels = labels_of(simulated)
    require_enough(simulated.name, len(labels))
    sizes = tuple(ladder(len(labels), protocol.train_sizes))
    splits = replace(protocol, train_sizes=sizes, leave_one_out=True).splits(labels)
    evaluation = spheres_read(simulated, drop_config.radii, method).evaluation(splits)
    return EvaluatedData(simulated=simulated, drop_config=drop_config, protocol=protocol, evaluation=evaluation)


def ladder(count: int, sizes: tuple[int, ...]) -> list[int]:
    """Return the training sizes of the learning curve: up to half of the objects, ``sizes`` among them."""
    half = count // 2
    return sorted({half, *sizes, *(size for size in LADDER if size < APART * half)})
