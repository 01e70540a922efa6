"""Searches the model of `tests.rs` by Optuna's NSGA-II: python3 optuna.py POINTS SEEDS prints a line for every point."""

import math
import sys

import optuna

LANES = {"slow": (0.6, 0.7), "plain": (1.0, 1.0), "fast": (1.3, 1.6), "huge": (1.35, 3.0)}
NONE = (1e9, 1e9)


def figures(cache, cols, latency, rows, units):
    if rows > 2 * cols and rows >= 4:
        return NONE
    speed, size = LANES[units]
    time = max(64 / (rows * cols), 4) / speed + latency + 4 / cache + abs(rows - cols) * 0.1
    return time, rows * cols * size * (1 + 4 / latency) + cache / 2


def main():
    points, seeds = int(sys.argv[1]), int(sys.argv[2])
    optuna.logging.set_verbosity(optuna.logging.ERROR)
    for seed in range(seeds):
        sampler = optuna.samplers.NSGAIISampler(seed=seed, population_size=math.ceil(math.sqrt(points)))
        study = optuna.create_study(directions=["minimize", "minimize"], sampler=sampler)
        for _ in range(points):
            trial = study.ask()
            chosen = {
                "cache": 2 ** trial.suggest_int("cache", 0, 5),
                "cols": trial.suggest_int("cols", 1, 8),
                "latency": trial.suggest_int("latency", 2, 8),
                "rows": trial.suggest_int("rows", 1, 8),
                "units": trial.suggest_categorical("units", list(LANES)),
            }
            study.tell(trial, figures(**chosen))
            chosen["cache"] = f"{chosen['cache']}K"
            print(seed, *(f"{name}={value}" for name, value in chosen.items()))


if __name__ == "__main__":
    main()
