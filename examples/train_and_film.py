"""Train on YMCA, print the result, save the run and make its video.

python examples/train_and_film.py
"""

import mpma_mj
from mpma_mj.cli import main

run = mpma_mj.imitate("ymca", seed=0)
print(f"p_e {run.summary['p_e_percent']:.2f} % after {run.summary['epochs']} epochs")
folder = run.save("runs/example", overwrite=True)
main(["play", str(folder), "--out", "dance.mp4"])
