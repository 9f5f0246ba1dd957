"""Follow a run in TensorBoard and in Weights & Biases: both write files, and nothing leaves this machine."""

import wandb
from tensorboardX import SummaryWriter

import driftform as df

study = df.load_study("paper", run={"seed": 1, "evaluations": 60, "robust": 0})
board = SummaryWriter("board")
log = wandb.init(project="driftform", dir=".", mode="offline")
best = dict.fromkeys(study.scenario.targets, 0.0)


def follow(first, evaluations):
    """Write the best fitness of each target after a batch."""
    for evaluation in evaluations:
        for target, fitness in zip(best, evaluation.fitness.tolist(), strict=True):
            best[target] = max(best[target], fitness)
    done = first + len(evaluations)
    for target, fitness in best.items():
        board.add_scalar(f"best/{target}", fitness, done)
    log.log({f"best/{target}": fitness for target, fitness in best.items()}, step=done)


df.evolve(study, "runs/followed", progress=False, on_batch=follow)
board.close()
log.finish()
print(f"TP1: {best['TP1']:.2f} %")
